#include "scene/tiles_ahead.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace tellurion::scene {
namespace {

constexpr double kEach_s = 0.1;
constexpr double kMostOfOne = 0.25;  ///< of a cut in an update: frames that take long do not take longer for it
constexpr std::size_t kMost = 64;
constexpr double kLess = 1e-19;  ///< a picture's own wants differ by less

}  // namespace

void TilesAhead::look(const std::optional<View>& expected, const CutOptions& options, TileForest& forest) {
  const std::optional<double> before_s = std::exchange(lookedAt_s_, options.time_s);
  if (!expected) {
    found_.clear();
    cut_.reset();
    begun_s_.reset();
    return;
  }
  const double now_s = *options.time_s;
  const bool isDue = !begun_s_ || now_s < *begun_s_ || now_s >= *begun_s_ + kEach_s;
  if (isDue && !cut_) begin(*expected, options, forest);
  if (!cut_) return;
  const double since_s = before_s ? std::max(now_s - *before_s, 0.0) : kEach_s;
  goOn(std::min(since_s / kEach_s, kMostOfOne), forest);
}

void TilesAhead::begin(const View& expected, const CutOptions& options, TileForest& forest) {
  begun_s_ = options.time_s;
  const ContentMaker& maker = forest.maker();
  cut_.emplace(
      Cut{.options = options,
          .sight = CutSight(expected, maker.ellipsoid, options, forest.occluderDepth_m(), options.morph, false),
          .begunIn = forest.updates()});
  clear(out_);
  steps_ = 0;
  const CutPast past(nullptr);
  growRoots({.tiling = maker.tiling, .options = cut_->options, .sight = cut_->sight, .past = past, .tree = forest},
            growth_, out_);
}

/// Such a share of a cut as large as the last one.
void TilesAhead::goOn(double share, TileForest& forest) {
  constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
  constexpr double kLeast = 16.0;
  const bool isFirst = lastSteps_ == kAll;
  const std::size_t most = isFirst ? kAll : static_cast<std::size_t>(share * static_cast<double>(lastSteps_) + kLeast);
  const CutPast past(nullptr);
  const std::size_t done = growOn(
      {.tiling = forest.maker().tiling, .options = cut_->options, .sight = cut_->sight, .past = past, .tree = forest},
      most, growth_, out_);
  steps_ += done;
  if (done == most) return;
  lastSteps_ = steps_;
  cut_.reset();
  sortWanted(out_.wanted);
  found_.assign(out_.wanted.begin(),
                out_.wanted.begin() + static_cast<std::ptrdiff_t>(std::min(out_.wanted.size(), kMost)));
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
