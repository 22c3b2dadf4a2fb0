#include "truth/pixel_miss.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>

#include "truth/seen_surface.h"

namespace tellurion::truth {
namespace {

constexpr scene::Viewport kSize{.width = 128, .height = 96};

// A ball of 1 km from 3 km off: its outline is 41 pixels from the middle of the picture.
class Ball : public testing::Test {
 protected:
  static std::optional<double> distance_m(double x_px, double raised_m = 0.0) {
    return kBall.intersect(scene::rayThrough(view(), {kSize.width / 2.0 + x_px, kSize.height / 2.0}), raised_m);
  }
  static double miss_px(double x_px, std::optional<double> drawn_m, double enough_px = 0.0) {
    const auto ball = [](const geo::Ray& ray) { return exactly(kBall.intersect(ray).value_or(kSky)); };
    return missOf(ball, view(), {kSize.width / 2.0 + x_px, kSize.height / 2.0}, drawn_m.value_or(kSky),
                  exactly(distance_m(x_px).value_or(kSky)), 4.0, enough_px);
  }
  static scene::View view() {
    const scene::Camera camera{.position = {.height_m = 2000.0}, .pitch = geo::Angle::degrees(-90)};
    return scene::viewOf(camera, kBall, geo::Angle::degrees(45), kSize);
  }
  static double outline_px() { return std::tan(std::asin(1.0 / 3.0)) / view().pixelAngle(); }

  static constexpr double kSky = std::numeric_limits<double>::quiet_NaN();
  static constexpr geo::Ellipsoid kBall{1000.0, 0.0};
};

TEST_F(Ball, IsOffByTheWidthOfPixelsAlongTheRay) {
  const double width_m = 2000.0 * view().pixelAngle();
  for (const double px : {-3.5, -0.2, 0.0, 0.3, 1.7, 3.9}) {
    // Both the ball's surface and the picture face the eye there.
    EXPECT_NEAR(miss_px(0.0, *distance_m(0.0) + px * width_m), std::abs(px), 0.04 * std::abs(px)) << px;
  }
}

TEST_F(Ball, IsOffByTheWayToItsOutline) {
  EXPECT_EQ(miss_px(outline_px() + 1.0, std::nullopt), 0.0);
  for (const double px : {0.4, 1.1, 2.9})  // rings are a quarter of a pixel apart
    EXPECT_NEAR(miss_px(outline_px() - px, std::nullopt), px, 0.25) << px;
  EXPECT_GT(miss_px(outline_px() - 4.5, std::nullopt), 4.0);
  // What is drawn beyond the outline has no surface on its ray, and the nearest beside it.
  EXPECT_NEAR(miss_px(outline_px() + 2.1, distance_m(outline_px() - 0.1)), 2.25, 0.25);
  EXPECT_GT(miss_px(outline_px() + 4.5, distance_m(outline_px() - 0.1)), 4.0);
}

TEST_F(Ball, IsMetAnywhereBetweenNeighbouringRays) {
  // Grazing, half a pixel aside is far along the ray.
  const double x = outline_px() - 2.0;
  const double halfAPixelOn = *distance_m(x + 0.5);
  EXPECT_GT((halfAPixelOn - *distance_m(x)) / (halfAPixelOn * view().pixelAngle()), 1.0);
  EXPECT_NEAR(miss_px(x, halfAPixelOn), 0.5, 0.25);
}

TEST_F(Ball, MayBeAnywhereWithinAShellThatIsLeftOpen) {
  const double width_m = 2000.0 * view().pixelAngle();
  const double shell_m = 3.0 * width_m;
  const auto shell = [&](const geo::Ray& ray) {
    return Seen{.nearest_m = kBall.intersect(ray, shell_m).value_or(kSky),
                .farthest_m = kBall.intersect(ray).value_or(kSky)};
  };
  const scene::PixelPosition middle{kSize.width / 2.0, kSize.height / 2.0};
  const Seen centre = shell(scene::rayThrough(view(), middle));
  for (double off_px = -6.0; off_px < 3.0; off_px += 0.25) {  // from the ball's surface, away from the eye
    const double drawn_m = centre.farthest_m + off_px * width_m;
    const double off_m = std::max({0.0, drawn_m - centre.farthest_m, centre.nearest_m - drawn_m});
    const double expected_px = off_m / (drawn_m * view().pixelAngle());
    EXPECT_NEAR(missOf(shell, view(), middle, drawn_m, centre, 4.0), expected_px, 0.05 * expected_px) << off_px;
  }
}

TEST_F(Ball, IsNoBetterAndNoWorseForAskingLess) {
  const double width_m = 2000.0 * view().pixelAngle();
  for (double off_px = 0.0; off_px < 5.0; off_px += 0.17) {
    for (const double x_px : {0.0, 20.0, outline_px() - 1.0}) {
      const double drawn_m = *distance_m(x_px) + off_px * width_m;
      const double exact_px = miss_px(x_px, drawn_m);
      for (const double enough_px : {0.3, 1.0, 2.0}) {
        const double bound_px = miss_px(x_px, drawn_m, enough_px);
        EXPECT_GE(bound_px, exact_px) << off_px << ", " << x_px << ", " << enough_px;
        EXPECT_LE(bound_px, std::max(exact_px, enough_px)) << off_px << ", " << x_px << ", " << enough_px;
      }
    }
  }
}

TEST(Tally, ofNothingShowsNothing) {
  Tally tally(4.0);
  EXPECT_EQ(tally.share(), 0.0);
  tally.count(5.0, 7, 1, 2);
  EXPECT_EQ(tally.share(), 0.0);
  tally.count(3.0, 7, 3, 4);
  EXPECT_EQ(tally.share(), 0.5);
  EXPECT_EQ(tally.withinPixel, 0);
  EXPECT_EQ(tally.worst_px, 5.0);
  EXPECT_EQ(tally.col, 1);
}

}  // namespace
}  // namespace tellurion::truth
