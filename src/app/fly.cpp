#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <memory>
#include <optional>

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
  std::string path;
  std::string output;
  double fps = 30.0;
  double timeout_s = 120.0;
};

using FrameSink = std::function<io::Result<void>(int number, const raster::Raster<raster::Rgba8>& picture)>;

/// Frames at 0, 1 / fps, 2 / fps ... up to and including the end of the path.
int frameCount(const scene::CameraPath& path, double fps) {
  constexpr double kRounding = 1e-6;
  return static_cast<int>(
      std::min<double>(std::floor(path.duration().count() * fps + kRounding) + 1.0, kMostFrames + 1.0));
}

io::Result<void> flyFrames(const Arguments& arguments, const scene::CameraPath& path, int frames,
                           const FrameSink& sink) {
  auto studio = openStudio(arguments.picture);
  if (!studio) return tl::unexpected(studio.error());
  scene::Globe& globe = *studio->globe;
  const InterruptStop interrupt;
  ProgressLine line("flying");
  for (int number = 0; number < frames; ++number) {
    const scene::Camera camera = path.at(path.begin() + scene::CameraPath::Seconds(number / arguments.fps));
    const scene::View view =
        scene::viewOf(camera, globe.body().ellipsoid, arguments.picture.verticalFov(), arguments.picture.viewport());
    const scene::Frame& frame = settledFrame(globe, view, arguments.picture.cut(),
                                             std::chrono::duration<double>(arguments.timeout_s), interrupt.token());
    if (interrupt.token().stop_requested())
      return io::fail(io::Failure::Code::cancelled, fmt::format("stopped after {} of {} frames", number, frames));
    // A flight is the same on every run or it fails: a frame that is not whole ends it.
    if (const auto lacking = shortcomings(globe, frame); !lacking.empty())
      return io::fail(io::Failure::Code::ioError, lacking.front(), fmt::format("frame {}", number));
    studio->renderer.draw(frame, studio->target);
    if (const auto taken = sink(number, render::readColour(studio->target)); !taken) return taken;
    line.show(static_cast<std::uint64_t>(number) + 1, static_cast<std::uint64_t>(frames), "frames");
  }
  return {};
}

io::Result<void> flyToFolder(const Arguments& arguments, const scene::CameraPath& path, int frames) {
  const std::filesystem::path folder = arguments.output;
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return io::fail(io::Failure::Code::ioError, "the folder cannot be made: " + error.message(), folder.string());
  return flyFrames(arguments, path, frames, [&](int number, const auto& picture) {
    return raster::writePng(folder / fmt::format("frame_{:05}.png", number), picture);
  });
}

io::Result<void> flyToVideo(const Arguments& arguments, const scene::CameraPath& path, int frames) {
  auto video = VideoPipe::open(arguments.output, arguments.picture.viewport(), arguments.fps);
  if (!video) return tl::unexpected(video.error());
  const auto flown =
      flyFrames(arguments, path, frames, [&](int, const auto& picture) { return video->write(picture); });
  return flown ? video->finish() : flown;
}

io::Result<void> fly(const Arguments& arguments) {
  const auto path = scene::readCameraPath(arguments.path);
  if (!path) return tl::unexpected(path.error());
  const int frames = frameCount(*path, arguments.fps);
  if (frames > kMostFrames)
    return io::fail(io::Failure::Code::invalidArgument, fmt::format("more than {} frames; lower --fps", kMostFrames),
                    arguments.path);
  const bool isVideo = std::filesystem::path(arguments.output).extension() == ".mp4";
  return isVideo ? flyToVideo(arguments, *path, frames) : flyToFolder(arguments, *path, frames);
}

}  // namespace

void addFly(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program.add_subcommand("fly", "Render the frames of a camera path, each complete");
  addPictureArguments(*command, arguments->picture);
  command->add_option("--path", arguments->path, "CSV: seconds,lat,lon,height_m,heading,pitch,roll")
      ->required()
      ->check(CLI::ExistingFile);
  command->add_option("--fps", arguments->fps, "Frames a second")->check(between(0.001, 1000.0))->capture_default_str();
  command
      ->add_option("-o,--output", arguments->output, "A folder for frame_00000.png and on, or a file that ends in .mp4")
      ->required();
  command->add_option("--timeout", arguments->timeout_s, "Seconds to wait for all that a frame needs")
      ->check(between(0.0, 1e6))
      ->capture_default_str();
  command->footer(
      "Every frame waits for all that it needs, so the pictures are the same on every run. An MP4 needs ffmpeg.\n\n"
      "Example, once ./bootstrap demo has made the tile databases:\n  tellurion fly data/earth.toml --path "
      "data/everest_flight.csv --fps 30 --size 1280x720 -o "
      "everest.mp4");
  command->callback([arguments] {
    if (const auto done = fly(*arguments); !done) failRun("fly", io::describe(done.error()));
  });
}

}  // namespace tellurion::app
