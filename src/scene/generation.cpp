#include "scene/generation.h"

#include <algorithm>
#include <utility>

namespace tellurion::scene {

const Selection& Generation::cut(const View& view, const CutOptions& asked, double exaggeration,
                                 std::span<const LayerLook> looks, const Residency* gpu) {
  CutOptions options = asked;
  options.isNested = asked.isNested && groundIsNested_;
  forest.begin(exaggeration, looks, gpu);
  const std::uint64_t before = forest.contentBytes();
  loading.receive();
  if (forest.contentBytes() != before) lastArrival_ = std::chrono::steady_clock::now();
  const CutHistory* history = historyAt(options);
  const Selection& selection = selector_.select(view, options, forest.occluderDepth_m(), forest, history);
  rootShares_ = selection.rootShares;
  lastCut_ = &selection;
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

std::vector<const LayerTiles*> Generation::waitedFor() const {
  std::vector<const LayerTiles*> out;
  for (std::size_t i = 0; lastCut_ != nullptr && i < lastCut_->wanted.size(); ++i) {
    const TileRecord* record = forest.find(lastCut_->wanted[i].id);
    if (record == nullptr || !record->job) continue;
    for (const TileJob::Part& part : record->job->missing) {
      if (!part.fetch->isReady() && std::ranges::find(out, part.need.tiles) == out.end())
        out.push_back(part.need.tiles);
    }
  }
  return out;
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
