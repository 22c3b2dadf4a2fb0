#include "app/studio.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "app/output_names.h"
#include "app/progress.h"
#include "raster/time_extent.h"
#include "scene/quality_control.h"
#include "scene/scene_setting.h"

namespace tellurion::app {
namespace {

constexpr int kFailed = 1;
constexpr int kWrongUse = 2;
constexpr int kLargestSide = 65536;
constexpr std::size_t kFailuresTold = 5;
constexpr double kMebi = 1024.0 * 1024.0;

std::optional<scene::Viewport> sizeFrom(const std::string& text) {
  scene::Viewport size;
  const char* end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size.width);
  if (width.ec != std::errc() || width.ptr == end || *width.ptr != 'x') return std::nullopt;
  const auto height = std::from_chars(width.ptr + 1, end, size.height);
  if (height.ec != std::errc() || height.ptr != end) return std::nullopt;
  const auto fine = [](int side) { return side >= 1 && side <= kLargestSide; };
  return fine(size.width) && fine(size.height) ? std::optional(size) : std::nullopt;
}

std::string sizeProblem(const std::string& text) {
  return sizeFrom(text)
             ? ""
             : fmt::format("'{}' is not WIDTHxHEIGHT in pixels, like 1024x768, each 1 to {}", text, kLargestSide);
}

std::optional<std::array<float, 3>> colourFrom(const std::string& text) {
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  if (text.size() != 6 || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  const auto channel = [value](unsigned int shift) { return static_cast<float>(value >> shift & 0xFFu) / 255.0f; };
  return std::array{channel(16), channel(8), channel(0)};
}

std::string timeProblem(const std::string& text) {
  return raster::secondsOfTime(text) ? "" : fmt::format("'{}' is not a time like 2004-07-01T12:00:00Z", text);
}

std::string settingProblem(const std::string& text) {
  const auto setting = scene::parseSetting(text);
  return setting ? "" : setting.error().message;
}

std::string colourProblem(const std::string& text) {
  return colourFrom(text) ? "" : fmt::format("'{}' is not a colour RRGGBB in hexadecimal, like 101820", text);
}

/// CLI11's own range lets NaN through.
bool isNumberIn(const std::string& text, double low, double high) {
  double value = 0.0;
  return CLI::detail::lexical_cast(text, value) && value >= low && value <= high;
}

constexpr double kLeastQuality = 0.01;
constexpr double kMostQuality = 100.0;
constexpr const char* kAutomatic = "auto";

std::string qualityProblem(const std::string& text, Pace pace) {
  if (isNumberIn(text, kLeastQuality, kMostQuality) || (text == kAutomatic && pace == Pace::realTime)) return "";
  const std::string number = fmt::format("a number from {} to {}", kLeastQuality, kMostQuality);
  if (text == kAutomatic)
    return fmt::format("'auto' is for bench and view; here each picture is waited for: give {}", number);
  return fmt::format("'{}' is not {}{}; 1 is full quality, 0.5 allows twice the tolerance", text,
                     pace == Pace::realTime ? "'auto' or " : "", number);
}

/// An option of other subcommands: the help does not list it, and whoever gives it is told what to do instead.
void refuse(CLI::App& command, const std::string& option, const std::string& reason) {
  const auto told = [name = command.get_name(), message = option + " " + reason](const std::string&) -> std::string {
    wrongUse(name.c_str(), message);
  };
  command.add_option(option)->group("")->check(told);
}

void addQuality(CLI::App& command, PictureArguments& arguments, Pace pace) {
  const auto take = [&arguments](const std::string& text) {
    arguments.automaticQuality = text == kAutomatic;
    if (!arguments.automaticQuality) CLI::detail::lexical_cast(text, arguments.quality);
  };
  const std::string range = fmt::format("{} to {}", kLeastQuality, kMostQuality);
  const std::string what =
      "Divides --tolerance (or the spacing of --vertices-per-pixel); below 1 texels may be larger than a pixel too";
  const bool mayBeAutomatic = pace == Pace::realTime;
  command
      .add_option_function<std::string>(
          "--quality", take,
          what + (mayBeAutomatic ? ". auto lowers it, and --resolution, while frames take longer than --frame-ms" : ""))
      ->check(CLI::Validator([pace](const std::string& text) { return qualityProblem(text, pace); },
                             mayBeAutomatic ? "auto, " + range : range))
      ->default_str(arguments.automaticQuality ? kAutomatic : "1");
  if (!mayBeAutomatic) {
    refuse(command, "--frame-ms",
           "is for bench and view, whose quality it holds; here each picture is waited for: leave it out, or give "
           "--quality a number under 1 for a cheaper picture");
    refuse(command, "--resolution", "is for bench and view, whose pictures go into a window; here --size says it");
    refuse(command, "--uploads",
           "is for bench and view; here each picture is waited for, and all that it needs is copied: leave it out");
    return;
  }
  command.add_option("--frame-ms", arguments.frame_ms, "Milliseconds that a frame may take with --quality auto")
      ->check(between(1.0, 10000.0))
      ->capture_default_str();
  command
      .add_option("--resolution", arguments.resolution,
                  "Pixels of the picture for one of the window, along a side: more for smoother edges, fewer where the "
                  "processor draws. --quality auto lowers it too, to 0.5, where coarser ground is not enough")
      ->check(between(scene::kLeastResolution, scene::kMostResolution))
      ->capture_default_str();
}

}  // namespace

scene::CutOptions PictureArguments::cut() const {
  scene::CutOptions cut{.tolerance_px = tolerance_px, .maxTiles = maxTiles, .morph = !noMorph};
  if (maxTriangles > 0) cut.maxTriangles = maxTriangles;
  if (maxMebibytes > 0) cut.maxBytes = static_cast<std::uint64_t>(maxMebibytes) << 20;
  if (verticesPerPixel > 0.0) {
    cut.tolerance_px = std::numeric_limits<double>::infinity();
    cut.maxSpacing_px = 1.0 / std::sqrt(verticesPerPixel);
  }
  cut.copies_bytes =
      uploads_MiB > 0.0 ? static_cast<std::uint64_t>(uploads_MiB * kMebi) : std::numeric_limits<std::uint64_t>::max();
  return cut;
}

scene::CutOptions PictureArguments::cutAtQuality() const {
  return scene::atQuality(cut(), quality);
}

scene::GlobeOptions PictureArguments::globe() const {
  scene::GlobeOptions options{.regularMesh = mesh == "regular", .compressTextures = compressTextures};
  options.online.offline = offline;
  if (firstCome) options.online.order = io::RequestOrder::firstCome;
  options.online.cacheBytes = static_cast<std::uint64_t>(onlineCache_MiB) << 20;
  options.online.warn = [](const io::Failure& failure) {
    fmt::print(stderr, "tellurion: warning: {}\n", io::describe(failure));
  };
  return options;
}

render::RendererOptions PictureArguments::renderer() const {
  return {.gpuBudgetBytes = static_cast<std::uint64_t>(gpuMemory_MiB * kMebi), .compressedPictures = compressTextures};
}

scene::Viewport PictureArguments::viewport() const {
  return sizeFrom(size).value_or(scene::Viewport{});
}

void addPictureArguments(CLI::App& command, PictureArguments& arguments, Pace pace) {
  command
      .add_option("SCENE", arguments.scene,
                  "A scene file, a tile database, a raster, several joined by commas, or a map server's URL#LAYER")
      ->required();
  command
      .add_option("--set", arguments.settings,
                  "KEY=VALUE, any value of the scene file (docs/scene-file.md), in place of what it says: "
                  "light.ambient=0.2, or of a layer, by number from the bottom or name, imagery.0.opacity=0.5; may be "
                  "given again and again")
      ->check(settingProblem)
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  command.add_option("--size", arguments.size, "WIDTHxHEIGHT of the picture in pixels")
      ->check(sizeProblem)
      ->capture_default_str();
  command.add_option("--fov", arguments.fov_degrees, "Vertical field of view in degrees")
      ->check(between(0.001, 170.0))
      ->capture_default_str();
  CLI::Option* tolerance =
      command.add_option("--tolerance", arguments.tolerance_px, "Geometric error on screen that is fine, in pixels")
          ->check(between(0.01, 1000.0))
          ->capture_default_str();
  command
      .add_option("--vertices-per-pixel", arguments.verticesPerPixel,
                  "V, in place of --tolerance: samples of a tile at most 1/sqrt(V) pixels apart, whatever the error "
                  "(docs/selection.md)")
      ->check(between(0.0001, 16.0))
      ->excludes(tolerance);
  addQuality(command, arguments, pace);
  command
      .add_option("--mesh", arguments.mesh,
                  "A tile's triangles: 'bisected' has those that its error needs, 'regular' its whole grid, to compare")
      ->check(CLI::IsMember({"bisected", "regular"}))
      ->capture_default_str();
  command.add_option("--background", arguments.background, "Colour of the sky, RRGGBB; else what the scene says")
      ->check(colourProblem);
  command
      .add_option("--exaggeration", arguments.exaggeration,
                  "Draw heights above the ellipsoid this many times as high; 0 is a smooth body")
      ->check(between(0.0, 100.0))
      ->capture_default_str();
  command
      .add_option(
          "--time", arguments.time,
          "ISO 8601, like 2004-07-01T12:00:00Z: what layers with time steps show, at first; else what the scene "
          "says, else the last of each")
      ->check(timeProblem);
  command.add_flag("--no-morph", arguments.noMorph,
                   "Let ground pop to finer levels instead of growing into them (for comparison)");
  command
      .add_option(
          "--max-tiles", arguments.maxTiles,
          "Draw with no more tiles than these, those that an eye which turns would see next included; the worst "
          "ground is made finer first")
      ->check(CLI::Range(16, 1000000))
      ->capture_default_str();
  command.add_option("--max-triangles", arguments.maxTriangles, "Likewise with no more triangles; else any number")
      ->check(CLI::Range(std::int64_t{10000}, std::int64_t{1000000000}));
  command
      .add_option("--max-mib", arguments.maxMebibytes,
                  "Likewise with meshes and pictures of the tiles in view of no more mebibytes; else any number")
      ->check(CLI::Range(16, 1000000));
  command.add_flag("--offline", arguments.offline,
                   "Ask no server: layers of servers are drawn from what earlier runs kept on this machine");
  command
      .add_option("--cache-mib", arguments.onlineCache_MiB,
                  "MiB on disk for what servers gave, for later runs; 0 keeps nothing")
      ->check(CLI::Range(0, 1 << 20))
      ->capture_default_str();
  command
      .add_option("--gpu-memory", arguments.gpuMemory_MiB,
                  "MiB for meshes and textures on the GPU; meshes take more where the ground would have "
                  "holes else")
      ->check(between(1.0, 65536.0))
      ->capture_default_str();
  command.add_flag(
      "--compress-textures", arguments.compressTextures,
      "Compress imagery on its way to the GPU, with a small loss: an eighth of its memory there (a quarter "
      "where it has gaps)");
}

void addUploadsArgument(CLI::App& command, PictureArguments& arguments) {
  command
      .add_option(
          "--uploads", arguments.uploads_MiB,
          "MiB that a frame may copy to the GPU; the rest waits for the next frames. 0, or with --no-morph: all at "
          "once")
      ->check(between(0.0, 65536.0))
      ->capture_default_str();
}

CLI::Validator between(double low, double high) {
  const auto problem = [low, high](const std::string& text) {
    return isNumberIn(text, low, high) ? std::string()
                                       : fmt::format("'{}' is not a number from {} to {}", text, low, high);
  };
  return {problem, fmt::format("{} to {}", low, high)};
}

std::string cameraProblem(const std::string& text) {
  const auto parsed = scene::parseCamera(text);
  return parsed ? "" : io::describe(parsed.error());
}

scene::SceneClock clockOf(const scene::Scene& scene, const PictureArguments& arguments) {
  scene::SceneClock clock = scene.clock;
  if (!arguments.time.empty()) clock.start_s = raster::secondsOfTime(arguments.time);
  return clock;
}

io::Result<std::unique_ptr<scene::Globe>> openGlobe(const scene::Scene& scene, const PictureArguments& arguments,
                                                    const std::stop_token& stop) {
  BuildLines lines;
  scene::Scene clocked = scene;
  clocked.clock = clockOf(scene, arguments);
  auto globe = scene::Globe::open(clocked, arguments.globe(), std::ref(lines), stop);
  if (globe && !arguments.background.empty()) (*globe)->background() = *colourFrom(arguments.background);
  if (globe) (*globe)->exaggeration() = arguments.exaggeration;
  return globe;
}

io::Result<Studio> openStudio(const PictureArguments& arguments, const std::stop_token& stop) {
  const auto scene = scene::openScene(arguments.scene, arguments.settings, arguments.globe().online);
  if (!scene) return tl::unexpected(scene.error());
  auto globe = openGlobe(*scene, arguments, stop);
  if (!globe) return tl::unexpected(globe.error());
  auto context = render::HeadlessContext::create();
  if (!context) return tl::unexpected(context.error());
  auto renderer = render::Renderer::create(arguments.renderer());
  if (!renderer) return tl::unexpected(renderer.error());
  if (scene->air.enabled) {
    if (const auto ready = renderer->prepareAir(); !ready) return tl::unexpected(ready.error());
  }
  if (scene->sky.enabled) {
    if (const auto ready = renderer->prepareSky(); !ready) return tl::unexpected(ready.error());
  }
  return Studio{std::move(*globe), clockOf(*scene, arguments), std::move(*context), std::move(*renderer)};
}

void setClock(Studio& studio, double seconds) {
  if (const auto time_s = scene::timeAfter(studio.clock, seconds)) studio.globe->setClock(*time_s);
}

const scene::Frame& settledFrame(scene::Globe& globe, const scene::View& view, const scene::CutOptions& cut,
                                 std::chrono::duration<double> timeout, const std::stop_token& stop) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kNap{250};
  const auto end = Clock::now() + std::chrono::duration_cast<Clock::duration>(timeout);
  for (;;) {
    const scene::Frame& frame = globe.update(view, cut);
    const auto before = Clock::now();
    const bool isAllHere = frame.statistics.tilesWanted == 0 && frame.statistics.layersComing == 0;
    if (isAllHere || before >= end || stop.stop_requested()) return frame;
    const auto nap = std::min(kNap, std::chrono::ceil<std::chrono::milliseconds>(end - before));
    const bool arrived = globe.waitForArrivals(nap);
    if (!arrived && Clock::now() < before + nap) return globe.update(view, cut);  // nothing is on its way
  }
}

std::vector<std::string> shortcomings(const PictureArguments& arguments, const scene::Globe& globe,
                                      const scene::Frame& frame) {
  std::vector<std::string> lines;
  const scene::FrameStatistics& statistics = frame.statistics;
  for (const io::Failure& late : globe.lateLayers())
    lines.push_back(io::describe(late));
  if (lines.empty() && statistics.layersComing > 0)
    lines.push_back("the last layer that came was not drawn in time; raise --timeout");
  if (statistics.tilesWanted > 0)
    lines.push_back(fmt::format("{} finer tiles had not arrived in time; raise --timeout", statistics.tilesWanted));
  // Of a frame that has all it needs they are about what comes next, like the step to come of a slow server.
  if (!lines.empty()) {
    for (const io::Failure& trouble : globe.troubles()) {
      if (std::string line = io::describe(trouble); std::ranges::find(lines, line) == lines.end())
        lines.push_back(std::move(line));
    }
  }
  const std::vector<io::Failure> failures = globe.failuresInFrame();
  const std::size_t missing = failures.size();
  if (missing == 0) return lines;
  if (arguments.offline)
    lines.push_back(
        fmt::format("{} pieces could not be had --offline; run it without once, so that they are kept", missing));
  const std::size_t told = std::min(failures.size(), kFailuresTold);
  for (std::size_t i = 0; i < told; ++i)
    lines.push_back(io::describe(failures[i]));
  if (missing > told) lines.push_back(fmt::format("and {} more failures", missing - told));
  return lines;
}

void warnOfBudget(const char* command, const PictureArguments& arguments, const scene::FrameStatistics& frame,
                  const std::string& where) {
  if (!frame.cappedByBudget) return;
  std::string budget = fmt::format("{} tiles (--max-tiles)", arguments.maxTiles);
  if (arguments.maxTriangles > 0) budget += fmt::format(" or {} triangles (--max-triangles)", arguments.maxTriangles);
  if (arguments.maxMebibytes > 0) budget += fmt::format(" or {} MiB (--max-mib)", arguments.maxMebibytes);
  const bool isGroundOff = frame.maxScreenError_px > arguments.cutAtQuality().tolerance_px;
  const std::string lack = isGroundOff ? fmt::format("the ground is up to {:.1f} pixels off", frame.maxScreenError_px)
                                       : "the ground's pictures or samples are coarser than they were to be";
  fmt::print(stderr,
             "tellurion {}: warning: {}the {} that a frame may have are spent, and {}; raise them, raise --tolerance, "
             "lower --vertices-per-pixel or --quality, or make the picture smaller\n",
             command, where, budget, lack);
}

void warnOfMemory(const char* command, const PictureArguments& arguments, const render::RenderStatistics& drawn,
                  const std::string& where) {
  if (drawn.tilesWithoutRoom == 0) return;
  fmt::print(
      stderr,
      "tellurion {}: warning: {}{} pictures of the ground found no room in {:g} MiB of GPU memory, and their tiles "
      "have one plain colour; raise --gpu-memory\n",
      command, where, drawn.tilesWithoutRoom, arguments.gpuMemory_MiB);
}

double depthBelowGround_m(const scene::Globe& globe, const scene::View& view) {
  const geo::Ellipsoid& ellipsoid = globe.body().ellipsoid;
  const auto ground_m = globe.groundHeight_m(ellipsoid.directionFromBody(view.eye));
  return ground_m ? std::max(0.0, *ground_m - scene::cameraOf(view, ellipsoid).position.height_m) : 0.0;
}

void wrongUse(const char* command, const std::string& message) {
  fmt::print(stderr, "tellurion {}: {}\n", command, message);
  throw CLI::RuntimeError(kWrongUse);
}

void failRun(const char* command, const std::string& message) {
  fmt::print(stderr, "tellurion {}: {}\n", command, message);
  throw CLI::RuntimeError(kFailed);
}

void keepApart(const char* command, const char* option, const std::string& name, const char* other,
               const std::string& otherName) {
  if (isSameFile(name, otherName))
    wrongUse(command, fmt::format("{} and {} are the same file, '{}'; give each its own", option, other, name));
}

}  // namespace tellurion::app
