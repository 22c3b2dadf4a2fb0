#include "app/frame_figures.h"

#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>

namespace tellurion::app {
namespace {

using Json = nlohmann::ordered_json;

/// The names are the command line's contract.
Json fieldsOf(const FrameFigures& f) {
  return {{"frame_ms", f.frame_ms},
          {"update_ms", f.scene.update_ms},
          {"upload_ms", f.render.upload_ms},
          {"upload_bytes", f.render.uploadBytes},
          {"tiles_drawn", f.render.tilesDrawn},
          {"triangles", f.render.triangles},
          {"draw_calls", f.render.drawCalls},
          {"max_screen_error_px", f.scene.maxScreenError_px},
          {"capped_by_budget", f.scene.cappedByBudget},
          {"quality", f.quality},
          {"complete", f.complete},
          {"tiles_wanted", f.scene.tilesWanted},
          {"tiles_held_back", f.scene.tilesHeldBack},
          {"tiles_visited", f.scene.tilesVisited},
          {"cut_age", f.scene.cutAge},
          {"tiles_culled_frustum", f.scene.tilesCulledFrustum},
          {"tiles_culled_horizon", f.scene.tilesCulledHorizon},
          {"gpu_bytes", f.render.gpuBytes},
          {"cpu_cache_bytes", f.scene.cpuCacheBytes},
          {"cpu_cache_over_bytes", f.scene.cpuCacheOver_bytes},
          {"requests", f.scene.requests},
          {"failed_requests", f.scene.failedRequests},
          {"layers_coming", f.scene.layersComing},
          {"layer_changes", f.layerChanges},
          {"resolution", f.resolution}};
}

}  // namespace

FrameFigures drawMeasured(render::Renderer& renderer, const render::RenderTarget& target, const scene::Frame& frame) {
  const auto start = std::chrono::steady_clock::now();
  const render::RenderStatistics drawn = renderer.draw(frame, target);
  render::finish();
  const std::chrono::duration<double, std::milli> drawing = std::chrono::steady_clock::now() - start;
  return {.frame_ms = frame.statistics.update_ms + drawing.count(),
          .scene = frame.statistics,
          .render = drawn,
          .complete = frame.complete && frame.statistics.failures == 0};
}

scene::FrameCost costOf(const FrameFigures& figures, double time_s) {
  constexpr double kMuchUploading = 0.25;
  constexpr int kHardlyMissing = 20;  // one in so many
  return {.time_s = time_s,
          .cost_ms = figures.frame_ms,
          .isRepresentative = figures.render.upload_ms < kMuchUploading * figures.frame_ms,
          .isWhole = kHardlyMissing * figures.scene.tilesWanted <= static_cast<int>(figures.render.tilesDrawn)};
}

std::string jsonOf(const FrameFigures& figures) {
  Json json = fieldsOf(figures);
  json["tiles_a_level"] = figures.scene.tilesALevel;
  return json.dump(2) + "\n";
}

std::string csvHeader() {
  std::string line = "time_s";
  const Json fields = fieldsOf({});
  for (const auto& field : fields.items())
    line += "," + field.key();
  for (std::size_t level = 0; level < FrameFigures{}.scene.tilesALevel.size(); ++level)
    line += fmt::format(",level_{}", level);
  return line + "\n";
}

std::string csvLine(const FrameFigures& figures) {
  std::string line = fmt::format("{:.4f}", figures.time_s);
  const Json fields = fieldsOf(figures);
  for (const auto& field : fields.items())
    line += "," + field.value().dump();
  for (const int tiles : figures.scene.tilesALevel)
    line += fmt::format(",{}", tiles);
  return line + "\n";
}

}  // namespace tellurion::app
