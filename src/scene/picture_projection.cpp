#include "scene/picture_projection.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

namespace tellurion::scene {
namespace {

constexpr double kPersonsEyes_m = 0.065;

/// From what the view axes of the new camera are in those of the old one.
geo::Mat3 turned(const geo::Vec3& right, const geo::Vec3& up) {
  return glm::transpose(geo::Mat3(right, up, geo::cross(right, up)));
}

/// The middle of a dome lies above the camera, what is in front of it below that in the picture; tilted by a right
/// angle it looks where the camera looks.
geo::Mat3 domeFromView(geo::Angle tilt) {
  const auto lean = geo::sinCos(tilt);
  return turned({1.0, 0.0, 0.0}, {0.0, lean.sin, lean.cos});
}

View square(const View& camera, const geo::Mat3& faceFromView, int side) {
  View view = camera;
  view.viewFromBody = faceFromView * camera.viewFromBody;
  view.viewport = {.width = side, .height = side};
  view.offAxis = Sides{};
  return view;
}

EyePicture perspective(const PictureShape& shape, const View& camera) {
  View view = camera;
  view.verticalFov = shape.verticalFov;
  view.viewport = shape.size;
  return {.cut = view, .panes = {{.place = {0, 0, shape.size.width, shape.size.height}, .view = view}}, .warp = {}};
}

EyePicture warped(const PictureShape& shape, const View& camera) {
  EyePicture eye{.cut = camera,
                 .panes = {},
                 .warp = {.projection = shape.projection, .size = shape.size, .aperture = shape.aperture}};
  if (shape.projection == Projection::fisheye) eye.warpFromView = domeFromView(shape.tilt);
  eye.cut.viewport = shape.size;
  eye.cut.agreedPixelAngle = pixelAngle(eye.warp);
  eye.cut.isAllAround = true;
  return eye;
}

/// A cross that lies: up, below it left, front, right, back, below the front down.
EyePicture cube(const PictureShape& shape, const View& camera) {
  constexpr std::array<std::array<int, 2>, 6> kPlaces{{{2, 1}, {0, 1}, {1, 0}, {1, 2}, {3, 1}, {1, 1}}};
  const int side = shape.size.width / 4;
  EyePicture eye{.cut = square(camera, geo::Mat3(1.0), side), .panes = {}, .warp = {}};
  for (std::size_t i = 0; i < kCubeFaces.size(); ++i) {
    const auto [col, row] = kPlaces[i];
    eye.panes.push_back({.place = {col * side, row * side, side, side}, .view = square(camera, kCubeFaces[i], side)});
  }
  eye.cut.isAllAround = true;
  return eye;
}

/// Parallel axes; the sides are shifted so that both pictures show the same where the eyes meet.
EyePicture eyeOfTwo(const PictureShape& shape, const View& camera, int side, double separation_m) {
  View view = camera;
  view.verticalFov = shape.verticalFov;
  view.viewport = {.width = shape.size.width / 2, .height = shape.size.height};
  view.offAxis.reset();
  Sides sides = view.sides();
  const double shift = -side * 0.5 / kEyesMeet;
  sides.left += shift;
  sides.right += shift;
  view.offAxis = sides;
  const geo::Vec3 right = geo::Vec3(1.0, 0.0, 0.0) * camera.viewFromBody;  // v * M is transpose(M) * v
  view.eye = camera.eye + right * (side * 0.5 * separation_m);
  const int left = side < 0 ? 0 : view.viewport.width;
  return {.cut = view,
          .panes = {{.place = {left, 0, view.viewport.width, view.viewport.height}, .view = view}},
          .warp = {}};
}

}  // namespace

const std::array<geo::Mat3, 6> kCubeFaces{
    turned({0.0, 0.0, 1.0}, {0.0, 1.0, 0.0}),  turned({0.0, 0.0, -1.0}, {0.0, 1.0, 0.0}),
    turned({1.0, 0.0, 0.0}, {0.0, 0.0, 1.0}),  turned({1.0, 0.0, 0.0}, {0.0, 0.0, -1.0}),
    turned({-1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}), turned({1.0, 0.0, 0.0}, {0.0, 1.0, 0.0})};

PixelRect overlapOf(const PixelRect& a, const PixelRect& b) {
  const int left = std::max(a.left, b.left);
  const int top = std::max(a.top, b.top);
  return {left, top, std::max(std::min(a.left + a.width, b.left + b.width) - left, 0),
          std::max(std::min(a.top + a.height, b.top + b.height) - top, 0)};
}

std::string sizeProblem(const PictureShape& shape) {
  const auto [width, height] = shape.size;
  const auto told = [&](const char* what, int goodWidth, int goodHeight) {
    return fmt::format("{} pixels, not {}x{}; {}x{} would do", what, width, height, goodWidth, goodHeight);
  };
  switch (shape.projection) {
    case Projection::perspective:
    case Projection::fisheye:
      return "";
    case Projection::equirectangular:
      return width == 2 * height ? "" : told("an equirectangular picture is twice as wide as high", 2 * height, height);
    case Projection::cube: {
      const int side = std::max(width / 4, 1);
      return width == 4 * side && height == 3 * side
                 ? ""
                 : told("the six sides of a cube are 4 by 3 squares of", 4 * side, 3 * side);
    }
    case Projection::stereo:
      return width % 2 == 0 ? "" : told("a stereo pair has an even width in", width + 1, height);
  }
  return "";
}

double pixelAngle(const Warp& warp) {
  if (warp.projection == Projection::equirectangular) return std::numbers::pi / warp.size.height;
  return warp.aperture.radians() / std::min(warp.size.width, warp.size.height);
}

std::vector<EyePicture> eyesOf(const PictureShape& shape, const View& camera, double height_m) {
  switch (shape.projection) {
    case Projection::perspective:
      break;
    case Projection::fisheye:
    case Projection::equirectangular:
      return {warped(shape, camera)};
    case Projection::cube:
      return {cube(shape, camera)};
    case Projection::stereo: {
      const double apart_m = shape.eyeSeparation_m.value_or(eyeSeparation_m(height_m));
      return {eyeOfTwo(shape, camera, -1, apart_m), eyeOfTwo(shape, camera, 1, apart_m)};
    }
  }
  return {perspective(shape, camera)};
}

double eyeSeparation_m(double height_m) {
  return std::max(height_m / kEyesMeet, kPersonsEyes_m);
}

View partOf(const View& whole, const PixelRect& rect) {
  View part = whole;
  const Sides sides = whole.sides();
  const double width = sides.width() / whole.viewport.width;
  const double height = sides.height() / whole.viewport.height;
  part.viewport = {.width = rect.width, .height = rect.height};
  part.offAxis = Sides{.left = sides.left + rect.left * width,
                       .right = sides.left + (rect.left + rect.width) * width,
                       .bottom = sides.top - (rect.top + rect.height) * height,
                       .top = sides.top - rect.top * height};
  part.agreedPixelAngle = whole.pixelAngle();
  return part;
}

}  // namespace tellurion::scene
