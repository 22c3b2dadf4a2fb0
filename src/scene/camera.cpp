#include "scene/camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

#include "raster/parse_number.h"

namespace tellurion::scene {
namespace {

constexpr std::array kNames{"latitude", "longitude", "height", "heading", "pitch", "roll"};
/// Cameras further away than this see a point; the bound keeps squares of distances finite.
constexpr double kFarthest_m = 1e13;
/// The sine of the angle from the vertical under which heading is read from the picture's upper edge.
constexpr double kVertical = 1e-14;

std::optional<double> numberFrom(std::string_view text) {
  text = raster::trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

tl::unexpected<io::Failure> wrong(std::string message, std::string_view text) {
  return io::fail(io::Failure::Code::invalidArgument, std::move(message), fmt::format("camera '{}'", text));
}

/// Forward, right and up of a camera in the axes (east, north, up) of its place.
geo::Mat3 enuFromCamera(const Camera& c) {
  const auto heading = geo::sinCos(c.heading);
  const auto pitch = geo::sinCos(c.pitch);
  const auto roll = geo::sinCos(c.roll);
  const geo::Vec3 forward(pitch.cos * heading.sin, pitch.cos * heading.cos, pitch.sin);
  const geo::Vec3 level(heading.cos, -heading.sin, 0.0);
  const geo::Vec3 upright = geo::cross(level, forward);
  const geo::Vec3 right = level * roll.cos - upright * roll.sin;
  const geo::Vec3 up = upright * roll.cos + level * roll.sin;
  return geo::Mat3(right, up, -forward);
}

}  // namespace

io::Result<Camera> parseCamera(std::string_view text) {
  std::array<double, 6> values{0.0, 0.0, 0.0, 0.0, -90.0, 0.0};
  std::size_t count = 0;
  for (std::string_view rest = text;; ++count) {
    if (count == values.size()) return wrong("more than LAT,LON,HEIGHT,HEADING,PITCH,ROLL", text);
    const auto comma = rest.find(',');
    const auto number = numberFrom(rest.substr(0, comma));
    if (!number) return wrong(fmt::format("the {} is not a number", kNames[count]), text);
    values[count] = *number;
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  if (count < 2) return wrong("LAT,LON,HEIGHT are needed (degrees and metres)", text);
  if (std::abs(values[0]) > 90.0) return wrong("the latitude is beyond -90..90 degrees", text);
  if (std::abs(values[1]) > 1e6) return wrong("the longitude is beyond reason", text);
  if (std::abs(values[2]) > kFarthest_m) return wrong("the height is beyond 1e13 m", text);
  if (std::abs(values[4]) > 90.0) return wrong("the pitch is beyond -90..90 degrees", text);
  return Camera{
      .position = {.lat = geo::Angle::degrees(values[0]), .lon = geo::Angle::degrees(values[1]), .height_m = values[2]},
      .heading = geo::Angle::degrees(values[3]),
      .pitch = geo::Angle::degrees(values[4]),
      .roll = geo::Angle::degrees(values[5])};
}

Sides View::sides() const {
  if (offAxis) return *offAxis;
  const double y = std::tan(verticalFov.radians() / 2.0);
  const double x = y * viewport.width / viewport.height;
  return {.left = -x, .right = x, .bottom = -y, .top = y};
}

std::string formatCamera(const Camera& camera) {
  const auto angle = [](geo::Angle a) { return std::round(a.degrees() * 1e7) / 1e7 + 0.0; };  // never -0
  return fmt::format("{:.9f},{:.9f},{:.4f},{:.7f},{:.7f},{:.7f}", camera.position.lat.degrees(),
                     camera.position.lon.degrees(), camera.position.height_m, angle(camera.heading),
                     angle(camera.pitch), angle(camera.roll));
}

double View::pixelAngle() const {
  if (agreedPixelAngle) return *agreedPixelAngle;
  if (offAxis) return std::min(offAxis->width() / viewport.width, offAxis->height() / viewport.height);
  return 2.0 * std::tan(verticalFov.radians() / 2.0) / viewport.height;
}

View viewOf(const Camera& camera, const geo::Ellipsoid& ellipsoid, geo::Angle verticalFov, Viewport viewport) {
  const geo::LocalFrame local = geo::localFrameAt(ellipsoid, camera.position);
  const geo::Mat3 bodyFromView = local.bodyFromEnu() * enuFromCamera(camera);
  return View{.eye = local.origin,
              .viewFromBody = glm::transpose(bodyFromView),
              .verticalFov = verticalFov,
              .viewport = viewport};
}

Camera cameraOf(const View& view, const geo::Ellipsoid& ellipsoid) {
  Camera c;
  c.position = ellipsoid.geodeticFromBody(view.eye);
  const geo::LocalFrame local = geo::localFrameAt(ellipsoid, c.position);
  const geo::Mat3 enuFromView = glm::transpose(local.bodyFromEnu()) * glm::transpose(view.viewFromBody);
  const geo::Vec3 right = enuFromView[0];
  const geo::Vec3 up = enuFromView[1];
  const geo::Vec3 forward = -enuFromView[2];
  const double across = std::hypot(forward.x, forward.y);
  c.pitch = geo::Angle::radians(std::atan2(forward.z, across));
  // Straight down the upper edge of the picture points where the heading does; straight up it points the other way.
  const geo::Vec3 ahead = across > kVertical ? forward : up * (forward.z < 0.0 ? 1.0 : -1.0);
  c.heading = geo::Angle::radians(std::atan2(ahead.x, ahead.y));
  const geo::Vec3 level(std::cos(c.heading.radians()), -std::sin(c.heading.radians()), 0.0);
  c.roll = geo::Angle::radians(std::atan2(geo::dot(up, level), geo::dot(right, level)));
  return c;
}

}  // namespace tellurion::scene
