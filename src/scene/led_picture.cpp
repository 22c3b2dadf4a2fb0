#include "scene/led_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "io/byte_stream.h"

namespace tellurion::scene {
namespace {

constexpr double kFarthest_m = 1e13;
constexpr double kMostTime_s = 1e12;
constexpr double kMostPixels = 1e9;
constexpr double kMostExaggeration = 100.0;
constexpr double kMostStops = 100.0;
constexpr double kOffUnit = 1e-6;  // of a rotation's columns and a direction's length
constexpr std::size_t kMostLayers = 4096;

void add(io::ByteWriter& to, const geo::Vec3& v) {
  for (int i = 0; i < 3; ++i)
    to.add(v[i]);
}

void add(io::ByteWriter& to, const std::optional<double>& value) {
  to.addBool(value.has_value());
  to.add(value.value_or(0.0));
}

/// Takes values that have to be within a range; what is not makes all of it bad.
class Taking {
 public:
  explicit Taking(std::string_view bytes) : reader_(bytes) {}

  bool isGood() const { return reader_.isGood() && isGood_; }
  bool isAtEnd() const { return reader_.isAtEnd() && isGood_; }
  void require(bool condition) { isGood_ = isGood_ && condition; }

  double number(double low, double high) {
    const double value = reader_.takeDouble();
    require(value >= low && value <= high);
    return value;
  }
  std::optional<double> maybe(double low, double high) {
    const bool isThere = reader_.takeBool();
    const double value = number(isThere ? low : 0.0, isThere ? high : 0.0);
    return isThere ? std::optional(value) : std::nullopt;
  }
  geo::Vec3 vector(double most) {
    geo::Vec3 v(0.0);
    for (int i = 0; i < 3; ++i)
      v[i] = number(-most, most);
    return v;
  }
  geo::Vec3 unit() {
    const geo::Vec3 v = vector(1.0 + kOffUnit);
    require(std::abs(geo::length(v) - 1.0) < kOffUnit);
    return v;
  }
  bool flag() { return reader_.takeBool(); }
  /// At most `most`.
  std::uint32_t count(std::size_t most) {
    const auto value = reader_.take<std::uint32_t>();
    require(value <= most);
    return isGood() ? value : 0;
  }

 private:
  io::ByteReader reader_;
  bool isGood_ = true;
};

/// Pixels, or infinitely many: what is told in them does not count.
double pixels(Taking& from) {
  const double value = from.number(0.0, std::numeric_limits<double>::infinity());
  from.require(value > 0.0 && (value <= kMostPixels || std::isinf(value)));
  return value;
}

geo::Mat3 rotation(Taking& from) {
  geo::Mat3 m(1.0);
  for (int i = 0; i < 3; ++i)
    m[i] = from.unit();
  from.require(geo::length(geo::cross(m[0], m[1]) - m[2]) < kOffUnit);
  return m;
}

LayerLook look(Taking& from) {
  LayerLook taken{.visible = from.flag(), .opacity = from.number(0.0, 1.0)};
  taken.blend = static_cast<BlendMode>(from.count(kBlendModes.size() - 1));
  taken.brightness = from.number(0.0, kMostAdjustment);
  taken.contrast = from.number(0.0, kMostAdjustment);
  taken.saturation = from.number(0.0, kMostAdjustment);
  taken.gamma = from.number(kLeastGamma, kMostAdjustment);
  return taken;
}

void add(io::ByteWriter& to, const LayerLook& look) {
  to.addBool(look.visible);
  to.add(look.opacity);
  to.add(static_cast<std::uint32_t>(look.blend));
  for (const double value : {look.brightness, look.contrast, look.saturation, look.gamma})
    to.add(value);
}

void add(io::ByteWriter& to, const Lighting& lighting) {
  to.addBool(lighting.enabled);
  to.add(static_cast<std::uint32_t>(lighting.sun));
  add(to, lighting.subsolar.n);
  to.add(lighting.ambient);
}

Lighting lighting(Taking& from) {
  Lighting taken{.enabled = from.flag()};
  taken.sun = static_cast<Lighting::Sun>(from.count(static_cast<std::size_t>(Lighting::Sun::byClock)));
  taken.subsolar.n = from.unit();
  taken.ambient = from.number(0.0, 1.0);
  return taken;
}

}  // namespace

LedPicture ledPicture(Globe& globe, const View& view, const CutOptions& cut) {
  const auto looks = globe.imageryLooks();
  const auto order = globe.imageryOrder();
  return {.eye = view.eye,
          .viewFromBody = view.viewFromBody,
          .verticalFov = view.verticalFov,
          .cutTime_s = cut.time_s.value_or(0.0),
          .clock_s = globe.clock(),
          .tolerance_px = cut.tolerance_px,
          .texelTolerance_px = cut.texelTolerance_px,
          .maxSpacing_px = cut.maxSpacing_px,
          .morph = cut.morph,
          .exaggeration = globe.exaggeration(),
          .lighting = globe.lighting(),
          .airEnabled = globe.air().enabled,
          .exposure_stops = globe.air().exposure_stops,
          .skyEnabled = globe.sky().enabled,
          .skyBrightness_stops = globe.sky().brightness_stops,
          .discs = globe.sky().discs,
          .background = globe.background(),
          .looks = {looks.begin(), looks.end()},
          .order = {order.begin(), order.end()}};
}

io::Result<CutOptions> apply(const LedPicture& picture, Globe& globe, CutOptions own) {
  const auto looks = globe.imageryLooks();
  if (looks.size() != picture.looks.size())
    return io::fail(io::Failure::Code::invalidArgument,
                    fmt::format("the leader's scene has {} layers of imagery, this one {}: give all machines the same",
                                picture.looks.size(), looks.size()));
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const LayerRole role = looks[i].role;
    looks[i] = picture.looks[i];
    looks[i].role = role;
  }
  for (std::size_t place = 0; place < picture.order.size(); ++place) {
    if (globe.imageryOrder()[place] != picture.order[place]) globe.moveImagery(picture.order[place], place);
  }
  if (picture.clock_s && globe.clock() != picture.clock_s) globe.setClock(*picture.clock_s);
  globe.exaggeration() = picture.exaggeration;
  globe.lighting() = picture.lighting;
  globe.air().enabled = picture.airEnabled;
  if (picture.airEnabled) knowAir(globe.air(), globe.body().name);
  globe.air().exposure_stops = picture.exposure_stops;
  globe.sky().enabled = picture.skyEnabled;
  globe.sky().brightness_stops = picture.skyBrightness_stops;
  globe.sky().discs = picture.discs;
  globe.background() = picture.background;
  own.time_s = picture.cutTime_s;
  own.tolerance_px = picture.tolerance_px;
  own.texelTolerance_px = picture.texelTolerance_px;
  own.maxSpacing_px = picture.maxSpacing_px;
  own.morph = picture.morph;
  return own;
}

View viewOf(const LedPicture& picture, Viewport size) {
  return {
      .eye = picture.eye, .viewFromBody = picture.viewFromBody, .verticalFov = picture.verticalFov, .viewport = size};
}

std::string encode(const LedPicture& picture) {
  io::ByteWriter to;
  add(to, picture.eye.m);
  for (int i = 0; i < 3; ++i)
    add(to, picture.viewFromBody[i]);
  to.add(picture.verticalFov.radians());
  to.add(picture.cutTime_s);
  add(to, picture.clock_s);
  for (const double value : {picture.tolerance_px, picture.texelTolerance_px, picture.maxSpacing_px})
    to.add(value);
  to.addBool(picture.morph);
  to.add(picture.exaggeration);
  add(to, picture.lighting);
  to.addBool(picture.airEnabled);
  add(to, picture.exposure_stops);
  to.addBool(picture.skyEnabled);
  to.add(picture.skyBrightness_stops);
  to.addBool(picture.discs);
  for (const float value : picture.background)
    to.add(static_cast<double>(value));
  to.add(static_cast<std::uint32_t>(picture.looks.size()));
  for (const LayerLook& look : picture.looks)
    add(to, look);
  for (const std::uint32_t layer : picture.order)
    to.add(layer);
  return to.bytes();
}

io::Result<LedPicture> decodeLedPicture(std::string_view bytes) {
  Taking from(bytes);
  LedPicture picture;
  picture.eye.m = from.vector(kFarthest_m);
  picture.viewFromBody = rotation(from);
  picture.verticalFov = geo::Angle::radians(from.number(1e-9, geo::kPi));
  picture.cutTime_s = from.number(0.0, kMostTime_s);
  picture.clock_s = from.maybe(-kMostTime_s, kMostTime_s);
  picture.tolerance_px = pixels(from);
  picture.texelTolerance_px = pixels(from);
  picture.maxSpacing_px = pixels(from);
  picture.morph = from.flag();
  picture.exaggeration = from.number(0.0, kMostExaggeration);
  picture.lighting = lighting(from);
  picture.airEnabled = from.flag();
  picture.exposure_stops = from.maybe(-kMostStops, kMostStops);
  picture.skyEnabled = from.flag();
  picture.skyBrightness_stops = from.number(-kMostStops, kMostStops);
  picture.discs = from.flag();
  for (float& value : picture.background)
    value = static_cast<float>(from.number(0.0, 1.0));
  const std::uint32_t layers = from.count(kMostLayers);
  for (std::uint32_t i = 0; i < layers && from.isGood(); ++i)
    picture.looks.push_back(look(from));
  std::vector<bool> isThere(layers, false);
  for (std::uint32_t i = 0; i < layers && from.isGood(); ++i) {
    const std::uint32_t layer = from.count(layers - 1);
    from.require(!isThere[layer]);
    isThere[layer] = true;
    picture.order.push_back(layer);
  }
  if (!from.isAtEnd())
    return io::fail(io::Failure::Code::corrupt, "the leader says what no leader says: its picture cannot be read");
  return picture;
}

}  // namespace tellurion::scene
