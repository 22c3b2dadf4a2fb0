#include "scene/select.h"

#include <utility>

#include "scene/cut_collection.h"
#include "scene/cut_growth.h"

namespace tellurion::scene {
void clear(Selection& out) {
  Selection fresh;
  std::swap(fresh.drawn, out.drawn);
  std::swap(fresh.joined, out.joined);
  std::swap(fresh.soon, out.soon);
  std::swap(fresh.wanted, out.wanted);
  std::swap(fresh.rootShares, out.rootShares);
  fresh.drawn.clear();
  fresh.joined.clear();
  fresh.soon.clear();
  fresh.wanted.clear();
  fresh.rootShares.clear();
  out = std::move(fresh);
}

struct Selector::Work {
  tiling::Tiling tiling;
  geo::Ellipsoid ellipsoid;
  GrowthBuffers growth;
  CollectionBuffers collection;
  Selection out;
};

Selector::Selector(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid)
    : work_(std::make_unique<Work>(Work{.tiling = tiling, .ellipsoid = ellipsoid})) {}
Selector::~Selector() = default;
Selector::Selector(Selector&&) noexcept = default;
Selector& Selector::operator=(Selector&&) noexcept = default;

const Selection& Selector::select(const View& view, const CutOptions& options, double occluderDepth_m, TileTree& tree,
                                  const CutHistory* history) {
  if (!options.morph) history = nullptr;
  Work& work = *work_;
  clear(work.out);
  const CutSight sight(view, work.ellipsoid, options, occluderDepth_m, options.morph,
                       options.morph && history == nullptr, history != nullptr ? history->leeway : Leeway{});
  const CutPast past(history);
  growCut({.tiling = work.tiling, .options = options, .sight = sight, .past = past, .tree = tree}, work.growth,
          work.out);
  sortWanted(work.out.wanted);
  collectCut(options, history, view.pixelAngle(), work.growth.forest, work.collection, work.out);
  return work.out;
}

const Selection& Selector::goOn(double steps, CutMemory& memory) {
  Work& work = *work_;
  memory.corners.goOn(static_cast<float>(steps));
  moveOn(memory.corners, work.collection, work.out);
  return work.out;
}

Selection select(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const View& view,
                 const CutOptions& options, double occluderDepth_m, TileTree& tree, const CutHistory* history) {
  return Selector(tiling, ellipsoid).select(view, options, occluderDepth_m, tree, history);
}

}  // namespace tellurion::scene
