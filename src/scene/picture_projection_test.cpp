#include "scene/picture_projection.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geo/seed_test.h"
#include "scene/picking.h"
#include "scene/projector_channels.h"
#include "scene/view_from_test.h"
#include "scene/view_frustum.h"

namespace tellurion::scene {
namespace {

geo::Vec3 bodyDirection(const View& view, const geo::Vec3& direction_view) {
  return glm::transpose(view.viewFromBody) * direction_view;
}

TEST(PictureProjection, aPartOfAViewSeesTheSame) {
  std::mt19937_64 random = geo::seededGenerator();
  for (int i = 0; i < 200; ++i) {
    View whole = viewFrom(27, 86, 9000, geo::uniform(random, 0, 360), -20, {.width = 1000, .height = 700});
    if (i % 2 == 0) whole.offAxis = Sides{.left = -0.2, .right = 1.3, .bottom = -2.0, .top = 0.1};
    const PixelRect rect{static_cast<int>(geo::uniform(random, 0, 900)), static_cast<int>(geo::uniform(random, 0, 600)),
                         1 + static_cast<int>(geo::uniform(random, 0, 99)),
                         1 + static_cast<int>(geo::uniform(random, 0, 99))};
    const View part = partOf(whole, rect);
    EXPECT_DOUBLE_EQ(part.pixelAngle(), whole.pixelAngle());
    const PixelPosition inPart{geo::uniform(random, 0, rect.width), geo::uniform(random, 0, rect.height)};
    const geo::Vec3 a = rayThrough(part, inPart).direction;
    const geo::Vec3 b = rayThrough(whole, {rect.left + inPart.x, rect.top + inPart.y}).direction;
    EXPECT_LT(geo::length(a - b), 1e-13);
    const auto back = pixelOf(part, part.eye + a * 1000.0);
    ASSERT_TRUE(back);
    EXPECT_NEAR(back->x, inPart.x, 1e-5);
    EXPECT_NEAR(back->y, inPart.y, 1e-5);
  }
}

TEST(PictureProjection, theFrustumIsThePicture) {
  std::mt19937_64 random = geo::seededGenerator();
  View view = viewFrom(10, 20, 5000, 40, -10, {.width = 800, .height = 300});
  view.offAxis = Sides{.left = -0.1, .right = 1.5, .bottom = 0.2, .top = 0.9};
  const ViewFrustum frustum(view);
  View around = view;
  around.isAllAround = true;
  for (int i = 0; i < 5000; ++i) {
    const geo::Vec3 away(geo::uniform(random, -1, 1), geo::uniform(random, -1, 1), geo::uniform(random, -1, 1));
    const geo::BodyPosition point = view.eye + away * 1000.0;
    const auto pixel = pixelOf(view, point);
    const bool isInside = pixel && pixel->x > 0 && pixel->x < 800 && pixel->y > 0 && pixel->y < 300;
    EXPECT_EQ(frustum.mayShow(point, 0.0), isInside);
    EXPECT_TRUE(ViewFrustum(around).mayShow(point, 0.0));
  }
}

/// Right, left, up, down, back, front: rotations, whose axes are these.
TEST(PictureProjection, theFacesOfTheCubeLookAllAround) {
  const std::array<geo::Vec3, 6> kAxes{geo::Vec3(1, 0, 0),  geo::Vec3(-1, 0, 0), geo::Vec3(0, 1, 0),
                                       geo::Vec3(0, -1, 0), geo::Vec3(0, 0, 1),  geo::Vec3(0, 0, -1)};
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_LT(geo::length(kCubeFaces[i] * kAxes[i] - geo::Vec3(0, 0, -1)), 1e-15);
    EXPECT_NEAR(glm::determinant(kCubeFaces[i]), 1.0, 1e-15);
  }
}

/// A cross lies so that its squares meet where they touch: the same direction on both sides of an edge.
TEST(PictureProjection, theSquaresOfTheCrossMeet) {
  const PictureShape shape{.projection = Projection::cube, .size = {.width = 400, .height = 300}};
  const auto eyes = eyesOf(shape, viewFrom(27, 86, 9000, 20, 0), 0.0);
  ASSERT_EQ(eyes.size(), 1u);
  ASSERT_EQ(eyes[0].panes.size(), 6u);
  int touching = 0;
  for (const Pane& a : eyes[0].panes) {
    for (const Pane& b : eyes[0].panes) {
      const bool isRight = a.place.top == b.place.top && a.place.left + 100 == b.place.left;
      const bool isBelow = a.place.left == b.place.left && a.place.top + 100 == b.place.top;
      if (!isRight && !isBelow) continue;
      ++touching;
      const PixelPosition inA = isRight ? PixelPosition{100, 37} : PixelPosition{37, 100};
      const PixelPosition inB = isRight ? PixelPosition{0, 37} : PixelPosition{37, 0};
      EXPECT_LT(geo::length(rayThrough(a.view, inA).direction - rayThrough(b.view, inB).direction), 1e-14);
    }
  }
  EXPECT_EQ(touching, 5);
}

/// Held over the head, the bottom of a dome master is in front; its middle leans there by the tilt.
TEST(PictureProjection, aDomeStandsAboveTheCamera) {
  const View camera = viewFrom(27, 86, 9000, 20, 0);
  for (const double tilt : {0.0, 30.0, 90.0, -20.0}) {
    const PictureShape shape{
        .projection = Projection::fisheye, .size = {.width = 512, .height = 512}, .tilt = geo::Angle::degrees(tilt)};
    const EyePicture eye = eyesOf(shape, camera, 0.0).at(0);
    const double lean = geo::Angle::degrees(tilt).radians();
    const geo::Vec3 middle = glm::transpose(eye.warpFromView) * geo::Vec3(0, 0, -1);
    const geo::Vec3 lower = glm::transpose(eye.warpFromView) * geo::Vec3(0, -1, 0);
    const geo::Vec3 right = glm::transpose(eye.warpFromView) * geo::Vec3(1, 0, 0);
    EXPECT_LT(geo::length(middle - geo::Vec3(0, std::cos(lean), -std::sin(lean))), 1e-15);
    EXPECT_LT(geo::length(lower - geo::Vec3(0, -std::sin(lean), -std::cos(lean))), 1e-15);
    EXPECT_LT(geo::length(right - geo::Vec3(1, 0, 0)), 1e-15);
    EXPECT_TRUE(eye.cut.isAllAround);
    EXPECT_NEAR(eye.cut.pixelAngle(), std::acos(-1.0) / 512, 1e-15);
  }
}

TEST(PictureProjection, bothEyesMeetAtThirtySeparations) {
  const View camera = viewFrom(27, 86, 9000, 20, -15);
  const PictureShape shape{.projection = Projection::stereo, .size = {.width = 800, .height = 300}};
  EXPECT_DOUBLE_EQ(eyeSeparation_m(600.0), 20.0);
  EXPECT_DOUBLE_EQ(eyeSeparation_m(0.1), 0.065);
  const auto eyes = eyesOf(shape, camera, 600.0);
  ASSERT_EQ(eyes.size(), 2u);
  const View& left = eyes[0].panes.at(0).view;
  const View& right = eyes[1].panes.at(0).view;
  EXPECT_NEAR(geo::length(right.eye - left.eye), 20.0, 1e-8);
  EXPECT_GT(geo::dot(right.eye - left.eye, bodyDirection(camera, {1, 0, 0})), 0.0);
  EXPECT_EQ(left.viewFromBody, right.viewFromBody);
  EXPECT_EQ(eyes[0].panes[0].place, (PixelRect{0, 0, 400, 300}));
  EXPECT_EQ(eyes[1].panes[0].place, (PixelRect{400, 0, 400, 300}));
  for (const double distance_m : {100.0, 600.0, 1e6}) {
    const geo::BodyPosition point = camera.eye + bodyDirection(camera, geo::Vec3(0.2, 0.1, -1.0)) * distance_m;
    const double apart_px = pixelOf(left, point)->x - pixelOf(right, point)->x;
    const double expected = 20.0 * (1.0 / distance_m - 1.0 / 600.0) / camera.pixelAngle() * 300.0 / 768.0;
    EXPECT_NEAR(apart_px, expected, 1e-4) << distance_m;
  }
}

TEST(PictureProjection, wrongSizesAreTold) {
  const auto problem = [](Projection projection, int width, int height) {
    return sizeProblem({.projection = projection, .size = {.width = width, .height = height}});
  };
  EXPECT_EQ(problem(Projection::equirectangular, 200, 100), "");
  EXPECT_NE(problem(Projection::equirectangular, 200, 101).find("202x101"), std::string::npos);
  EXPECT_EQ(problem(Projection::cube, 400, 300), "");
  EXPECT_NE(problem(Projection::cube, 402, 300).find("400x300"), std::string::npos);
  EXPECT_NE(problem(Projection::stereo, 401, 300), "");
  EXPECT_EQ(problem(Projection::fisheye, 401, 300), "");
}

constexpr std::string_view kTwo = R"([[channel]]
name = "left"
left_degrees = -40
right_degrees = 20
bottom_degrees = -15
top_degrees = 25
heading = -30
[[channel]]
name = "right"
left_degrees = -20
right_degrees = 35
bottom_degrees = -15
top_degrees = 25
heading = 10
)";

/// Where one picture ends the other begins, to the last bit nearly, and both are chosen for the same pixel.
TEST(ProjectorChannels, joinWithoutAStep) {
  const auto channels = parseChannels(kTwo, "two.toml");
  ASSERT_TRUE(channels) << io::describe(channels.error());
  const View camera = viewFrom(27, 86, 9000, 20, 0);
  const EyePicture a = pictureOf((*channels)[0], *channels, camera, {.width = 300, .height = 200});
  const EyePicture b = pictureOf((*channels)[1], *channels, camera, {.width = 300, .height = 200});
  const geo::Vec3 endOfA = rayThrough(a.panes[0].view, {300, 0}).direction;
  const geo::Vec3 level =
      bodyDirection(camera, {std::sin(-10 * std::acos(-1.0) / 180), 0, -std::cos(10 * std::acos(-1.0) / 180)});
  const geo::Vec3 up = bodyDirection(camera, {0, 1, 0});
  EXPECT_LT(std::abs(geo::dot(geo::cross(endOfA, up), level)), 1e-14) << "the side lies 10 degrees to the left";
  const geo::Vec3 startOfB = rayThrough(b.panes[0].view, {0, 77}).direction;
  EXPECT_LT(std::abs(geo::dot(geo::cross(startOfB, up), level)), 1e-14);
  EXPECT_EQ(a.cut.pixelAngle(), b.cut.pixelAngle());
  EXPECT_EQ(a.panes[0].view.pixelAngle(), b.panes[0].view.pixelAngle());
  EXPECT_EQ(a.cut.viewFromBody, b.cut.viewFromBody);
}

TEST(ProjectorChannels, saysWhatIsWrong) {
  const auto message = [](std::string_view text) {
    const auto parsed = parseChannels(text, "bad.toml");
    return parsed ? std::string() : io::describe(parsed.error());
  };
  const std::string good(kTwo);
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    return message(text.replace(text.find(from), from.size(), to));
  };
  EXPECT_NE(message("").find("no [[channel]]"), std::string::npos);
  EXPECT_NE(message("[[channel").find("bad.toml:1"), std::string::npos);
  EXPECT_NE(changed("left_degrees = -40", "left_degrees = 30").find("less than right_degrees"), std::string::npos);
  EXPECT_NE(changed("left_degrees = -40", "").find("left_degrees"), std::string::npos);
  EXPECT_NE(changed("left_degrees = -40", "left_degrees = -90").find("-89"), std::string::npos);
  EXPECT_NE(changed("left_degrees = -40", "left_degrees = nan").find("left_degrees"), std::string::npos);
  EXPECT_NE(changed("name = \"right\"", "name = \"left\"").find("two channels"), std::string::npos);
  EXPECT_NE(changed("heading = 10", "headin = 10").find("headin"), std::string::npos);
}

}  // namespace
}  // namespace tellurion::scene
