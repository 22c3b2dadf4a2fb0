#include "app/projection_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "app/progress.h"

namespace tellurion::app {
namespace {

using scene::Projection;

struct Named {
  const char* name;
  Projection projection;
  const char* size;  ///< where none is given
};
constexpr std::array kProjections{
    Named{"perspective", Projection::perspective, "1024x768"}, Named{"fisheye", Projection::fisheye, "1024x1024"},
    Named{"equirectangular", Projection::equirectangular, "2048x1024"}, Named{"cube", Projection::cube, "1024x768"},
    Named{"stereo", Projection::stereo, "2048x768"}};

// What one piece takes on a GPU, and of a bent picture the faces that it looks at.
constexpr int kPanePiece_px = 4096;
constexpr int kWarpPiece_px = 2048;
constexpr int kMostPiece_px = 16384;

const Named& named(const std::string& name) {
  return *std::ranges::find_if(kProjections, [&](const Named& n) { return name == n.name; });
}

bool isWarp(Projection projection) {
  return projection == Projection::fisheye || projection == Projection::equirectangular;
}

/// An option that only one projection reads.
void keepTo(const CLI::App& command, const char* option, const char* projection, const std::string& asked) {
  if (command.count(option) > 0 && asked != projection)
    wrongUse(command.get_name().c_str(), fmt::format("{} is for --projection {}", option, projection));
}

}  // namespace

void addProjectionOptions(CLI::App& command, ProjectionArguments& arguments) {
  std::vector<std::string> names;
  for (const Named& each : kProjections)
    names.emplace_back(each.name);
  auto* projection =
      command
          .add_option(
              "--projection", arguments.projection,
              "How the picture shows the directions around the eye. fisheye: angles from the middle of a circle "
              "(a dome master: above the camera is the middle, in front of it the bottom); equirectangular: all "
              "of 360 x 180 degrees, twice as wide as high; cube: six squares as a cross, 4 by 3; stereo: the "
              "left eye's picture beside the right one's (docs/projections.md)")
          ->check(CLI::IsMember(names))
          ->capture_default_str();
  command.add_option("--aperture", arguments.aperture_degrees, "Degrees across the circle of a fisheye")
      ->check(between(1.0, 360.0))
      ->capture_default_str();
  command
      .add_option(
          "--tilt", arguments.tilt_degrees,
          "Degrees by which the middle of a fisheye leans from above the camera to its front; 90: it looks where "
          "the camera looks")
      ->check(between(-180.0, 180.0))
      ->capture_default_str();
  command
      .add_option("--eye-separation", arguments.eyeSeparation_m,
                  "Metres between the eyes of a stereo pair; else a thirtieth of the height above the ground, at least "
                  "0.065")
      ->check(between(0.0, 1e7));
  auto* frustum = command.add_option(
      "--frustum", arguments.frustum,
      "TOML of [[channel]]s, one a projector: name, left_degrees, right_degrees, bottom_degrees, "
      "top_degrees from its axis, and heading, pitch, roll of that from the camera's; in place of --fov");
  frustum->excludes(projection);
  command.add_option("--channel", arguments.channel, "Which channel of --frustum to draw")->needs(frustum);
  command
      .add_option("--piece", arguments.piece_px,
                  fmt::format("Pixels of the largest side that is drawn at once, for GPUs with little memory; else {}, "
                              "of fisheye and equirectangular {}",
                              kPanePiece_px, kWarpPiece_px))
      ->check(CLI::Range(16, kMostPiece_px));
}

io::Result<PictureRequest> requestOf(const CLI::App& command, const ProjectionArguments& arguments,
                                     PictureArguments& picture) {
  const std::string name = command.get_name();
  if (command.count("--frustum") > 0 && arguments.frustum.empty())
    wrongUse(name.c_str(), "--frustum: '' names no file of channels");
  keepTo(command, "--aperture", "fisheye", arguments.projection);
  keepTo(command, "--tilt", "fisheye", arguments.projection);
  keepTo(command, "--eye-separation", "stereo", arguments.projection);
  const Named& which = named(arguments.projection);
  if (command.count("--size") == 0) picture.size = which.size;
  const bool readsFov = arguments.frustum.empty() &&
                        (which.projection == Projection::perspective || which.projection == Projection::stereo);
  if (command.count("--fov") > 0 && !readsFov)
    wrongUse(name.c_str(),
             "--fov is for perspective and stereo pictures; a fisheye has --aperture, channels their sides");
  PictureRequest request{.shape = {.projection = which.projection,
                                   .size = picture.viewport(),
                                   .verticalFov = picture.verticalFov(),
                                   .aperture = geo::Angle::degrees(arguments.aperture_degrees),
                                   .tilt = geo::Angle::degrees(arguments.tilt_degrees),
                                   .eyeSeparation_m = arguments.eyeSeparation_m},
                         .channels = {},
                         .channel = 0,
                         .pieces = {}};
  if (const std::string problem = sizeProblem(request.shape); !problem.empty())
    wrongUse(name.c_str(), "--size: " + problem);
  const int suits = isWarp(which.projection) ? kWarpPiece_px : kPanePiece_px;
  request.pieces = render::piecesOf(request.shape.size, arguments.piece_px > 0 ? arguments.piece_px : suits);
  if (arguments.frustum.empty()) return request;
  auto channels = scene::readChannels(arguments.frustum);
  if (!channels) return tl::unexpected(channels.error());
  const auto channel = scene::channelNamed(*channels, arguments.channel, arguments.frustum);
  if (!channel) return tl::unexpected(channel.error());
  request.channels = std::move(*channels);
  request.channel = *channel;
  return request;
}

std::vector<scene::EyePicture> eyesOf(const PictureRequest& request, const scene::Camera& camera, Studio& studio,
                                      const PictureArguments& picture, const Patience& patience) {
  const scene::Viewport size = request.shape.size;
  const geo::Ellipsoid& ellipsoid = studio.globe->body().ellipsoid;
  const scene::View view = scene::viewOf(camera, ellipsoid, picture.verticalFov(), size);
  if (!request.channels.empty())
    return {scene::pictureOf(request.channels[request.channel], request.channels, view, size)};
  if (request.shape.projection != Projection::stereo || request.shape.eyeSeparation_m)
    return scene::eyesOf(request.shape, view, 0.0);
  const scene::Camera down{.position = camera.position, .heading = {}, .pitch = geo::Angle::degrees(-90.0), .roll = {}};
  const scene::View below = scene::viewOf(down, ellipsoid, picture.verticalFov(), {.width = 64, .height = 64});
  settledFrame(*studio.globe, below, picture.cutAtQuality(), patience.timeout, patience.stop);
  const auto ground_m = studio.globe->groundHeight_m(ellipsoid.directionFromBody(view.eye));
  return scene::eyesOf(request.shape, view, camera.position.height_m - ground_m.value_or(0.0));
}

io::Result<void> drawPicture(const PictureRequest& request, const std::vector<scene::EyePicture>& eyes, Studio& studio,
                             render::PictureMaker& maker, const PictureArguments& picture, const Patience& patience,
                             bool withDistances, const FrameCheck& check, const RowSink& sink) {
  std::optional<ProgressLine> line;
  if (request.pieces.size() > 1) line.emplace("drawing");
  const scene::Frame* frame = nullptr;
  std::size_t done = 0;
  for (auto first = request.pieces.begin(); first != request.pieces.end();) {
    const auto isNextRow = [&](const scene::PixelRect& piece) { return piece.top != first->top; };
    const auto last = std::find_if(first, request.pieces.end(), isNextRow);
    auto rows = render::blankPiece({0, first->top, request.shape.size.width, first->height}, withDistances);
    for (const scene::EyePicture& eye : eyes) {
      if (frame == nullptr || eyes.size() > 1) {  // of one eye it stays what it is
        frame = &settledFrame(*studio.globe, eye.cut, picture.cutAtQuality(), patience.timeout, patience.stop);
        if (const auto fine = check(*frame); !fine) return fine;
      }
      for (auto piece = first; piece != last; ++piece) {
        if (patience.stop.stop_requested())
          return io::fail(io::Failure::Code::cancelled, "stopped; nothing is written");
        if (const auto drawn = maker.draw(studio.renderer, *frame, eye, *piece, rows); !drawn) return drawn;
        ++done;
        if (line) line->show(done, request.pieces.size() * eyes.size(), "pieces");
      }
    }
    if (const auto taken = sink(rows); !taken) return taken;
    first = last;
  }
  return {};
}

}  // namespace tellurion::app
