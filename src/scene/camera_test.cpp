#include "scene/camera.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geo/body.h"
#include "geo/local_frame.h"
#include "geo/seed_test.h"

namespace tellurion::scene {
namespace {

const geo::Ellipsoid kEarth = geo::earth().ellipsoid;
constexpr Viewport kScreen{.width = 800, .height = 600};

Camera cameraAt(double lat, double lon, double height_m, double heading, double pitch, double roll) {
  return {.position = {.lat = geo::Angle::degrees(lat), .lon = geo::Angle::degrees(lon), .height_m = height_m},
          .heading = geo::Angle::degrees(heading),
          .pitch = geo::Angle::degrees(pitch),
          .roll = geo::Angle::degrees(roll)};
}

View view(const Camera& c) {
  return viewOf(c, kEarth, geo::Angle::degrees(60.0), kScreen);
}

void expectSame(const geo::Vec3& a, const geo::Vec3& b, double tolerance) {
  EXPECT_LT(geo::length(a - b), tolerance) << a.x << " " << a.y << " " << a.z;
}

double largestDifference(const geo::Mat3& a, const geo::Mat3& b) {
  double worst = 0.0;
  for (int i = 0; i < 3; ++i)
    worst = std::max(worst, geo::length(a[i] - b[i]));
  return worst;
}

TEST(ParseCamera, readsAllSixOrThreeAndMore) {
  const Camera c = parseCamera("27.5,-86,9000,10,-20,3").value();
  EXPECT_DOUBLE_EQ(c.position.lat.degrees(), 27.5);
  EXPECT_DOUBLE_EQ(c.position.lon.degrees(), -86.0);
  EXPECT_DOUBLE_EQ(c.position.height_m, 9000.0);
  EXPECT_DOUBLE_EQ(c.heading.degrees(), 10.0);
  EXPECT_DOUBLE_EQ(c.pitch.degrees(), -20.0);
  EXPECT_DOUBLE_EQ(c.roll.degrees(), 3.0);
  EXPECT_DOUBLE_EQ(parseCamera(" +1 , 2,3e6").value().pitch.degrees(), -90.0);
}

TEST(ParseCamera, saysWhatIsWrong) {
  const auto message = [](const char* text) { return parseCamera(text).error().message; };
  EXPECT_NE(message("1,2").find("HEIGHT"), std::string::npos);
  EXPECT_NE(message("91,2,3").find("latitude"), std::string::npos);
  EXPECT_NE(message("1,2,3,4,91").find("pitch"), std::string::npos);
  EXPECT_NE(message("1,east,3").find("longitude"), std::string::npos);
  EXPECT_NE(message("1,2,nan").find("height"), std::string::npos);
  EXPECT_NE(message("1,2,inf").find("height"), std::string::npos);
  EXPECT_NE(message("1,2,3,4,5,6,7").find("ROLL"), std::string::npos);
  EXPECT_FALSE(parseCamera(""));
  EXPECT_FALSE(parseCamera("1,2,3,"));
}

TEST(ViewOf, axesOfHandCheckedCases) {
  // Over latitude 0, longitude 0: east is +y, north +z, up +x.
  const auto axes = [](const Camera& c) { return glm::transpose(view(c).viewFromBody); };
  geo::Mat3 m = axes(cameraAt(0, 0, 1000, 0, -90, 0));  // straight down, north up
  expectSame(m[0], {0, 1, 0}, 1e-15);
  expectSame(m[1], {0, 0, 1}, 1e-15);
  expectSame(m[2], {1, 0, 0}, 1e-15);        // backwards is up
  m = axes(cameraAt(0, 0, 1000, 90, 0, 0));  // east, level
  expectSame(m[0], {0, 0, -1}, 1e-15);
  expectSame(m[1], {1, 0, 0}, 1e-15);
  expectSame(m[2], {0, -1, 0}, 1e-15);
  m = axes(cameraAt(0, 0, 1000, 0, 0, 90));  // north, rolled to the right: the picture's upper edge points east
  expectSame(m[1], {0, 1, 0}, 1e-15);
  expectSame(m[0], {-1, 0, 0}, 1e-15);
  EXPECT_DOUBLE_EQ(view(cameraAt(0, 0, 1000, 0, 0, 0)).pixelAngle(), 2.0 * std::tan(geo::kPi / 6.0) / 600.0);
  expectSame(view(cameraAt(0, 0, 1000, 0, 0, 0)).eye.m, {6379137.0, 0, 0}, 1e-9);
}

TEST(CameraOf, isTheInverseAwayFromTheVertical) {
  std::mt19937_64 random = geo::seededGenerator();
  for (int i = 0; i < 2000; ++i) {
    const Camera c =
        cameraAt(geo::uniform(random, -89.9, 89.9), geo::uniform(random, -180, 180), geo::uniform(random, -1e4, 1e7),
                 geo::uniform(random, -180, 180), geo::uniform(random, -89, 89), geo::uniform(random, -180, 180));
    const Camera back = cameraOf(view(c), kEarth);
    EXPECT_NEAR(back.position.lat.degrees(), c.position.lat.degrees(), 1e-12);
    EXPECT_NEAR(std::remainder(back.position.lon.degrees() - c.position.lon.degrees(), 360.0), 0.0, 1e-10);
    EXPECT_NEAR(back.position.height_m, c.position.height_m, 1e-7);
    EXPECT_NEAR(std::remainder(back.heading.degrees() - c.heading.degrees(), 360.0), 0.0, 1e-9);
    EXPECT_NEAR(back.pitch.degrees(), c.pitch.degrees(), 1e-9);
    EXPECT_NEAR(std::remainder(back.roll.degrees() - c.roll.degrees(), 360.0), 0.0, 1e-9);
  }
}

TEST(CameraOf, givesTheSameViewAtThePolesAndOnTheVertical) {
  std::mt19937_64 random = geo::seededGenerator();
  for (const double lat : {-90.0, -89.9999999, 0.0, 45.0, 90.0}) {
    for (const double pitch : {-90.0, -89.9999999999, -89.99999, -30.0, 0.0, 89.99999, 90.0}) {
      for (int i = 0; i < 20; ++i) {
        const View v = view(cameraAt(lat, geo::uniform(random, -180, 180), 1e4, geo::uniform(random, 0, 360), pitch,
                                     geo::uniform(random, -180, 180)));
        const View again = view(cameraOf(v, kEarth));
        EXPECT_LT(largestDifference(v.viewFromBody, again.viewFromBody), 1e-13) << lat << " " << pitch;
        EXPECT_LT(geo::length(v.eye - again.eye), 1e-8);
      }
    }
  }
}

TEST(CameraOf, straightDownHeadingIsThePicturesUpperEdge) {
  const Camera c = cameraOf(view(cameraAt(10, 20, 1e6, 33, -90, 0)), kEarth);
  EXPECT_NEAR(c.heading.degrees(), 33.0, 1e-10);
  EXPECT_NEAR(c.roll.degrees(), 0.0, 1e-10);
  EXPECT_NEAR(c.pitch.degrees(), -90.0, 1e-10);
}

}  // namespace
}  // namespace tellurion::scene
