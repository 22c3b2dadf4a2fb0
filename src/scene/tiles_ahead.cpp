#include "scene/tiles_ahead.h"

#include <algorithm>
#include <iterator>

namespace tellurion::scene {
namespace {

constexpr double kEach_s = 0.1;
constexpr std::size_t kMost = 64;
constexpr double kLess = 1e-19;  ///< a picture's own wants differ by less

}  // namespace

void TilesAhead::look(const std::optional<View>& expected, const CutOptions& options, TileForest& forest) {
  if (!expected) {
    found_.clear();
    lookedAt_s_.reset();
    return;
  }
  if (lookedAt_s_ && *options.time_s >= *lookedAt_s_ && *options.time_s < *lookedAt_s_ + kEach_s) return;
  lookedAt_s_ = options.time_s;
  const std::vector<WantedTile>& wanted = selector_.select(*expected, options, forest.occluderDepth_m(), forest).wanted;
  found_.assign(wanted.begin(), wanted.begin() + static_cast<std::ptrdiff_t>(std::min(wanted.size(), kMost)));
  for (WantedTile& tile : found_)
    tile.priority *= kLess;
}

/// Since they were found, some may have come, and parents may have been dropped.
std::span<const WantedTile> TilesAhead::wanted(const TileForest& forest) {
  wanted_.clear();
  std::ranges::copy_if(found_, std::back_inserter(wanted_), [&](const WantedTile& tile) {
    const TileRecord* record = forest.find(tile.id);
    const TileRecord* parent = tile.id.level > 0 ? forest.find(tile.id.parent()) : nullptr;
    return (record == nullptr || !record->content || record->isStandIn) &&
           (tile.id.level == 0 || (parent != nullptr && parent->content && !parent->isStandIn));
  });
  return wanted_;
}

}  // namespace tellurion::scene
