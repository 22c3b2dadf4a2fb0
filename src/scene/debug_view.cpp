#include "scene/debug_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tellurion::scene {
namespace {

std::uint8_t byteOf(double v) {
  return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(v, 0.0, 1.0)));
}

raster::Rgba8 opaque(double r, double g, double b) {
  return {byteOf(r), byteOf(g), byteOf(b), 255};
}

/// Of full saturation; hue in turns from red over green to blue.
geo::Vec3 hueColour(double hue) {
  const auto channel = [hue](double peak) {
    const double away = std::abs(std::remainder(hue - peak, 1.0));
    return std::clamp(2.0 - 6.0 * away, 0.0, 1.0);
  };
  return {channel(0.0), channel(1.0 / 3.0), channel(2.0 / 3.0)};
}

std::string namesJoined() {
  std::string all;
  for (const DebugView view : kDebugViews)
    all += (all.empty() ? "" : ", ") + std::string(nameOf(view));
  return all;
}

/// How far the lines of a pyramid go where they meet no ground.
double reach_m(const geo::BodyPosition& eye, const geo::Ellipsoid& ellipsoid) {
  const double fromCentre_m = geo::length(eye.m);
  const double radius_m = ellipsoid.semiMinorAxis_m();
  if (fromCentre_m <= radius_m) return radius_m;
  return std::sqrt((fromCentre_m - radius_m) * (fromCentre_m + radius_m));
}

}  // namespace

std::string_view nameOf(DebugView view) {
  switch (view) {
    case DebugView::wireframe:
      return "wireframe";
    case DebugView::levels:
      return "levels";
    case DebugView::error:
      return "error";
    case DebugView::boxes:
      return "boxes";
  }
  return {};
}

io::Result<DebugViews> parseDebugViews(std::string_view text) {
  DebugViews views;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string_view name = text.substr(begin, end - begin);
    const auto* const found =
        std::find_if(kDebugViews.begin(), kDebugViews.end(), [name](DebugView view) { return nameOf(view) == name; });
    if (found == kDebugViews.end()) {
      return io::fail(
          io::Failure::Code::invalidArgument,
          fmt::format("'{}' is no debug view; there are {}, with commas between them", name, namesJoined()));
    }
    views.add(*found);
    begin = end + 1;
  }
  return views;
}

raster::Rgba8 levelColour(int level) {
  // Steps of 5/13 of a turn: neighbours are far apart, and 13 levels have 13 hues. The second round is darker.
  const double strength = (level / 13) % 2 == 0 ? 1.0 : 0.6;
  const geo::Vec3 colour = hueColour(std::fmod(level * 5.0 / 13.0, 1.0)) * strength;
  return opaque(colour.x, colour.y, colour.z);
}

raster::Rgba8 errorColour(double error_px, double tolerance_px) {
  const double share = error_px / tolerance_px;
  if (share <= 0.5) return opaque(0.0, 2.0 * share, 1.0);
  if (share <= 1.0) return opaque(0.0, 1.0, 2.0 - 2.0 * share);
  return opaque(1.0, 0.5 * std::max(0.0, 2.0 - share), 0.0);
}

std::array<Segment, 8> pyramidOf(const View& view, const geo::Ellipsoid& ellipsoid) {
  const geo::Mat3 bodyFromView = glm::transpose(view.viewFromBody);
  const Sides sides = view.sides();
  std::array<geo::BodyPosition, 4> ends;
  for (std::size_t i = 0; i < 4; ++i) {  // around the picture
    const double x = i == 0 || i == 3 ? sides.left : sides.right;
    const double y = i < 2 ? sides.bottom : sides.top;
    const geo::Vec3 ray = geo::normalize(bodyFromView * geo::Vec3(x, y, -1.0));
    const auto hit_m = ellipsoid.intersect({view.eye, ray});
    ends[i] = view.eye + ray * hit_m.value_or(reach_m(view.eye, ellipsoid));
  }
  std::array<Segment, 8> lines;
  for (std::size_t i = 0; i < 4; ++i) {
    lines[i] = {view.eye, ends[i]};
    lines[4 + i] = {ends[i], ends[(i + 1) % 4]};
  }
  return lines;
}

}  // namespace tellurion::scene
