// Stars and discs as drawn: each where a ray through its pixel goes, as bright as its magnitude says, and behind the
// ground.

#include <array>
#include <cmath>
#include <random>

#include "geo/body.h"
#include "render/allocation_count_test.h"
#include "render/synthetic_tiles_test.h"
#include "scene/picking.h"
#include "scene/sky.h"

namespace tellurion::render {
namespace {

using raster::Rgba8;
using synthetic::viewAt;

constexpr scene::Viewport kSize{160, 120};

double fromSrgb(std::uint8_t byte) {
  const double s = byte / 255.0;
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

/// What is in a picture: all its light (of green), and where the middle of that is.
struct Light {
  double sum = 0.0;
  scene::PixelPosition middle;
};

Light lightIn(const raster::Raster<Rgba8>& picture) {
  Light out;
  for (int row = 0; row < picture.height; ++row) {
    for (int col = 0; col < picture.width; ++col) {
      const double light = fromSrgb(picture.at(col, row).g);
      out.sum += light;
      out.middle.x += light * (col + 0.5);
      out.middle.y += light * (row + 0.5);
    }
  }
  out.middle.x /= std::max(out.sum, 1e-12);
  out.middle.y /= std::max(out.sum, 1e-12);
  return out;
}

class Heavens : public synthetic::GlTest {
 protected:
  static Renderer makeSkyRenderer() {
    Renderer renderer = makeRenderer();
    const auto ready = renderer.prepareSky();
    if (!ready) ADD_FAILURE() << io::describe(ready.error());
    return renderer;
  }

  static raster::Raster<Rgba8> drawn(Renderer& renderer, const scene::Frame& frame) {
    RenderTarget target = makeTarget(kSize);
    renderer.draw(frame, target);
    return readColour(target);
  }

  static std::shared_ptr<const scene::StarCatalogue> one(const geo::Vec3& direction_celestial, double magnitude) {
    auto catalogue = std::make_shared<scene::StarCatalogue>();
    catalogue->serial = synthetic::nextSerial();
    catalogue->stars.push_back({.direction_celestial = geo::Vec3f(direction_celestial),
                                .magnitude = static_cast<float>(magnitude),
                                .colour = geo::Vec3f(1.0f)});
    return catalogue;
  }

  const geo::Ellipsoid earth_ = geo::earth().ellipsoid;
};

TEST_F(Heavens, StarsStandWhereTheyAreAndAreAsBrightAsTold) {
  Renderer renderer = makeSkyRenderer();
  std::mt19937 dice(5);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  // Beyond the middle of a picture of 45 degrees, a point of the sky is drawn larger; here not.
  for (int i = 0; i < 40; ++i) {
    scene::Frame frame;
    frame.view = viewAt(earth_, 180.0 * share(dice) - 90.0, 360.0 * share(dice), 1e7 * share(dice), 360.0 * share(dice),
                        90.0 * share(dice), kSize, 5.0);
    const scene::PixelPosition where{20.0 + 120.0 * share(dice), 20.0 + 80.0 * share(dice)};
    const scene::SkyPlaces places = scene::skyPlacesAt(geo::earth(), 2e9 * share(dice));
    frame.sky.bodyFromCelestial = places.bodyFromCelestial;
    const geo::Vec3 direction_body = scene::rayThrough(frame.view, where).direction;
    const double magnitude = 4.0 * share(dice) - 2.0;
    frame.sky.stars = one(glm::transpose(places.bodyFromCelestial) * direction_body, magnitude);
    const Light light = lightIn(drawn(renderer, frame));
    EXPECT_NEAR(light.middle.x, where.x, 0.1) << i;
    EXPECT_NEAR(light.middle.y, where.y, 0.1) << i;
    const double expected = 2.0 * geo::kPi * 0.7 * 0.7 * std::pow(10.0, -0.4 * (magnitude - 1.2));
    EXPECT_NEAR(light.sum / expected, 1.0, 0.1) << i << ", magnitude " << magnitude;
  }
}

TEST_F(Heavens, GroundAndMoonHideStars) {
  Renderer renderer = makeSkyRenderer();
  scene::Frame frame;
  frame.view = viewAt(earth_, 10, 20, 1e7, 0, -90, kSize);
  frame.light.enabled = false;
  frame.sky.stars = one(geo::normalize(-frame.view.eye.m), 0.0);
  EXPECT_GT(lightIn(drawn(renderer, frame)).sum, 1.0);
  frame.tiles = synthetic::wholeBody(tiling::Tiling(tiling::Scheme::cube), earth_, 2, 16);
  const auto whole = drawn(renderer, frame);
  frame.sky = {};
  EXPECT_EQ(drawn(renderer, frame).samples, whole.samples);

  frame.tiles.clear();
  frame.light.toSun_body = geo::normalize(-frame.view.eye.m);  // the Moon's far side is lit: it is new
  frame.sky.stars = one(geo::normalize(-frame.view.eye.m), 0.0);
  frame.sky.moon_m = -frame.view.eye.m * 30.0;
  EXPECT_LT(lightIn(drawn(renderer, frame)).sum, 0.01);
}

TEST_F(Heavens, TheMoonHasItsSizeAndPhase) {
  Renderer renderer = makeSkyRenderer();
  for (const double phase_degrees : {0.0, 40.0, 90.0, 130.0}) {
    scene::Frame frame;
    frame.view = viewAt(earth_, 10, 20, 400e3, 70, 60, kSize, 1.0);
    const geo::Vec3 away = scene::rayThrough(frame.view, {80.0, 60.0}).direction;
    const geo::Vec3 aside = scene::rayThrough(frame.view, {160.0, 60.0}).direction;
    const geo::Vec3 across = geo::normalize(aside - away * geo::dot(aside, away));
    const geo::SinCos phase = geo::sinCosDegrees(phase_degrees);
    frame.light.toSun_body = geo::normalize(across * phase.sin - away * phase.cos);
    frame.sky.moon_m = frame.view.eye.m + away * 384400e3;
    const auto picture = drawn(renderer, frame);
    int lit = 0;
    for (const Rgba8& pixel : picture.samples)
      lit += pixel.g > 0 ? 1 : 0;
    const double radius_px = std::asin(1737.4 / 384400.0) / frame.view.pixelAngle();
    const double expected = geo::kPi * radius_px * radius_px * (1.0 + phase.cos) / 2.0;
    EXPECT_NEAR(lit, expected, 0.03 * geo::kPi * radius_px * radius_px) << phase_degrees;
    EXPECT_GT(lightIn(picture).middle.x, 79.9) << phase_degrees;
  }
}

TEST_F(Heavens, TheMoonEclipsesTheSunAndHasItsOwnLight) {
  Renderer renderer = makeSkyRenderer();
  scene::Frame frame;
  frame.view = viewAt(earth_, 10, 20, 400e3, 70, 60, kSize, 2.0);
  const geo::Vec3 away = scene::rayThrough(frame.view, {80.0, 60.0}).direction;
  frame.light.toSun_body = away;
  frame.sky.sunRadius_radians = geo::Angle::degrees(0.25).radians();
  const double whole = lightIn(drawn(renderer, frame)).sum;
  frame.sky.moon_m = frame.view.eye.m + away * 370000e3;  // 0.269 degrees: total
  EXPECT_LT(lightIn(drawn(renderer, frame)).sum, 0.01 * whole);
  frame.sky.moon_m = frame.view.eye.m + away * 500000e3;  // 0.199 degrees: a ring
  EXPECT_NEAR(lightIn(drawn(renderer, frame)).sum / whole, 1.0 - std::pow(0.199 / 0.25, 2.0), 0.06);
  // The scene may have its sun elsewhere.
  frame.sky.sunRadius_radians = 0.0;
  EXPECT_LT(lightIn(drawn(renderer, frame)).sum, 0.01 * whole);
  frame.sky.toSun = -away;
  EXPECT_GT(lightIn(drawn(renderer, frame)).sum, 0.03 * whole);
}

TEST_F(Heavens, TheMoonEclipsesTheSunInAirToo) {
  Renderer renderer = makeSkyRenderer();
  const auto ready = renderer.prepareAir();
  ASSERT_TRUE(ready) << io::describe(ready.error());
  scene::Frame frame;
  frame.ellipsoid = earth_;
  frame.view = viewAt(earth_, 10, 20, 400e3, 70, 60, kSize, 2.0);  // above all of it: nothing else is in the picture
  frame.air = {.enabled = true, .atmosphere = *scene::atmosphereByName("earth"), .exposure_stops = 0.0};
  frame.air.atmosphere.sunRadius_degrees = 0.25;
  const geo::Vec3 away = scene::rayThrough(frame.view, {80.0, 60.0}).direction;
  frame.light.toSun_body = away;
  const auto withMoon = [&](const geo::Vec3& towards, double distance_m) {
    frame.sky.moon_m = frame.view.eye.m + geo::normalize(towards) * distance_m;
    return lightIn(drawn(renderer, frame)).sum;
  };
  const double whole = lightIn(drawn(renderer, frame)).sum;
  ASSERT_GT(whole, 100.0);
  EXPECT_LT(withMoon(away, 370000e3), 0.01 * whole);
  // Rims count whole, so bright is the disc in air: half a pixel of the 15 and 12 of the two.
  EXPECT_NEAR(withMoon(away, 500000e3) / whole, 1.0 - std::pow(0.199 / 0.25, 2.0), 0.08);
  // Half before it: what two equal discs, a radius apart, have in common is 0.391 of one.
  const geo::Vec3 aside = scene::rayThrough(frame.view, {80.0, 60.0 + 0.25 / 2.0 * kSize.height}).direction;
  const double alike_m = 1737.4e3 / std::sin(geo::Angle::degrees(0.25).radians());
  EXPECT_NEAR(withMoon(aside, alike_m) / whole, 1.0 - 0.391, 0.06);
  EXPECT_NEAR(withMoon(-away, 370000e3) / whole, 1.0, 1e-3) << "behind the eye";
}

TEST_F(Heavens, StarsAreSeenInChannelsOfLargerPixels) {
  Renderer renderer = makeSkyRenderer();
  scene::Frame frame;
  frame.view = viewAt(earth_, 10, 20, 400e3, 70, 60, kSize, 5.0);
  frame.sky.stars = one(scene::rayThrough(frame.view, {80.0, 60.0}).direction, 1.2);
  const double alone = lightIn(drawn(renderer, frame)).sum;
  frame.view.agreedPixelAngle = 0.05 * frame.view.pixelAngle();
  EXPECT_DOUBLE_EQ(lightIn(drawn(renderer, frame)).sum, alone);
}

TEST_F(Heavens, TheSunIsAsLargeAsTold) {
  Renderer renderer = makeSkyRenderer();
  scene::Frame frame;
  frame.view = viewAt(earth_, 10, 20, 400e3, 70, 60, kSize, 2.0);
  frame.light.toSun_body = scene::rayThrough(frame.view, {50.0, 70.0}).direction;
  frame.sky.sunRadius_radians = geo::Angle::degrees(0.25).radians();
  const Light light = lightIn(drawn(renderer, frame));
  const double radius_px = frame.sky.sunRadius_radians / frame.view.pixelAngle();
  EXPECT_NEAR(light.sum, geo::kPi * radius_px * radius_px, 0.05 * geo::kPi * radius_px * radius_px);
  EXPECT_NEAR(light.middle.x, 50.0, 0.1);
  EXPECT_NEAR(light.middle.y, 70.0, 0.1);
}

TEST_F(Heavens, AirDimsStarsByDayAndTowardsTheHorizon) {
  Renderer renderer = makeSkyRenderer();
  ASSERT_TRUE(renderer.prepareAir());
  const auto starLight = [&](double pitch, const geo::Vec3& toSun) {
    scene::Frame frame;
    frame.ellipsoid = earth_;
    frame.view = viewAt(earth_, 0, 0, 2.0, 90, pitch, kSize, 5.0);
    frame.air = {.enabled = true, .atmosphere = *scene::atmosphereByName("earth"), .exposure_stops = 0.0};
    frame.light.toSun_body = toSun;
    const Light without = lightIn(drawn(renderer, frame));
    frame.sky.stars = one(scene::rayThrough(frame.view, {80.0, 60.0}).direction, 0.0);
    return lightIn(drawn(renderer, frame)).sum - without.sum;
  };
  const geo::Vec3 night = -geo::directionFromDegrees(0, 0).n, day = geo::directionFromDegrees(30, 0).n;
  const double high = starLight(80.0, night);
  EXPECT_GT(high, 3.0);
  EXPECT_LT(starLight(3.0, night), 0.5 * high);
  EXPECT_LT(starLight(80.0, day), 0.05 * high);
}

TEST_F(Heavens, NothingIsAllocatedOnceTheCatalogueIsThere) {
  Renderer renderer = makeSkyRenderer();
  scene::Frame frame;
  frame.view = viewAt(earth_, 10, 20, 400e3, 70, 60, kSize);
  frame.sky.stars = scene::brightStars();
  frame.sky.moon_m = geo::Vec3(3.8e8, 0.0, 0.0);
  RenderTarget target = makeTarget(kSize);
  renderer.draw(frame, target);
  startCountingAllocations();
  const int drawCalls = renderer.draw(frame, target).drawCalls;
  EXPECT_EQ(allocationsCounted(), 0);
  EXPECT_EQ(drawCalls, 2);
}

}  // namespace
}  // namespace tellurion::render
