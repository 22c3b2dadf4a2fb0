#include "scene/view_motion.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>

#include "geo/body.h"
#include "geo/seed_test.h"
#include "scene/globe.h"
#include "scene/remote_source_test.h"
#include "scene/view_from_test.h"

namespace tellurion::scene {
namespace {

using namespace std::chrono_literals;
using tiling::Scheme;

constexpr Viewport kViewport{.width = 640, .height = 480};

/// A camera that moves evenly.
struct Course {
  double lat = 0.0;
  double height_m = 0.0;
  double heading = 0.0;
  double north_s = 0.0;    ///< degrees a second
  double climb_s = 1.0;    ///< factor a second
  double turning_s = 0.0;  ///< degrees a second

  View at(double time_s) const {
    return viewFrom(lat + north_s * time_s, 8.0, height_m * std::pow(climb_s, time_s), heading + turning_s * time_s,
                    -40, kViewport);
  }
};

geo::Vec3 rowOf(const geo::Mat3& m, int row) {
  return {m[0][row], m[1][row], m[2][row]};
}

std::optional<View> foretold(const Course& course, double until_s) {
  ViewMotion motion(geo::earth().ellipsoid);
  for (double time_s = 0.0; time_s < until_s; time_s += 1.0 / 60)
    motion.add(course.at(time_s), time_s);
  motion.add(course.at(until_s), until_s);
  return motion.ahead(1.0);
}

TEST(ViewMotion, foretellsWhereAnEvenCourseLeads) {
  auto random = geo::seededGenerator();
  for (int run = 0; run < 200; ++run) {
    const double height_m = std::exp(geo::uniform(random, std::log(100.0), std::log(1e6)));
    Course course{.lat = geo::uniform(random, -60, 60), .height_m = height_m, .heading = 0.0};
    course.north_s = geo::uniform(random, -1, 1) * height_m / 111e3;
    course.climb_s = geo::uniform(random, 0.5, 2.0);
    course.turning_s = geo::uniform(random, -20, 20);
    const auto view = foretold(course, 0.7);
    const View there = course.at(1.7);
    ASSERT_TRUE(view);
    EXPECT_LT(geo::length(view->eye - there.eye), 0.05 * height_m);
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_LT(geo::length(rowOf(view->viewFromBody, axis) - rowOf(there.viewFromBody, axis)), 0.05);
  }
}

TEST(ViewMotion, tellsNothingOfAnEyeThatRestsOrLeaps) {
  EXPECT_FALSE(foretold({.lat = 46.0, .height_m = 1e4}, 0.7));
  ViewMotion motion(geo::earth().ellipsoid);
  EXPECT_FALSE(motion.ahead(1.0));
  const Course course{.lat = 46.0, .height_m = 1e4, .north_s = 0.1};
  motion.add(course.at(0.0), 0.0);
  motion.add(course.at(0.05), 0.05);
  EXPECT_TRUE(motion.ahead(1.0));
  motion.add(course.at(20.0), 0.1);  // 200 km on, within a frame
  EXPECT_FALSE(motion.ahead(1.0));
  motion.add(course.at(20.05), 0.15);
  EXPECT_TRUE(motion.ahead(1.0));
  motion.add(course.at(20.1), 5.0);  // after a pause
  EXPECT_FALSE(motion.ahead(1.0));
  motion.add(course.at(20.1), 4.0);  // the clock was set back
  EXPECT_FALSE(motion.ahead(1.0));
}

/// An eye that rested flies on, over a slow line: what its pictures still want, summed over the frames.
int wantedInFlight(bool prefetch) {
  constexpr double kFrame_s = 1.0 / 20;
  const auto server = std::make_shared<FakeServer>();
  const auto ground = std::make_shared<RemoteSource>(
      std::make_shared<ProceduralSource>(raster::Kind::elevation, Scheme::cube, 9), server);
  const auto globe = Globe::fromLayers({}, {.elevation = {ground}, .imagery = {}, .resources = {}},
                                       {.workers = 1, .cpuCacheBytes = std::uint64_t{4} << 30})
                         .value();
  const Course course{.lat = 44.0, .height_m = 20e3, .heading = 0.0, .north_s = 0.2};
  double time_s = 0.0;
  const auto frame = [&](const View& view, int answers) -> int {
    // All that workers can make of what the server has answered.
    const CutOptions options{.time_s = time_s, .prefetch = prefetch};
    globe->update(view, options);
    for (int i = 0; i < 2000 && server->holding() > 0; ++i) {
      globe->waitForArrivals(2ms);
      globe->update(view, options);
    }
    server->serve(answers);
    const int wanted = globe->update(view, options).statistics.tilesWanted;
    time_s += kFrame_s;
    return wanted;
  };
  for (int i = 0; i < 200 && (i < 20 || frame(course.at(0.0), 1000) > 0); ++i)
    frame(course.at(0.0), 1000);
  const double start_s = time_s;
  int sum = 0;
  while (time_s < start_s + 8.0)
    sum += frame(course.at(time_s - start_s), 2);
  return sum;
}

TEST(ViewMotion, whatIsAskedForAheadIsMissedLess) {
  const int without = wantedInFlight(false);
  const int with = wantedInFlight(true);
  std::printf("wanted, summed over the frames: %d, without looking ahead %d\n", with, without);
  EXPECT_LT(with, 0.7 * without);
}

}  // namespace
}  // namespace tellurion::scene
