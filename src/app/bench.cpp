#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/bench_plot.h"
#include "app/frame_figures.h"
#include "app/output_names.h"
#include "app/progress.h"
#include "app/standard_output.h"
#include "app/studio.h"
#include "app/subcommands.h"
#include "io/output_file.h"
#include "raster/image_file.h"
#include "scene/camera_path.h"

namespace tellurion::app {
namespace {

constexpr std::array kPercentiles{50.0, 90.0, 95.0, 99.0, 100.0};

struct Arguments {
  PictureArguments picture;
  std::string path;
  std::string stats;
  std::string plot;
  std::string pictures;
  double fps = 0.0;           ///< frames begin no faster than that; 0: one after the other
  double layerChanges = 0.0;  ///< a second, in every other second
  bool json = false;
};

/// The smallest value that is not under `percent` of all (nearest rank); `sorted` is not empty.
double percentile(const std::vector<double>& sorted, double percent) {
  const auto rank = static_cast<std::size_t>(std::ceil(percent / 100.0 * static_cast<double>(sorted.size())));
  return sorted[std::max<std::size_t>(rank, 1) - 1];
}

/// Drags the top imagery layer's opacity to and fro, so many changes a second, in every other second of the path.
/// Returns how many changes this was since the time before.
int dragOpacity(scene::Globe& globe, double changes, double before_s, double now_s) {
  constexpr double kSteps = 30.0;  // from opaque to clear
  const bool isAtRest = static_cast<std::int64_t>(now_s) % 2 == 0;
  if (changes <= 0.0 || isAtRest || globe.imageryLooks().empty()) return 0;
  const double first = std::floor(std::max(before_s, std::floor(now_s)) * changes) + 1.0;
  const double last = std::floor(now_s * changes);
  double& opacity = globe.imageryLooks()[globe.imageryOrder().back()].opacity;
  for (double i = first; i <= last; ++i)
    opacity = std::abs(1.0 - std::fmod(i / kSteps, 2.0));
  return static_cast<int>(std::max(0.0, last - first + 1.0));
}

/// The frame of each second, a PNG named by its time, as long as all could be written.
class Pictures {
 public:
  explicit Pictures(std::string folder) : folder_(std::move(folder)) {}
  void take(const render::RenderTarget& target, double time_s) {
    if (folder_.empty() || !written_ || time_s < next_s_) return;
    next_s_ = std::floor(time_s) + 1.0;
    written_ = raster::writePng(std::filesystem::path(folder_) / fmt::format("{:09.3f}.png", time_s),
                                render::readColour(target));
  }
  const io::Result<void>& written() const { return written_; }

 private:
  std::string folder_;
  double next_s_ = 0.0;
  io::Result<void> written_;
};

/// Plays the path in real time: each frame shows where the camera is at the moment when the frame begins. There is
/// always a first frame, however early a stop is asked for.
io::Result<std::vector<FrameFigures>> play(Studio& studio, const scene::CameraPath& path, const Arguments& arguments,
                                           const std::stop_token& stop) {
  const PictureArguments& picture = arguments.picture;
  using Clock = std::chrono::steady_clock;
  std::vector<FrameFigures> frames;
  ProgressLine line("playing");
  scene::QualityControl control({.frame_ms = picture.frame_ms});
  double quality = picture.quality;
  Pictures pictures(arguments.pictures);
  double before_s = 0.0;
  std::optional<render::RenderTarget> target;
  const auto start = Clock::now();
  const auto goesOn = [&](scene::CameraPath::Seconds now) {
    return frames.empty() || (pictures.written() && now <= path.duration() && !stop.stop_requested());
  };
  for (scene::CameraPath::Seconds now{}; goesOn(now); now = Clock::now() - start) {
    const double resolution = scene::resolutionAt(quality / picture.quality, picture.resolution);
    const scene::View view =
        scene::atResolution(scene::viewOf(path.at(path.begin() + now), studio.globe->body().ellipsoid,
                                          picture.verticalFov(), picture.viewport()),
                            resolution);
    if (!target || target->size().width != view.viewport.width || target->size().height != view.viewport.height) {
      target.reset();
      auto made = render::RenderTarget::create(view.viewport);
      if (!made) return tl::unexpected(made.error());
      target = std::move(*made);
    }
    setClock(studio, now.count());
    scene::CutOptions cut = scene::atQuality(picture.cut(), quality);
    cut.time_s = now.count();
    const int changes = dragOpacity(*studio.globe, arguments.layerChanges, before_s, now.count());
    before_s = now.count();
    frames.push_back(
        drawMeasured(studio.renderer, *target, studio.globe->update(view, cut, &studio.renderer.residency())));
    frames.back().time_s = now.count();
    frames.back().quality = quality;
    frames.back().resolution = resolution;
    frames.back().layerChanges = changes;
    pictures.take(*target, now.count());
    const double done_s = std::chrono::duration<double>(Clock::now() - start).count();
    if (picture.automaticQuality) quality = control.next(costOf(frames.back(), done_s));
    if (arguments.fps > 0.0) {
      // As on a screen: who misses a beat begins with the next.
      const std::chrono::duration<double> beat((std::floor(done_s * arguments.fps) + 1.0) / arguments.fps);
      std::this_thread::sleep_until(start + std::chrono::duration_cast<Clock::duration>(beat));
    }
    line.show(static_cast<std::uint64_t>(now.count() * 1000),
              static_cast<std::uint64_t>(path.duration().count() * 1000) + 1, "ms");
  }
  if (!pictures.written()) return tl::unexpected(pictures.written().error());
  return frames;
}

std::vector<double> sorted(const std::vector<FrameFigures>& frames, double (*of)(const FrameFigures&)) {
  std::vector<double> all;
  for (const FrameFigures& frame : frames)
    all.push_back(of(frame));
  std::ranges::sort(all);
  return all;
}

double frameMilliseconds(const FrameFigures& frame) {
  return frame.frame_ms;
}

nlohmann::ordered_json summaryOf(const std::vector<FrameFigures>& frames, const scene::CameraPath& path,
                                 bool wasStopped) {
  const std::vector<double> frame_ms = sorted(frames, frameMilliseconds);
  const std::vector<double> update_ms = sorted(frames, [](const FrameFigures& f) { return f.scene.update_ms; });
  const std::vector<double> quality = sorted(frames, [](const FrameFigures& f) { return f.quality; });
  const auto most = [&](auto of) { return of(*std::ranges::max_element(frames, {}, of)); };
  nlohmann::ordered_json summary{{"frames", frames.size()},
                                 {"stopped", wasStopped},
                                 {"played_s", frames.back().time_s},
                                 {"path_s", path.duration().count()}};
  for (const double percent : kPercentiles)
    summary[percent == 100.0 ? "frame_ms_max" : fmt::format("frame_ms_p{:.0f}", percent)] =
        percentile(frame_ms, percent);
  for (const double percent : kPercentiles)
    summary[percent == 100.0 ? "update_ms_max" : fmt::format("update_ms_p{:.0f}", percent)] =
        percentile(update_ms, percent);
  summary["quality_p50"] = percentile(quality, 50.0);
  summary["quality_min"] = quality.front();
  summary["frames_complete"] = std::ranges::count(frames, true, &FrameFigures::complete);
  summary["triangles_max"] = most([](const FrameFigures& f) { return f.render.triangles; });
  summary["tiles_drawn_max"] = most([](const FrameFigures& f) { return f.render.tilesDrawn; });
  summary["draw_calls_max"] = most([](const FrameFigures& f) { return f.render.drawCalls; });
  summary["tiles_wanted_max"] = most([](const FrameFigures& f) { return f.scene.tilesWanted; });
  summary["upload_bytes_max"] = most([](const FrameFigures& f) { return f.render.uploadBytes; });
  summary["gpu_bytes_max"] = most([](const FrameFigures& f) { return f.render.gpuBytes; });
  summary["cpu_cache_bytes_max"] = most([](const FrameFigures& f) { return f.scene.cpuCacheBytes; });
  summary["requests"] = frames.back().scene.requests;
  summary["failed_requests"] = frames.back().scene.failedRequests;
  return summary;
}

void print(const nlohmann::ordered_json& summary, bool json) {
  if (json) return printAnswer("bench", summary.dump(2) + "\n");
  std::string text;
  for (const auto& [name, value] : summary.items())
    text += fmt::format("{:22} {}\n", name,
                        value.is_number_float() ? fmt::format("{:.2f}", value.get<double>()) : value.dump());
  printAnswer("bench", text);
}

/// A wrong name would be found out when the path has been played.
void checkNames(const Arguments& a) {
  if (!a.plot.empty() && endingOf(a.plot) != ".svg" && !io::isDevice(a.plot))
    wrongUse("bench", fmt::format("--plot '{}': the plots are an SVG; give it a name that ends in .svg", a.plot));
  keepApart("bench", "--stats", a.stats, "--plot", a.plot);
  keepApart("bench", "--stats", a.stats, "--path", a.path);
  keepApart("bench", "--plot", a.plot, "--path", a.path);
  keepApart("bench", "--stats", a.stats, "SCENE", a.picture.scene);
  keepApart("bench", "--plot", a.plot, "SCENE", a.picture.scene);
}

io::Result<void> writeFigures(const Arguments& arguments, const std::vector<FrameFigures>& frames) {
  if (!arguments.stats.empty()) {
    std::string text = csvHeader();
    for (const FrameFigures& frame : frames)
      text += csvLine(frame);
    if (const auto written = io::writeWhole(arguments.stats, text); !written) return written;
  }
  if (arguments.plot.empty()) return {};
  const PictureArguments& picture = arguments.picture;
  const std::string detail = picture.verticesPerPixel > 0.0
                                 ? fmt::format("{} vertices a pixel", picture.verticesPerPixel)
                                 : fmt::format("tolerance {} px", picture.tolerance_px);
  const std::string title = fmt::format("{} along {}", picture.scene, arguments.path);
  const std::string quality = picture.automaticQuality ? fmt::format("automatic quality for {} ms", picture.frame_ms)
                                                       : fmt::format("quality {}", picture.quality);
  const std::string subtitle =
      fmt::format("{}, {}, {}, {} mesh; {} frames, {:.1f} ms in the median", picture.size, detail, quality,
                  picture.mesh, frames.size(), percentile(sorted(frames, frameMilliseconds), 50.0));
  return io::writeWhole(arguments.plot, benchPlot(title, subtitle, frames));
}

/// Of frames with the same trouble, the worst stands for all.
void warnOfShortage(const PictureArguments& picture, const std::vector<FrameFigures>& frames) {
  const auto where = [&](std::ptrdiff_t count) { return fmt::format("in {} of {} frames, ", count, frames.size()); };
  const auto error_px = [](const FrameFigures& f) { return f.scene.cappedByBudget ? f.scene.maxScreenError_px : 0.0; };
  const auto withoutRoom = [](const FrameFigures& f) { return f.render.tilesWithoutRoom; };
  warnOfBudget("bench", picture, std::ranges::max_element(frames, {}, error_px)->scene,
               where(std::ranges::count_if(frames, [](const FrameFigures& f) { return f.scene.cappedByBudget; })));
  warnOfMemory("bench", picture, std::ranges::max_element(frames, {}, withoutRoom)->render,
               where(std::ranges::count_if(frames, [&](const FrameFigures& f) { return withoutRoom(f) > 0; })));
}

io::Result<void> bench(const Arguments& arguments) {
  checkNames(arguments);
  if (const auto can = checkOutputs({arguments.stats, arguments.plot}); !can) return can;
  const auto path = scene::readCameraPath(arguments.path);
  if (!path) return tl::unexpected(path.error());
  const InterruptStop interrupt;
  auto studio = openStudio(arguments.picture, interrupt.token());
  if (!studio) return tl::unexpected(studio.error());
  const auto played = play(*studio, *path, arguments, interrupt.token());
  if (!played) return tl::unexpected(played.error());
  const std::vector<FrameFigures>& frames = *played;
  const bool wasStopped = interrupt.token().stop_requested();
  if (wasStopped)
    fmt::print(stderr, "tellurion bench: stopped after {:.1f} of {:.1f} s\n", frames.back().time_s,
               path->duration().count());
  if (const auto written = writeFigures(arguments, frames); !written) return written;
  print(summaryOf(frames, *path, wasStopped), arguments.json);
  warnOfShortage(arguments.picture, frames);
  for (const io::Failure& failure : studio->globe->failures())
    fmt::print(stderr, "warning: {}\n", io::describe(failure));
  return {};
}

}  // namespace

void addBench(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program.add_subcommand("bench", "Play a camera path in real time and measure the frames");
  addPictureArguments(*command, arguments->picture, Pace::realTime);
  addUploadsArgument(*command, arguments->picture);
  command->add_option("--path", arguments->path, "CSV: seconds,lat,lon,height_m,heading,pitch,roll")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--stats", arguments->stats, "A CSV file with a row of figures for each frame to write");
  command->add_option(
      "--plot", arguments->plot,
      "An SVG to write: frame time, quality, missing tiles, tiles a level, triangles and GPU memory over time");
  command
      ->add_option("--fps", arguments->fps, "Frames begin at this rate at most, as on a screen; 0: one after the other")
      ->check(between(0, 1000));
  command
      ->add_option("--pictures", arguments->pictures,
                   "A folder for a PNG of the frame a second, named by its time; taking one delays the next frame")
      ->check(CLI::ExistingDirectory);
  command
      ->add_option("--layer-changes", arguments->layerChanges,
                   "In every other second the top imagery layer's opacity is changed at this rate, as by a slider")
      ->check(between(0, 1000));
  command->add_flag("--first-come", arguments->picture.firstCome,
                    "Ask servers in the order in which things became wanted, and cancel nothing, to compare");
  command->add_flag("--json", arguments->json, "Print the summary as JSON");
  command->footer(
      "Nothing waits for data here: frames show what is there, as the window does. Times are milliseconds.\n"
      "Ctrl-C or SIGTERM ends it early: the summary is of the frames until then, and says stopped.\n\n"
      "Example, once ./bootstrap demo has made the tile databases:\n  tellurion bench data/earth.toml --path "
      "data/everest_flight.csv --size 1024x768 --stats frames.csv --plot frames.svg");
  command->callback([arguments, command] {
    if (command->count("--frame-ms") > 0 && !arguments->picture.automaticQuality)
      wrongUse("bench", "--frame-ms is what --quality auto holds; give that too, or leave --frame-ms out");
    if (const auto done = bench(*arguments); !done) failRun("bench", io::describe(done.error()));
  });
}

}  // namespace tellurion::app
