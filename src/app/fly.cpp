#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "app/debug_options.h"
#include "app/output_names.h"
#include "app/progress.h"
#include "app/projection_options.h"
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
  ProjectionArguments projection;
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
  if (auto can = checkOutputs({file}); !can) return can;
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

/// What the frames of a flight are made with.
struct Flight {
  const Arguments& arguments;
  const PictureRequest& request;
  const scene::CameraPath& path;
  int frames = 0;
};

io::Result<void> flyFrames(const Flight& flight, Studio& studio, const std::stop_token& stop, const FrameSink& sink) {
  const Arguments& arguments = flight.arguments;
  if (const auto shown = showDebug(arguments.debug, arguments.picture, studio); !shown) return shown;
  auto maker = render::PictureMaker::create();
  if (!maker) return tl::unexpected(maker.error());
  scene::Globe& globe = *studio.globe;
  const Patience patience{std::chrono::duration<double>(arguments.timeout_s), stop};
  const scene::Viewport size = flight.request.shape.size;
  BelowGround belowGround;
  SpentBudget spentBudget;
  ProgressLine line("flying");
  raster::Raster<raster::Rgba8> picture(size.width, size.height);
  for (int number = 0; number < flight.frames; ++number) {
    const auto seconds = scene::CameraPath::Seconds(number / arguments.fps);
    setClock(studio, seconds.count());
    const auto eyes =
        eyesOf(flight.request, flight.path.at(flight.path.begin() + seconds), studio, arguments.picture, patience);
    bool isFirst = true;
    const auto check = [&](const scene::Frame& frame) -> io::Result<void> {
      if (stop.stop_requested())
        return io::fail(io::Failure::Code::cancelled,
                        fmt::format("stopped after {} of {} frames", number, flight.frames));
      // A flight is the same on every run or it fails: a frame that is not whole ends it.
      if (const auto lacking = shortcomings(arguments.picture, globe, frame); !lacking.empty())
        return io::fail(io::Failure::Code::ioError, lacking.front(), fmt::format("frame {}", number));
      if (!std::exchange(isFirst, false)) return {};
      belowGround.add(number, depthBelowGround_m(globe, frame.view));
      spentBudget.add(frame.statistics);
      return {};
    };
    const auto take = [&](const render::PicturePiece& rows) {
      std::ranges::copy(rows.colours.samples, picture.samples.begin() + std::ptrdiff_t{rows.place.top} * picture.width);
      return io::Result<void>();
    };
    const auto drawn =
        drawPicture(flight.request, eyes, studio, *maker, arguments.picture, patience, false, check, take);
    if (!drawn) return drawn;
    if (const auto taken = sink(number, picture); !taken) return taken;
    line.show(static_cast<std::uint64_t>(number) + 1, static_cast<std::uint64_t>(flight.frames), "frames");
  }
  line.clear();
  belowGround.tell(flight.frames);
  spentBudget.tell(arguments.picture, flight.frames);
  return {};
}

io::Result<void> flyToFolder(const Flight& flight) {
  const std::filesystem::path folder = flight.arguments.output;
  if (const auto ready = prepareFolder(folder, flight.frames); !ready) return ready;
  const InterruptStop interrupt;
  auto studio = openStudio(flight.arguments.picture, interrupt.token());
  if (!studio) return tl::unexpected(studio.error());
  return flyFrames(flight, *studio, interrupt.token(), [&](int number, const auto& picture) {
    return raster::writePng(folder / frameName(number), picture);
  });
}

io::Result<void> flyToVideo(const Flight& flight) {
  const Arguments& arguments = flight.arguments;
  const scene::Viewport size = flight.request.shape.size;
  if (const auto ready = prepareVideo(arguments.output, size); !ready) return ready;
  const InterruptStop interrupt;
  auto studio = openStudio(arguments.picture, interrupt.token());
  if (!studio) return tl::unexpected(studio.error());
  auto video = VideoPipe::open(arguments.output, size, arguments.fps);
  if (!video) return tl::unexpected(video.error());
  const auto flown =
      flyFrames(flight, *studio, interrupt.token(), [&](int, const auto& picture) { return video->write(picture); });
  return flown ? video->finish() : flown;
}

void checkTogether(const Arguments& arguments, const PictureRequest& request) {
  // A frame is kept whole, and no film is larger.
  constexpr int kLargestSide = 16384;
  const scene::Viewport size = request.shape.size;
  if (size.width > kLargestSide || size.height > kLargestSide)
    wrongUse("fly", fmt::format("--size {}x{}: the frames of a flight are at most {} pixels a side", size.width,
                                size.height, kLargestSide));
  const bool isPlain = request.shape.projection == scene::Projection::perspective && request.channels.empty();
  const bool hasDebug = !arguments.debug.views.empty() || !arguments.debug.freezeAt.empty();
  if (hasDebug && !(isPlain && request.pieces.size() == 1))
    wrongUse("fly", fmt::format("--debug and --freeze-at are for perspective pictures of at most {}x{}",
                                request.pieces.front().width, request.pieces.front().height));
}

io::Result<void> fly(const CLI::App& command, Arguments& arguments) {
  const auto request = requestOf(command, arguments.projection, arguments.picture);
  if (!request) return tl::unexpected(request.error());
  checkTogether(arguments, *request);
  const auto path = scene::readCameraPath(arguments.path);
  if (!path) return tl::unexpected(path.error());
  const int frames = frameCount(*path, arguments.fps);
  if (frames > kMostFrames)
    return io::fail(io::Failure::Code::invalidArgument, fmt::format("more than {} frames; lower --fps", kMostFrames),
                    arguments.path);
  const Flight flight{.arguments = arguments, .request = *request, .path = *path, .frames = frames};
  return isVideo(arguments.output) ? flyToVideo(flight) : flyToFolder(flight);
}

}  // namespace

void addFly(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program.add_subcommand("fly", "Render the frames of a camera path, each complete");
  addPictureArguments(*command, arguments->picture, Pace::eachComplete);
  addProjectionOptions(*command, arguments->projection);
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
  command->callback([arguments, command] {
    if (const auto done = fly(*command, *arguments); !done) failRun("fly", io::describe(done.error()));
  });
}

}  // namespace tellurion::app
