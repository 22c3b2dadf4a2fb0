#include "scene/generation.h"

#include <algorithm>
#include <utility>

namespace tellurion::scene {

const Selection& Generation::cut(const View& view, const CutOptions& options, double exaggeration,
                                 std::span<const LayerLook> looks, const Residency* gpu) {
  forest.begin(exaggeration, looks, gpu);
  loading.receive();
  const CutHistory* history = historyAt(options);
  const Selection& selection = selector_.select(view, options, forest.occluderDepth_m(), forest, history);
  rootShares_ = selection.rootShares;
  return selection;
}

bool Generation::rootsAreDrawable() const {
  for (int root = 0; root < forest.maker().tiling.rootCount(); ++root) {
    const TileRecord* record = forest.find({.level = 0, .root = static_cast<std::uint8_t>(root)});
    if (record == nullptr || !record->drawable) return false;
  }
  return true;
}

bool Generation::lacksRoots() const {
  for (std::size_t root = 0; root < rootShares_.size(); ++root) {
    const TileRecord* record = forest.find({.level = 0, .root = static_cast<std::uint8_t>(root)});
    if (rootShares_[root] > 0.0 && (record == nullptr || !record->drawable || record->isStandIn)) return true;
  }
  return false;
}

/// Updates at one time all start from what was drawn at the time before, so that the last of them, when all has come,
/// does not depend on the order of arrivals.
const CutHistory* Generation::historyAt(const CutOptions& options) {
  if (!options.time_s || !options.morph) {
    time_s_ = lastTime_s_ = std::nullopt;
    for (CutMemory& memory : memories_) {
      memory.clear();
      memory.corners.clear();
    }
    return nullptr;
  }
  if (time_s_ != options.time_s) {
    std::swap(memories_[0], memories_[1]);
    lastTime_s_ = std::exchange(time_s_, options.time_s);
  }
  history_.step = lastTime_s_ ? std::clamp((*time_s_ - *lastTime_s_) / options.fade_s, 0.0, 1.0) : 1.0;
  return &history_;
}

}  // namespace tellurion::scene
