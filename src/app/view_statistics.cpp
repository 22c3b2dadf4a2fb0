#include "app/view_statistics.h"

#include <fmt/format.h>

namespace tellurion::app {
namespace {

std::string milliseconds(double ms) {
  return fmt::format("{:.2f} ms", ms);
}

std::string mebibytes(std::uint64_t bytes) {
  constexpr double kMebi = 1024.0 * 1024.0;
  return fmt::format("{:.1f} MiB", static_cast<double>(bytes) / kMebi);
}

/// The coarsest and the deepest that are drawn.
std::string levels(const scene::FrameStatistics& statistics) {
  int first = -1;
  int last = -1;
  for (int level = 0; level < static_cast<int>(statistics.tilesALevel.size()); ++level) {
    if (statistics.tilesALevel[static_cast<std::size_t>(level)] == 0) continue;
    if (first < 0) first = level;
    last = level;
  }
  return first < 0 ? "none" : fmt::format("{} to {}", first, last);
}

}  // namespace

std::vector<Figure> statisticsLines(const FrameFigures& f, bool automaticQuality) {
  return {
      {"tiles drawn", fmt::format("{}", f.render.tilesDrawn)},
      {"levels", levels(f.scene)},
      {"tiles visited", fmt::format("{}", f.scene.tilesVisited)},
      {"out of the picture", fmt::format("{}", f.scene.tilesCulledFrustum)},
      {"beyond the horizon", fmt::format("{}", f.scene.tilesCulledHorizon)},
      {"tiles wanted", fmt::format("{}", f.scene.tilesWanted)},
      {"tiles held back", fmt::format("{}", f.scene.tilesHeldBack)},
      {"largest error", fmt::format("{:.2f} px", f.scene.maxScreenError_px)},
      {"quality", fmt::format("{:.2f}{}", f.quality, automaticQuality ? ", automatic" : "")},
      {"triangles", fmt::format("{}", f.render.triangles)},
      {"draw calls", fmt::format("{}", f.render.drawCalls)},
      {"uploads", fmt::format("{}, {}", f.render.uploads, mebibytes(f.render.uploadBytes))},
      {"update", milliseconds(f.scene.update_ms)},
      {"draw", milliseconds(f.frame_ms - f.scene.update_ms)},
      {"on the GPU", mebibytes(f.render.gpuBytes)},
      {"in the cache", mebibytes(f.scene.cpuCacheBytes)},
      {"requests", fmt::format("{}, {} failed", f.scene.requests, f.scene.failedRequests)},
      {"layers coming", fmt::format("{}", f.scene.layersComing)},
  };
}

}  // namespace tellurion::app
