#include "pyramid/tile_maker.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "pyramid/geometric_error.h"

namespace tellurion::pyramid {

bool TileTask::hasChildren() const {
  return std::ranges::any_of(children, [](const auto& child) { return child.has_value(); });
}

TileMaker::Made TileMaker::makeTile(const TileTask& task) {
  return plan_.meta.kind == raster::Kind::elevation ? makeElevation(task) : makeImagery(task);
}

io::Result<MadeTiles> TileMaker::make(const TileTask& task) {
  auto tile = makeTile(task);
  if (!tile) return tl::unexpected(tile.error());
  MadeTiles made{.records = {}, .candidates = 1};
  if (*tile) made.records.push_back(std::move((*tile)->record));
  return made;
}

/// A tile and those below it, without payloads.
struct TileMaker::Family {
  KnownTile tile;
  std::vector<KnownTile> below;  ///< elevation: down to kComparedLevels
};

io::Result<std::optional<TileMaker::Family>> TileMaker::makeFamily(const Candidate& candidate, MadeTiles& made) {
  TileTask task{
      .id = candidate.id, .inputs = candidate.inputs, .children = {}, .childDepths = {}, .beyond = {}, .deeper = {}};
  if (candidate.id.level < plan_.deepestLevel) {
    TileWalk walk(plan_, inputs_, candidate);
    while (true) {
      const auto child = walk.next();
      if (!child) return tl::unexpected(child.error());
      if (!*child) break;
      auto family = makeFamily(**child, made);
      if (!family) return tl::unexpected(family.error());
      if (!*family) continue;
      std::ranges::move((*family)->below, std::back_inserter(task.deeper));
      task.children[static_cast<std::size_t>((*child)->id.quadrant())] = std::move((*family)->tile);
    }
  }
  auto tile = makeTile(task);
  if (!tile) return tl::unexpected(tile.error());
  made.candidates += 1;
  if (!*tile) return std::optional<Family>{};
  Family family{.tile = std::move(**tile), .below = {}};
  TileRecord kept = family.tile.record;
  kept.payload.clear();
  made.records.push_back(std::exchange(family.tile.record, std::move(kept)));
  if (plan_.meta.kind != raster::Kind::elevation) return std::optional(std::move(family));
  family.below = std::move(task.deeper);
  for (auto& child : task.children) {
    if (child) family.below.push_back(std::move(*child));
  }
  std::erase_if(family.below, [&](const KnownTile& known) {
    return known.record.id.level - candidate.id.level >= kComparedLevels;  // of no use to the parent
  });
  return std::optional(std::move(family));
}

io::Result<MadeTiles> TileMaker::makeBlock(const Candidate& candidate) {
  MadeTiles made;
  auto family = makeFamily(candidate, made);
  if (!family) return tl::unexpected(family.error());
  return made;
}

}  // namespace tellurion::pyramid
