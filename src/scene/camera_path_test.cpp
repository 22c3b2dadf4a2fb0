#include "scene/camera_path.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geo/body.h"
#include "geo/seed_test.h"

namespace tellurion::scene {
namespace {

using Seconds = CameraPath::Seconds;

CameraPath parsed(std::string_view text) {
  auto path = parseCameraPath(text, "test.csv");
  EXPECT_TRUE(path) << (path ? "" : io::describe(path.error()));
  return std::move(*path);
}

geo::Direction placeOf(const Camera& c) {
  return geo::directionFromLatLon(c.position.lat, c.position.lon);
}

View viewAt(const CameraPath& path, double seconds) {
  return viewOf(path.at(Seconds(seconds)), geo::earth().ellipsoid, geo::Angle::degrees(45), {});
}

TEST(CameraPath, keysAreMet) {
  const CameraPath path = parsed(
      "seconds,lat,lon,height_m,heading,pitch,roll\n0,10,20,1000,5,-30,0\n\n# "
      "rest\n2,11,22,500000,350,-90,10\r\n5,-4,179,2e7,90,-45,0");
  EXPECT_EQ(path.duration().count(), 5.0);
  for (const auto& key : path.keys()) {
    const Camera c = path.at(Seconds(key.seconds));
    EXPECT_LT(geo::angleBetween(placeOf(c), placeOf(key.camera)).radians(), 1e-12);
    EXPECT_NEAR(c.position.height_m, key.camera.position.height_m, 1e-6 * key.camera.position.height_m);
    EXPECT_NEAR(std::remainder(c.heading.degrees() - key.camera.heading.degrees(), 360.0), 0.0, 1e-9);
    EXPECT_NEAR(c.pitch.degrees(), key.camera.pitch.degrees(), 1e-9);
  }
  EXPECT_LT(geo::angleBetween(placeOf(path.at(Seconds(-3))), geo::directionFromDegrees(10, 20)).radians(), 1e-12);
  EXPECT_LT(geo::angleBetween(placeOf(path.at(Seconds(99))), geo::directionFromDegrees(-4, 179)).radians(), 1e-12);
}

TEST(CameraPath, twoKeysAreTheGreatCircleAtConstantSpeed) {
  const CameraPath path = parsed("0,0,0,1000,90,0,0\n10,0,100,1000,90,0,0");
  for (int i = 0; i <= 10; ++i) {
    const Camera c = path.at(Seconds(i));
    EXPECT_NEAR(c.position.lon.degrees(), 10.0 * i, 1e-9);
    EXPECT_NEAR(c.position.lat.degrees(), 0.0, 1e-9);
    EXPECT_NEAR(c.heading.degrees(), 90.0, 1e-9);
    EXPECT_NEAR(c.position.height_m, 1000.0, 1e-6);
  }
}

TEST(CameraPath, theDateLineIsCrossedTheShortWay) {
  const CameraPath path = parsed("0,10,170,1000,80,-20,0\n4,10,-170,1000,100,-20,0");
  EXPECT_NEAR(std::abs(path.at(Seconds(2)).position.lon.degrees()), 180.0, 1e-9);
  EXPECT_NEAR(path.at(Seconds(2)).heading.degrees(), 90.0, 1e-6);
}

TEST(CameraPath, anglesTurnTheShortWay) {
  const CameraPath path = parsed("0,0,0,1000,350,-20,-170\n2,0,0,1000,10,-20,170");
  EXPECT_NEAR(std::remainder(path.at(Seconds(1)).heading.degrees(), 360.0), 0.0, 1e-9);
  EXPECT_NEAR(std::abs(path.at(Seconds(1)).roll.degrees()), 180.0, 1e-9);
}

TEST(CameraPath, crossingAPoleDoesNotSpin) {
  const CameraPath path = parsed("0,80,0,1e6,0,-90,0\n10,80,180,1e6,180,-90,0");
  geo::Mat3 before = viewAt(path, 0).viewFromBody;
  for (int i = 1; i <= 1000; ++i) {
    const geo::Mat3 now = viewAt(path, i * 0.01).viewFromBody;
    for (int k = 0; k < 3; ++k)
      EXPECT_LT(geo::length(now[k] - before[k]), 0.001) << i;
    before = now;
  }
}

TEST(CameraPath, isSmoothAtItsKeys) {
  std::mt19937_64 random = geo::seededGenerator();
  std::vector<CameraPath::Key> keys;
  for (int i = 0; i < 12; ++i) {
    keys.push_back({.seconds = i * 3.0 + geo::uniform(random, 0, 2),
                    .camera = {.position = {.lat = geo::Angle::degrees(geo::uniform(random, -90, 90)),
                                            .lon = geo::Angle::degrees(geo::uniform(random, -180, 180)),
                                            .height_m = std::exp(geo::uniform(random, 1, 16))},
                               .heading = geo::Angle::degrees(geo::uniform(random, 0, 360)),
                               .pitch = geo::Angle::degrees(geo::uniform(random, -90, 0)),
                               .roll = {}}});
  }
  const CameraPath path = CameraPath::create(keys).value();
  const auto velocity = [&](double at, double step) {
    const geo::Direction a = placeOf(path.at(Seconds(at)));
    return (placeOf(path.at(Seconds(at + step))).n - a.n) / step;
  };
  for (std::size_t i = 1; i + 1 < keys.size(); ++i) {
    EXPECT_LT(geo::length(velocity(keys[i].seconds, 1e-5) - velocity(keys[i].seconds, -1e-5)), 1e-3) << i;
  }
  for (double t = keys.front().seconds; t < keys.back().seconds; t += 0.01) {
    const Camera c = path.at(Seconds(t));
    const auto next = std::find_if(keys.begin(), keys.end(), [&](const auto& k) { return k.seconds > t; });
    const double high = std::max(next->camera.position.height_m, (next - 1)->camera.position.height_m);
    const double low = std::min(next->camera.position.height_m, (next - 1)->camera.position.height_m);
    ASSERT_LE(c.position.height_m, high * (1 + 1e-9));
    ASSERT_GE(c.position.height_m, low * (1 - 1e-9));
    ASSERT_TRUE(std::isfinite(c.heading.radians()));
  }
}

TEST(CameraPath, failuresNameTheLine) {
  const auto where = [](std::string_view text) {
    const auto path = parseCameraPath(text, "f.csv");
    return path ? std::string("no failure") : path.error().where;
  };
  EXPECT_EQ(where("0,1,2,3,4,5,6\n1,1,2,x,4,5,6"), "f.csv:2");
  EXPECT_EQ(where("0,1,2,3,4,5,6\n\n0,1,2,3,4,5,6"), "f.csv:3");
  EXPECT_EQ(where("seconds,lat,lon,height_m,heading,pitch,roll\nzero,1,2,3"), "f.csv:2");
  EXPECT_EQ(where("0"), "f.csv:1");
  EXPECT_EQ(where("# nothing\n"), "f.csv");
  EXPECT_FALSE(readCameraPath("/no/such/file.csv"));
  EXPECT_FALSE(CameraPath::create({}));
}

TEST(CameraPath, flightOfTheDemoIsRead) {
  const auto path = readCameraPath(TELLURION_SOURCE_DIR "/data/everest_flight.csv");
  ASSERT_TRUE(path) << io::describe(path.error());
  EXPECT_GT(path->duration().count(), 1.0);
}

}  // namespace
}  // namespace tellurion::scene
