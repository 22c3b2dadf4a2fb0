#include "scene/camera_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <sstream>

#include "geo/local_frame.h"

namespace tellurion::scene {
namespace {

using geo::Direction;
using geo::Vec3;

constexpr double kHeightScale_m = 100.0;
constexpr std::string_view kHeader = "seconds,lat,lon,height_m,heading,pitch,roll";

/// The tangent at `from` that leads to `to` along the great circle; its length is the angle.
Vec3 tangentTo(const Direction& from, const Direction& to) {
  const Vec3 across = to.n - from.n * geo::dot(from.n, to.n);
  const double length = geo::length(across);
  return length > 0.0 ? across * (geo::angleBetween(from, to).radians() / length) : Vec3(0.0, 0.0, 0.0);
}

Direction along(const Direction& from, const Vec3& tangent) {
  const double angle = geo::length(tangent);
  if (!(angle > 0.0)) return from;
  return {geo::normalize(from.n * std::cos(angle) + tangent * (std::sin(angle) / angle))};
}

Direction between(const Direction& a, const Direction& b, double share) {
  return along(a, tangentTo(a, b) * share);
}

/// Towards north where the camera looks down or up; the tangent that heading means at a place.
Vec3 headingVector(const Direction& place, geo::Angle heading) {
  const geo::Geodetic g = geo::geodeticFromDirection(place);
  const geo::LocalFrame frame = geo::localFrameAt(geo::earth().ellipsoid, g);
  const geo::SinCos h = geo::sinCos(heading);
  return frame.east * h.sin + frame.north * h.cos;
}

geo::Angle headingOf(const geo::Geodetic& place, const Vec3& vector) {
  const geo::LocalFrame frame = geo::localFrameAt(geo::earth().ellipsoid, place);
  return geo::Angle::radians(std::atan2(geo::dot(vector, frame.east), geo::dot(vector, frame.north)));
}

double shortWay(double radians) {
  return std::remainder(radians, 2.0 * geo::kPi);
}

/// Slopes of a cubic through values that never overshoots (Fritsch and Butland 1984: the weighted harmonic mean of the
/// two secants, 0 where they differ in sign).
std::vector<double> monotoneSlopes(const std::vector<double>& times, const std::vector<double>& values) {
  const std::size_t n = values.size();
  std::vector<double> slopes(n, 0.0);
  const auto secant = [&](std::size_t i) { return (values[i + 1] - values[i]) / (times[i + 1] - times[i]); };
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = secant(i - 1);
    const double after = secant(i);
    if (before * after <= 0.0) continue;
    const double short1 = times[i + 1] - times[i - 1] + (times[i + 1] - times[i]);
    const double short2 = times[i + 1] - times[i - 1] + (times[i] - times[i - 1]);
    slopes[i] = (short1 + short2) / (short1 / before + short2 / after);
  }
  if (n >= 2) slopes.front() = secant(0);
  if (n >= 2) slopes.back() = secant(n - 2);
  return slopes;
}

bool isFinite(const CameraPath::Key& key) {
  const Camera& c = key.camera;
  return std::isfinite(key.seconds) && std::isfinite(c.position.lat.radians()) &&
         std::isfinite(c.position.lon.radians()) && std::isfinite(c.position.height_m) &&
         std::isfinite(c.heading.radians()) && std::isfinite(c.pitch.radians()) && std::isfinite(c.roll.radians());
}

}  // namespace

CameraPath::CameraPath(std::vector<Key> keys) : keys_(std::move(keys)) {
  makePlaces();
  makeChannels();
}

io::Result<CameraPath> CameraPath::create(std::vector<Key> keys) {
  const auto wrong = [](std::string message) {
    return io::fail(io::Failure::Code::invalidArgument, std::move(message));
  };
  if (keys.empty()) return wrong("a camera path needs at least one key");
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (!isFinite(keys[i]))
      return wrong(fmt::format("key {} of the camera path has a value that is not finite", i + 1));
    if (i > 0 && !(keys[i].seconds > keys[i - 1].seconds)) {
      return wrong(fmt::format("the seconds of key {} of the camera path do not come after those before it", i + 1));
    }
  }
  return CameraPath(std::move(keys));
}

void CameraPath::makePlaces() {
  for (const Key& key : keys_)
    places_.push_back(geo::directionFromLatLon(key.camera.position.lat, key.camera.position.lon));
  const std::size_t n = places_.size();
  // Velocities in radians a second: as the heights' slopes, the weighted harmonic mean of the speeds before and after,
  // zero where the way turns back.
  std::vector<Vec3> velocity(n, Vec3(0.0, 0.0, 0.0));
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before_s = keys_[i].seconds - keys_[i - 1].seconds;
    const double after_s = keys_[i + 1].seconds - keys_[i].seconds;
    const Vec3 before = -tangentTo(places_[i], places_[i - 1]) / before_s;
    const Vec3 after = tangentTo(places_[i], places_[i + 1]) / after_s;
    const double slow = geo::length(before);
    const double fast = geo::length(after);
    if (geo::dot(before, after) <= 0.0) continue;
    const Vec3 mean = (before * after_s + after * before_s) / (before_s + after_s);
    const double speed = std::min(geo::length(mean), 2.0 * std::min(slow, fast));
    velocity[i] = geo::normalize(mean) * speed;
  }
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double third_s = (keys_[i + 1].seconds - keys_[i].seconds) / 3.0;
    const Vec3 there = tangentTo(places_[i], places_[i + 1]) / (3.0 * third_s);
    const Vec3 back = -tangentTo(places_[i + 1], places_[i]) / (3.0 * third_s);
    const Vec3 start = i == 0 ? there : velocity[i];
    const Vec3 stop = i + 2 == n ? back : velocity[i + 1];
    segments_.push_back(
        {.control1 = along(places_[i], start * third_s), .control2 = along(places_[i + 1], -stop * third_s)});
  }
}

void CameraPath::makeChannels() {
  std::vector<double> times;
  double heading = 0.0;
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const Camera& c = keys_[i].camera;
    times.push_back(keys_[i].seconds);
    height_.values.push_back(std::asinh(c.position.height_m / kHeightScale_m));
    if (i == 0) {
      pitch_.values.push_back(c.pitch.radians());
      roll_.values.push_back(c.roll.radians());
    } else {
      const Vec3 before = geo::rotatedBetween(headingVector(places_[i - 1], keys_[i - 1].camera.heading),
                                              places_[i - 1].n, places_[i].n);
      const geo::Geodetic here = geo::geodeticFromDirection(places_[i]);
      const Vec3 now = headingVector(places_[i], c.heading);
      heading += shortWay((headingOf(here, now) - headingOf(here, before)).radians());
      pitch_.values.push_back(pitch_.values.back() + shortWay(c.pitch.radians() - pitch_.values.back()));
      roll_.values.push_back(roll_.values.back() + shortWay(c.roll.radians() - roll_.values.back()));
    }
    heading_.values.push_back(heading);
  }
  for (Channel* channel : {&height_, &heading_, &pitch_, &roll_})
    channel->slopes = monotoneSlopes(times, channel->values);
}

double CameraPath::sample(const Channel& channel, std::size_t i, double time) const {
  const double span = keys_[i + 1].seconds - keys_[i].seconds;
  const double x = (time - keys_[i].seconds) / span;
  const double y = 1.0 - x;
  return channel.values[i] * (y * y * (1.0 + 2.0 * x)) + channel.values[i + 1] * (x * x * (1.0 + 2.0 * y)) +
         span * x * y * (channel.slopes[i] * y - channel.slopes[i + 1] * x);
}

Camera CameraPath::at(Seconds when) const {
  const double time = when.count();
  if (!(time > keys_.front().seconds)) return keys_.front().camera;
  if (time >= keys_.back().seconds) return keys_.back().camera;
  const auto next =
      std::upper_bound(keys_.begin(), keys_.end(), time, [](double t, const Key& k) { return t < k.seconds; });
  const auto i = static_cast<std::size_t>(next - keys_.begin()) - 1;
  const double share = (time - keys_[i].seconds) / (keys_[i + 1].seconds - keys_[i].seconds);
  std::array<Direction, 4> points{places_[i], segments_[i].control1, segments_[i].control2, places_[i + 1]};
  for (std::size_t count = 3; count > 0; --count) {
    for (std::size_t k = 0; k < count; ++k)
      points[k] = between(points[k], points[k + 1], share);
  }
  Camera camera;
  camera.position = geo::geodeticFromDirection(points[0]);
  const Vec3 start = geo::rotatedBetween(headingVector(places_[i], keys_[i].camera.heading), places_[i].n, points[0].n);
  const double turned = sample(heading_, i, time) - heading_.values[i];
  camera.heading = headingOf(camera.position, start) + geo::Angle::radians(turned);
  camera.heading = geo::Angle::radians(shortWay(camera.heading.radians()));
  camera.position.height_m = kHeightScale_m * std::sinh(sample(height_, i, time));
  camera.pitch = geo::Angle::radians(sample(pitch_, i, time));
  camera.roll = geo::Angle::radians(sample(roll_, i, time));
  return camera;
}

io::Result<CameraPath> parseCameraPath(std::string_view text, const std::string& name) {
  std::vector<CameraPath::Key> keys;
  int number = 0;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    ++number;
    while (!line.empty() && (line.back() == '\r' || line.back() == ' '))
      line.remove_suffix(1);
    if (line.empty() || line.front() == '#' || (keys.empty() && line == kHeader)) continue;
    const std::string where = fmt::format("{}:{}", name, number);
    const auto comma = std::min(line.find(','), line.size());
    double seconds = 0.0;
    const auto [stop, error] = std::from_chars(line.data(), line.data() + comma, seconds);
    if (error != std::errc() || stop != line.data() + comma || comma == line.size()) {
      return io::fail(io::Failure::Code::invalidArgument, fmt::format("a line reads {}", kHeader), where);
    }
    auto camera = parseCamera(line.substr(comma + 1));
    if (!camera) return io::fail(camera.error().code, camera.error().message, where);
    if (!keys.empty() && !(seconds > keys.back().seconds)) {
      return io::fail(io::Failure::Code::invalidArgument, "the seconds do not come after those of the line before",
                      where);
    }
    keys.push_back({.seconds = seconds, .camera = *camera});
  }
  if (keys.empty())
    return io::fail(io::Failure::Code::invalidArgument, "the camera path has no line with a camera", name);
  return CameraPath::create(std::move(keys));
}

io::Result<CameraPath> readCameraPath(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return io::fail(io::Failure::Code::notFound, "the camera path cannot be opened", path);
  std::ostringstream text;
  text << file.rdbuf();
  return parseCameraPath(text.str(), path);
}

std::string formatCameraPath(std::span<const CameraPath::Key> keys) {
  std::string text = fmt::format("{}\n", kHeader);
  for (const CameraPath::Key& key : keys)
    text += fmt::format("{:.4f},{}\n", key.seconds, formatCamera(key.camera));
  return text;
}

}  // namespace tellurion::scene
