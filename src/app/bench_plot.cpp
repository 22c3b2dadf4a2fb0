#include "app/bench_plot.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/svg_plot.h"

namespace tellurion::app {
namespace {

template <typename Of>
PlotSeries seriesOf(std::string name, const std::vector<FrameFigures>& frames, const Of& of) {
  PlotSeries series{.name = std::move(name), .values = {}};
  for (const FrameFigures& frame : frames)
    series.values.push_back(static_cast<double>(of(frame)));
  return series;
}

/// A series for each level that any frame draws, the coarsest first.
std::vector<PlotSeries> tilesALevel(const std::vector<FrameFigures>& frames) {
  std::vector<PlotSeries> series;
  for (std::size_t level = 0; level < FrameFigures{}.scene.tilesALevel.size(); ++level) {
    PlotSeries s = seriesOf(fmt::format("level {}", level), frames,
                            [level](const FrameFigures& f) { return f.scene.tilesALevel[level]; });
    if (std::ranges::any_of(s.values, [](double tiles) { return tiles > 0.0; })) series.push_back(std::move(s));
  }
  return series;
}

}  // namespace

std::string benchPlot(const std::string& title, const std::string& subtitle, const std::vector<FrameFigures>& frames) {
  PlotPage page{.title = title, .subtitle = subtitle, .times = {}, .panels = {}};
  for (const FrameFigures& frame : frames)
    page.times.push_back(frame.time_s);
  const auto one = [&](const char* name, const auto& of) { return std::vector{seriesOf(name, frames, of)}; };
  page.panels.push_back(
      {.title = "Frame time",
       .unit = "ms",
       .series = {seriesOf("whole frame", frames, [](const FrameFigures& f) { return f.frame_ms; }),
                  seriesOf("update", frames, [](const FrameFigures& f) { return f.scene.update_ms; }),
                  seriesOf("uploads", frames, [](const FrameFigures& f) { return f.render.upload_ms; })}});
  page.panels.push_back({.title = "Quality", .unit = "1: full", .series = one("quality", [](const FrameFigures& f) {
                                                                  return f.quality;
                                                                })});
  page.panels.push_back({.title = "Tiles wanted but missing",
                         .unit = "tiles",
                         .series = one("wanted", [](const FrameFigures& f) { return f.scene.tilesWanted; })});
  page.panels.push_back(
      {.title = "Tiles drawn, by level", .unit = "tiles", .series = tilesALevel(frames), .stacked = true});
  page.panels.push_back(
      {.title = "Triangles", .unit = "thousands", .series = one("triangles", [](const FrameFigures& f) {
                                                    return static_cast<double>(f.render.triangles) / 1e3;
                                                  })});
  constexpr double kMebi = 0x1p20;
  page.panels.push_back({.title = "GPU memory", .unit = "MiB", .series = one("GPU", [](const FrameFigures& f) {
                                                                 return static_cast<double>(f.render.gpuBytes) / kMebi;
                                                               })});
  return svgOf(page);
}

}  // namespace tellurion::app
