#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>

#include "app/debug_options.h"
#include "app/output_names.h"
#include "app/progress.h"
#include "app/studio.h"
#include "app/subcommands.h"
#include "app/video_pipe.h"
#include "raster/image_file.h"
#include "scene/camera_path.h"

namespace tellurion::app {
namespace {

constexpr int kMostFrames = 1'000'000;

struct Arguments {
  PictureArguments picture;
  DebugOptions debug;
  std::string path;
  std::string output;
  double fps = 30.0;
  double timeout_s = 120.0;
};

bool isVideo(const std::filesystem::path& output) {
  return endingOf(output) == ".mp4";
}

/// What a person means who gives such a name is no folder.
std::string outputProblem(const std::string& text) {
  constexpr std::array kOtherEndings{".avi", ".mov", ".mkv", ".webm", ".m4v",  ".mpg", ".mpeg", ".wmv", ".flv",
                                     ".ogv", ".gif", ".png", ".jpg",  ".jpeg", ".tif", ".tiff", ".bmp", ".webp"};
  std::error_code error;
  if (std::ranges::find(kOtherEndings, endingOf(text)) == kOtherEndings.end()) return "";
  if (std::filesystem::is_directory(text, error)) return "";
  return fmt::format("'{}' is neither a folder for PNGs nor a file that ends in .mp4; other formats are not written",
                     text);
}

std::filesystem::path frameName(int number) {
  return fmt::format("frame_{:05}.png", number);
}

/// The number of a frame by the name of its file; nothing when fly gives no such names.
std::optional<int> frameNumber(const std::string& name) {
  constexpr std::string_view kBefore = "frame_";
  int number = -1;
  if (!name.starts_with(kBefore)) return std::nullopt;
  std::from_chars(name.data() + kBefore.size(), name.data() + name.size(), number);
  return number >= 0 && frameName(number) == name ? std::optional(number) : std::nullopt;
}

/// Frames of a longer flight would stay among the new ones, and nobody could tell them apart.
io::Result<void> checkOldFrames(const std::filesystem::path& folder, int frames) {
  std::error_code error;
  int beyond = 0;
  int last = 0;
  for (auto entry = std::filesystem::directory_iterator(folder, error);
       !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
    const auto number = frameNumber(entry->path().filename().string());
    if (!number || *number < frames) continue;
    ++beyond;
    last = std::max(last, *number);
  }
  if (beyond == 0) return {};
  return io::fail(io::Failure::Code::invalidArgument,
                  fmt::format("holds {} frames of a longer flight, up to {}, and this one ends with {}; remove them or "
                              "name another folder",
                              beyond, frameName(last).string(), frameName(frames - 1).string()),
                  folder.string());
}

io::Result<void> prepareFolder(const std::filesystem::path& folder, int frames) {
  std::error_code error;
  if (std::filesystem::exists(folder, error) && !std::filesystem::is_directory(folder, error))
    return io::fail(io::Failure::Code::invalidArgument,
                    "is a file; name a folder for PNGs, or a file that ends in .mp4", folder.string());
  std::filesystem::create_directories(folder, error);
  if (error)
    return io::fail(io::Failure::Code::ioError, "the folder cannot be made: " + error.message(), folder.string());
  return checkOldFrames(folder, frames);
}

io::Result<void> prepareVideo(const std::filesystem::path& file, scene::Viewport size) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error))
    return io::fail(io::Failure::Code::invalidArgument, "is a folder; name a file that ends in .mp4", file.string());
  const std::filesystem::path folder = file.parent_path();
  if (!folder.empty() && !std::filesystem::is_directory(folder, error))
    return io::fail(io::Failure::Code::notFound, fmt::format("there is no folder {}; make it first", folder.string()),
                    file.string());
  if (size.width % 2 != 0 || size.height % 2 != 0) {
    fmt::print(stderr,
               "tellurion fly: warning: the sides of an MP4 are even: {}x{} gets a black border at the right or the "
               "bottom and becomes {}x{}\n",
               size.width, size.height, size.width + size.width % 2, size.height + size.height % 2);
  }
  return VideoPipe::check(file);
}

/// Frames from below the ground, told once when the flight is over.
struct BelowGround {
  int frames = 0;
  int first = 0;
  double deepest_m = 0.0;

  void add(int number, double below_m) {
    if (!(below_m > 0.0)) return;
    if (frames++ == 0) first = number;
    deepest_m = std::max(deepest_m, below_m);
  }
  void tell(int ofFrames) const {
    if (frames == 0) return;
    fmt::print(stderr,
               "tellurion fly: warning: in {} of {} frames, from number {} on, the eye is below the ground, by up to "
               "{:.1f} m; raise the height_m of the path there\n",
               frames, ofFrames, first, deepest_m);
  }
};

/// Frames that a budget kept from the tolerance, told once likewise; the worst stands for all.
struct SpentBudget {
  int frames = 0;
  scene::FrameStatistics worst;

  void add(const scene::FrameStatistics& frame) {
    if (!frame.cappedByBudget) return;
    if (frames++ == 0 || frame.maxScreenError_px > worst.maxScreenError_px) worst = frame;
  }
  void tell(const PictureArguments& picture, int ofFrames) const {
    warnOfBudget("fly", picture, worst, fmt::format("in {} of {} frames, ", frames, ofFrames));
  }
};

using FrameSink = std::function<io::Result<void>(int number, const raster::Raster<raster::Rgba8>& picture)>;

/// Frames at 0, 1 / fps, 2 / fps ... up to and including the end of the path.
int frameCount(const scene::CameraPath& path, double fps) {
  constexpr double kRounding = 1e-6;
  return static_cast<int>(
      std::min<double>(std::floor(path.duration().count() * fps + kRounding) + 1.0, kMostFrames + 1.0));
}

io::Result<void> flyFrames(const Arguments& arguments, const scene::CameraPath& path, int frames, Studio& studio,
                           const std::stop_token& stop, const FrameSink& sink) {
  if (const auto shown = showDebug(arguments.debug, arguments.picture, studio); !shown) return shown;
  scene::Globe& globe = *studio.globe;
  BelowGround belowGround;
  SpentBudget spentBudget;
  ProgressLine line("flying");
  for (int number = 0; number < frames; ++number) {
    const scene::Camera camera = path.at(path.begin() + scene::CameraPath::Seconds(number / arguments.fps));
    const scene::View view =
        scene::viewOf(camera, globe.body().ellipsoid, arguments.picture.verticalFov(), arguments.picture.viewport());
    setClock(studio, number / arguments.fps);
    const scene::Frame& frame = settledFrame(globe, view, arguments.picture.cutAtQuality(),
                                             std::chrono::duration<double>(arguments.timeout_s), stop);
    if (stop.stop_requested())
      return io::fail(io::Failure::Code::cancelled, fmt::format("stopped after {} of {} frames", number, frames));
    // A flight is the same on every run or it fails: a frame that is not whole ends it.
    if (const auto lacking = shortcomings(arguments.picture, globe, frame); !lacking.empty())
      return io::fail(io::Failure::Code::ioError, lacking.front(), fmt::format("frame {}", number));
    belowGround.add(number, depthBelowGround_m(globe, view));
    spentBudget.add(frame.statistics);
    studio.renderer.draw(frame, studio.target);
    if (const auto taken = sink(number, render::readColour(studio.target)); !taken) return taken;
    line.show(static_cast<std::uint64_t>(number) + 1, static_cast<std::uint64_t>(frames), "frames");
  }
  line.clear();
  belowGround.tell(frames);
  spentBudget.tell(arguments.picture, frames);
  return {};
}

io::Result<void> flyToFolder(const Arguments& arguments, const scene::CameraPath& path, int frames) {
  const std::filesystem::path folder = arguments.output;
  if (const auto ready = prepareFolder(folder, frames); !ready) return ready;
  const InterruptStop interrupt;
  auto studio = openStudio(arguments.picture, interrupt.token());
  if (!studio) return tl::unexpected(studio.error());
  return flyFrames(arguments, path, frames, *studio, interrupt.token(), [&](int number, const auto& picture) {
    return raster::writePng(folder / frameName(number), picture);
  });
}

io::Result<void> flyToVideo(const Arguments& arguments, const scene::CameraPath& path, int frames) {
  if (const auto ready = prepareVideo(arguments.output, arguments.picture.viewport()); !ready) return ready;
  const InterruptStop interrupt;
  auto studio = openStudio(arguments.picture, interrupt.token());
  if (!studio) return tl::unexpected(studio.error());
  auto video = VideoPipe::open(arguments.output, arguments.picture.viewport(), arguments.fps);
  if (!video) return tl::unexpected(video.error());
  const auto flown = flyFrames(arguments, path, frames, *studio, interrupt.token(),
                               [&](int, const auto& picture) { return video->write(picture); });
  return flown ? video->finish() : flown;
}

io::Result<void> fly(const Arguments& arguments) {
  const auto path = scene::readCameraPath(arguments.path);
  if (!path) return tl::unexpected(path.error());
  const int frames = frameCount(*path, arguments.fps);
  if (frames > kMostFrames)
    return io::fail(io::Failure::Code::invalidArgument, fmt::format("more than {} frames; lower --fps", kMostFrames),
                    arguments.path);
  return isVideo(arguments.output) ? flyToVideo(arguments, *path, frames) : flyToFolder(arguments, *path, frames);
}

}  // namespace

void addFly(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program.add_subcommand("fly", "Render the frames of a camera path, each complete");
  addPictureArguments(*command, arguments->picture, Pace::eachComplete);
  command->add_option("--path", arguments->path, "CSV: seconds,lat,lon,height_m,heading,pitch,roll")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--fps", arguments->fps, "Frames a second")->check(between(0.001, 1000.0))->capture_default_str();
  command
      ->add_option("-o,--output", arguments->output, "A folder for frame_00000.png and on, or a file that ends in .mp4")
      ->required()
      ->check(outputProblem);
  command->add_option("--timeout", arguments->timeout_s, "Seconds to wait for all that a frame needs")
      ->check(between(0.0, 1e6))
      ->capture_default_str();
  addDebugOptions(*command, arguments->debug);
  command->footer(
      "Every frame waits for all that it needs, so the pictures are the same on every run. Frames that are in the "
      "folder already are\n"
      "written over; a folder with frames beyond the end of this flight is refused, so that two flights never mix. An "
      "MP4 "
      "needs\n"
      "ffmpeg, and its sides are even: an odd --size gets a black row or column more at the bottom or right.\n\n"
      "Example, once ./bootstrap demo has made the tile databases:\n  tellurion fly data/earth.toml --path "
      "data/everest_flight.csv --fps 30 --size 1280x720 -o "
      "everest.mp4");
  command->callback([arguments] {
    if (const auto done = fly(*arguments); !done) failRun("fly", io::describe(done.error()));
  });
}

}  // namespace tellurion::app
