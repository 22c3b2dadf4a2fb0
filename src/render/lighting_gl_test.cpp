// The light of drawn ground against the same formulas in double precision, with the shaders' own constants.

#include <cmath>

#include "geo/body.h"
#include "render/synthetic_tiles_test.h"
#include "scene/picking.h"

namespace tellurion::render {
namespace shading {
#include "render/shaders/constants.glsl"
}  // namespace shading
namespace {

using raster::Rgba8;
using synthetic::viewAt;

double fromSrgb(std::uint8_t byte) {
  const double s = byte / 255.0;
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

double toSrgb255(double linear) {
  const double l = std::clamp(linear, 0.0, 1.0);
  return 255.0 * (l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1.0 / 2.4) - 0.055);
}

double smooth(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

struct Ground {
  Rgba8 texel;
  std::uint8_t lamps = 0;
  geo::Vec3 relief{0.0};  // shading normal minus up
};

geo::Vec3 litReference(const Ground& ground, const geo::Vec3& up, const scene::Light& light) {
  const double sunHeight = geo::dot(up, light.toSun_body);
  const double facing = std::max(geo::dot(geo::normalize(up + ground.relief), light.toSun_body), 0.0);
  const double sunlight = facing * smooth(static_cast<double>(shading::kSunriseBegins),
                                          static_cast<double>(shading::kSunriseEnds), sunHeight);
  const double night = 1.0 - smooth(static_cast<double>(shading::kNightLightsFull),
                                    static_cast<double>(shading::kNightLightsOut), sunHeight);
  const geo::Vec3 lamps =
      geo::Vec3(static_cast<double>(shading::kNightLightRed), static_cast<double>(shading::kNightLightGreen),
                static_cast<double>(shading::kNightLightBlue)) *
      (ground.lamps / 255.0 * night);
  const geo::Vec3 albedo(fromSrgb(ground.texel.r), fromSrgb(ground.texel.g), fromSrgb(ground.texel.b));
  return albedo * (light.ambient + (1.0 - light.ambient) * sunlight) + lamps;
}

class Lighting : public synthetic::GlTest {
 protected:
  static constexpr scene::Viewport kSize{64, 48};

  /// A whole Moon of one ground, seen from far.
  scene::Frame frameOf(const Ground& ground, const scene::Light& light) const {
    scene::Frame frame;
    frame.view = viewAt(moon_, 10, 30, 6e6, 0, -90, kSize, 30);
    frame.light = light;
    frame.tiles = synthetic::wholeBody(tiling::Tiling(tiling::Scheme::cube), moon_, 2, 32);
    const auto colour = synthetic::plainImage(ground.texel);
    const auto coded = [](double v) { return static_cast<std::uint8_t>(std::lround(v * 127.0) + 128); };
    const auto relief =
        synthetic::plainImage({coded(ground.relief.x), coded(ground.relief.y), coded(ground.relief.z), 255});
    const auto lamps = synthetic::plainImage({0, 0, 0, ground.lamps});
    frame.looks = {{}, {.role = scene::LayerRole::nightLights}};
    for (scene::DrawnTile& tile : frame.tiles) {
      synthetic::paint(frame, tile, colour);
      if (ground.lamps > 0) {
        frame.pictures.push_back({.image = lamps, .window = {}, .layer = 1});
        ++tile.pictureCount;
      }
      if (ground.relief != geo::Vec3(0.0)) tile.relief = relief;
    }
    return frame;
  }

  void expectReference(const Ground& ground, const scene::Light& light) {
    const scene::Frame frame = frameOf(ground, light);
    RenderTarget target = makeTarget(kSize);
    makeRenderer().draw(frame, target);
    const auto picture = readColour(target);
    int compared = 0;
    for (int row = 1; row < kSize.height; row += 3) {
      for (int col = 1; col < kSize.width; col += 3) {
        const geo::Ray ray = scene::rayThrough(frame.view, {col + 0.5, row + 0.5});
        const auto along = moon_.intersect(ray);
        if (!along || geo::dot(ray.direction, geo::normalize(ray.origin.m + ray.direction * *along)) > -0.2) continue;
        const geo::Vec3 up = moon_.directionFromBody(ray.origin + ray.direction * *along).n;
        const geo::Vec3 linear = litReference(ground, up, light);
        const Rgba8 pixel = picture.at(col, row);
        EXPECT_NEAR(pixel.r, toSrgb255(linear.x), kTolerance) << col << ", " << row;
        EXPECT_NEAR(pixel.g, toSrgb255(linear.y), kTolerance) << col << ", " << row;
        EXPECT_NEAR(pixel.b, toSrgb255(linear.z), kTolerance) << col << ", " << row;
        ++compared;
      }
    }
    EXPECT_GT(compared, 100);
  }

  // Half a byte of rounding, and what a normal off by 1e-3 (chords, 16-bit normals) may change where sRGB is steepest.
  static constexpr double kTolerance = 1.6;
  const geo::Ellipsoid moon_ = geo::moon().ellipsoid;
};

geo::Vec3 sunOver(double lat, double lon) {
  return geo::directionFromDegrees(lat, lon).n;
}

TEST_F(Lighting, OfSmoothGroundIsLamberts) {
  for (const double lon : {30.0, 80.0, 115.0, 130.0, -60.0, -150.0})
    expectReference({.texel = {200, 120, 60, 255}}, {.toSun_body = sunOver(5, lon)});
}

TEST_F(Lighting, FollowsTheReliefsNormal) {
  // Texels of whole numbers, so that the reference needs no quantisation.
  const geo::Vec3 relief = geo::Vec3(40.0, -64.0, 20.0) / 127.0;
  for (const double lon : {30.0, 90.0, 120.0})
    expectReference({.texel = {180, 180, 180, 255}, .relief = relief}, {.toSun_body = sunOver(-20, lon)});
}

TEST_F(Lighting, AmbientReachesTheNight) {
  expectReference({.texel = {255, 128, 20, 255}}, {.toSun_body = sunOver(-10, -150), .ambient = 0.25});
}

TEST_F(Lighting, LampsBurnAtNightOnly) {
  const scene::Light noon{.toSun_body = sunOver(10, 30)};
  const scene::Light midnight{.toSun_body = -sunOver(10, 30)};
  expectReference({.texel = {30, 30, 60, 255}, .lamps = 200}, noon);
  expectReference({.texel = {30, 30, 60, 255}, .lamps = 200}, midnight);
  expectReference({.texel = {30, 30, 60, 255}, .lamps = 120}, {.toSun_body = sunOver(0, 115)});
}

TEST_F(Lighting, LampsAddNothingOnTheDaySide) {
  const scene::Light noon{.toSun_body = sunOver(10, 30)};
  const auto picture = [&](std::uint8_t lamps) {
    RenderTarget target = makeTarget(kSize);
    makeRenderer().draw(frameOf({.texel = {30, 30, 60, 255}, .lamps = lamps}, noon), target);
    return readColour(target);
  };
  // The middle of the picture is all day: the sun stands over it.
  const auto with = picture(255);
  const auto without = picture(0);
  for (int row = 15; row < 33; ++row) {
    for (int col = 22; col < 42; ++col)
      EXPECT_EQ(with.at(col, row), without.at(col, row)) << col << ", " << row;
  }
}

// 128 is exactly no relief: a neutral picture changes nothing.
TEST_F(Lighting, NeutralReliefIsNoRelief) {
  const Ground ground{.texel = {200, 120, 60, 255}};
  scene::Frame frame = frameOf(ground, {.toSun_body = sunOver(0, 90)});
  Renderer renderer = makeRenderer();
  RenderTarget target = makeTarget(kSize);
  renderer.draw(frame, target);
  const auto smoothGround = readColour(target);
  const auto neutral = synthetic::plainImage({128, 128, 128, 255});
  for (scene::DrawnTile& tile : frame.tiles)
    tile.relief = neutral;
  renderer.draw(frame, target);
  EXPECT_EQ(readColour(target).samples, smoothGround.samples);
}

}  // namespace
}  // namespace tellurion::render
