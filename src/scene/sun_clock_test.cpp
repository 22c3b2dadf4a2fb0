// The sun that goes by the scene's clock.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "geo/sun.h"
#include "scene/globe.h"
#include "scene/procedural_source_test.h"

namespace tellurion::scene {
namespace {

constexpr double kMidsummer2026_s = 1782043200.0;  // 2026-06-21T12:00:00Z

io::Result<std::unique_ptr<Globe>> globeOf(const geo::Body& body, std::optional<double> start_s) {
  Scene scene;
  scene.name = "sunny.toml";
  scene.body = body;
  scene.clock.start_s = start_s;
  scene.lighting.sun = Lighting::Sun::byClock;
  return Globe::fromLayers(scene, {}, {});
}

View anyView(const geo::Body& body) {
  return viewOf(
      Camera{.position = {.lat = geo::Angle::degrees(20.0), .lon = geo::Angle::degrees(40.0), .height_m = 1.5e6}},
      body.ellipsoid, geo::Angle::degrees(45.0), {.width = 64, .height = 48});
}

TEST(SunByClock, StandsWhereItStandsAndGoesOnWithTheClock) {
  for (const geo::Body& body : {geo::earth(), geo::mars(), geo::moon()}) {
    auto globe = globeOf(body, kMidsummer2026_s);
    ASSERT_TRUE(globe) << io::describe(globe.error());
    EXPECT_EQ((*globe)->update(anyView(body)).light.toSun_body, geo::directionToSun(body, kMidsummer2026_s))
        << body.name;
    const double later_s = kMidsummer2026_s + 3600.0;
    (*globe)->setClock(later_s);
    EXPECT_EQ((*globe)->update(anyView(body)).light.toSun_body, geo::directionToSun(body, later_s)) << body.name;
  }
}

TEST(SunByClock, IsNorthAndOverGreenwichAtANoonOfJune) {
  auto globe = globeOf(geo::earth(), kMidsummer2026_s).value();
  const geo::Vec3 sun = globe->update(anyView(geo::earth())).light.toSun_body;
  EXPECT_NEAR(geo::Angle::radians(std::asin(sun.z)).degrees(), 23.43, 0.02);
  EXPECT_NEAR(geo::Angle::radians(std::atan2(sun.y, sun.x)).degrees(), 0.45, 0.1);  // 1 min 48 s behind the clock
}

TEST(SunByClock, StaysWhereTimesAreTooFar) {
  auto globe = globeOf(geo::earth(), kMidsummer2026_s).value();
  globe->setClock(1e15);
  EXPECT_EQ(globe->update(anyView(geo::earth())).light.toSun_body, geo::directionToSun(geo::earth(), kMidsummer2026_s));
}

TEST(SunByClock, NeedsATimeAndABodyThatItIsKnownOver) {
  const auto timeless = globeOf(geo::earth(), std::nullopt);
  ASSERT_FALSE(timeless);
  EXPECT_NE(io::describe(timeless.error()).find("--time"), std::string::npos) << io::describe(timeless.error());
  geo::Body pebble = geo::earth();
  pebble.name = "pebble";
  const auto unknown = globeOf(pebble, kMidsummer2026_s);
  ASSERT_FALSE(unknown);
  EXPECT_NE(io::describe(unknown.error()).find("'pebble'"), std::string::npos) << io::describe(unknown.error());
  EXPECT_FALSE(globeOf(geo::earth(), 1e15));
}

}  // namespace
}  // namespace tellurion::scene
