// Bent pictures against directions and rays in double precision: an eye inside a smooth body, off its middle, sees
// ground in all directions, at a distance and in a light that change slowly with the direction.

#include "render/picture_maker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geo/seed_test.h"
#include "render/synthetic_tiles_test.h"

namespace tellurion::render {
namespace {

constexpr double kRadius_m = 1e6;

class PictureMakerTest : public synthetic::GlTest {
 protected:
  void SetUp() override {
    synthetic::GlTest::SetUp();
    if (IsSkipped()) return;
    frame_.tiles = synthetic::wholeBody(tiling_, sphere_, 2, 16);
    frame_.light.toSun_body = geo::normalize(geo::Vec3(1.0, 2.0, 3.0));
    frame_.light.ambient = 0.3;
    renderer_.emplace(makeRenderer());
    auto maker = PictureMaker::create();
    ASSERT_TRUE(maker) << io::describe(maker.error());
    maker_.emplace(std::move(*maker));
  }

  scene::View camera(std::mt19937_64& random) const {
    scene::View view =
        synthetic::viewAt(sphere_, geo::uniform(random, -90, 90), geo::uniform(random, -180, 180), -0.5 * kRadius_m,
                          geo::uniform(random, 0, 360), geo::uniform(random, -80, 80), {.width = 64, .height = 64});
    return view;
  }

  PicturePiece whole(const scene::EyePicture& eye, scene::Viewport size, int side) {
    PicturePiece piece = blankPiece({0, 0, size.width, size.height}, true);
    for (const scene::PixelRect& part : piecesOf(size, side)) {
      const auto drawn = maker_->draw(*renderer_, frame_, eye, part, piece);
      EXPECT_TRUE(drawn) << (drawn ? "" : io::describe(drawn.error()));
    }
    return piece;
  }

  double distance_m(const scene::View& eye, const geo::Vec3& direction_view) const {
    const geo::Ray ray{eye.eye, geo::normalize(glm::transpose(eye.viewFromBody) * direction_view)};
    const double b = geo::dot(ray.origin.m, ray.direction);
    return -b + std::sqrt(b * b - geo::dot(ray.origin.m, ray.origin.m) + kRadius_m * kRadius_m);
  }

  /// What a perspective picture shows in its middle that looks there.
  raster::Rgba8 colourAlong(const scene::View& eye, const geo::Vec3& direction_view) {
    const geo::Vec3 aside = std::abs(direction_view.y) < 0.8 ? geo::Vec3(0, 1, 0) : geo::Vec3(1, 0, 0);
    const geo::Vec3 right = geo::normalize(geo::cross(direction_view, aside));
    scene::View view = eye;
    view.isAllAround = false;
    view.agreedPixelAngle.reset();
    view.viewFromBody =
        glm::transpose(geo::Mat3(right, geo::cross(right, direction_view), -direction_view)) * eye.viewFromBody;
    view.verticalFov = geo::Angle::degrees(1.0);
    view.viewport = {.width = 1, .height = 1};
    const RenderTarget target = makeTarget(view.viewport);
    scene::Frame frame = scene::partOf(frame_, view);
    renderer_->draw(frame, target);
    return readColour(target).at(0, 0);
  }

  tiling::Tiling tiling_{tiling::Scheme::cube};
  geo::Ellipsoid sphere_{kRadius_m, 0.0};
  scene::Frame frame_;
  std::optional<Renderer> renderer_;
  std::optional<PictureMaker> maker_;
};

int apart(raster::Rgba8 a, raster::Rgba8 b) {
  return std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
}

/// The textbook's fisheye: the angle from the middle is proportional to the distance from it.
std::optional<geo::Vec3> fisheyeDirection(double x, double y, double side, double aperture) {
  const double dx = (x - side / 2) / (side / 2);
  const double dy = (side / 2 - y) / (side / 2);
  const double r = std::hypot(dx, dy);
  if (r > 1.0) return std::nullopt;
  const double angle = r * aperture / 2;
  return geo::Vec3(std::sin(angle) * dx / r, std::sin(angle) * dy / r, -std::cos(angle));
}

TEST_F(PictureMakerTest, aFisheyeShowsAnglesFromItsMiddle) {
  constexpr int kSide = 150;
  std::mt19937_64 random = geo::seededGenerator();
  for (const double aperture : {60.0, 180.0, 230.0, 360.0}) {
    const scene::PictureShape shape{.projection = scene::Projection::fisheye,
                                    .size = {.width = kSide, .height = kSide},
                                    .aperture = geo::Angle::degrees(aperture),
                                    .tilt = geo::Angle::degrees(geo::uniform(random, -90, 90))};
    const scene::EyePicture eye = scene::eyesOf(shape, camera(random), 0.0).at(0);
    const PicturePiece picture = whole(eye, shape.size, 64);
    for (int row = 0; row < kSide; ++row) {
      for (int col = 0; col < kSide; ++col) {
        const auto inWarp = fisheyeDirection(col + 0.5, row + 0.5, kSide, aperture * std::numbers::pi / 180);
        const float shown_m = picture.distances_m.at(col, row);
        if (!inWarp) {
          EXPECT_EQ(apart(picture.colours.at(col, row), {0, 0, 0, 255}), 0);
          EXPECT_TRUE(std::isnan(shown_m));
          continue;
        }
        const geo::Vec3 direction = glm::transpose(eye.warpFromView) * *inWarp;
        const double expected_m = distance_m(eye.cut, direction);
        EXPECT_NEAR(static_cast<double>(shown_m), expected_m, (0.004 + 1.0 * eye.cut.pixelAngle()) * expected_m)
            << aperture << ": " << col << ", " << row;
        if ((row * kSide + col) % 97 == 0) {
          EXPECT_LE(apart(picture.colours.at(col, row), colourAlong(eye.cut, direction)), 3)
              << aperture << ": " << col << ", " << row;
        }
      }
    }
  }
}

TEST_F(PictureMakerTest, anEquirectangularPictureShowsLongitudeAndLatitude) {
  constexpr int kHeight = 80;
  std::mt19937_64 random = geo::seededGenerator();
  const scene::PictureShape shape{.projection = scene::Projection::equirectangular,
                                  .size = {.width = 2 * kHeight, .height = kHeight}};
  const scene::EyePicture eye = scene::eyesOf(shape, camera(random), 0.0).at(0);
  const PicturePiece picture = whole(eye, shape.size, 64);
  for (int row = 0; row < kHeight; ++row) {
    for (int col = 0; col < 2 * kHeight; ++col) {
      const double longitude = ((col + 0.5) / kHeight - 1.0) * std::numbers::pi;
      const double latitude = (0.5 - (row + 0.5) / kHeight) * std::numbers::pi;
      const geo::Vec3 direction(std::sin(longitude) * std::cos(latitude), std::sin(latitude),
                                -std::cos(longitude) * std::cos(latitude));
      const double expected_m = distance_m(eye.cut, direction);
      EXPECT_NEAR(static_cast<double>(picture.distances_m.at(col, row)), expected_m,
                  (0.004 + 1.0 * eye.cut.pixelAngle()) * expected_m)
          << col << ", " << row;
      if ((row * kHeight + col) % 53 == 0) {
        EXPECT_LE(apart(picture.colours.at(col, row), colourAlong(eye.cut, direction)), 3) << col << ", " << row;
      }
    }
  }
}

/// Whatever it is drawn in, a picture is the same within what rounding of corners to a 256th of a pixel moves.
TEST_F(PictureMakerTest, piecesJoin) {
  constexpr scene::Viewport kSize{.width = 240, .height = 120};
  std::mt19937_64 random = geo::seededGenerator();
  const scene::View from = camera(random);
  for (const auto projection : {scene::Projection::perspective, scene::Projection::fisheye,
                                scene::Projection::equirectangular, scene::Projection::stereo}) {
    const scene::PictureShape shape{.projection = projection, .size = kSize};
    for (const scene::EyePicture& eye : scene::eyesOf(shape, from, 0.0)) {
      const PicturePiece one = whole(eye, kSize, 1024);
      const PicturePiece many = whole(eye, kSize, 37);
      int worst = 0;
      for (std::size_t i = 0; i < one.colours.samples.size(); ++i)
        worst = std::max(worst, apart(one.colours.samples[i], many.colours.samples[i]));
      EXPECT_LE(worst, 2);
    }
  }
}

TEST(PiecesOfAPicture, coverItOnceRowByRow) {
  for (const auto& [width, height, side] :
       {std::array{1000, 700, 300}, std::array{32768, 1200, 4096}, std::array{1, 1, 16}}) {
    std::int64_t pixels = 0;
    int bottom = 0;
    int right = 0;
    for (const scene::PixelRect& piece : piecesOf({.width = width, .height = height}, side)) {
      if (piece.left == 0) {
        EXPECT_EQ(piece.top, bottom);
        bottom = piece.top + piece.height;
        right = 0;
      }
      EXPECT_EQ(piece.left, right);
      right += piece.width;
      EXPECT_LE(std::max(piece.width, piece.height), side);
      EXPECT_LE(std::int64_t{4} * width * piece.height, std::int64_t{64} << 20);
      pixels += std::int64_t{piece.width} * piece.height;
    }
    EXPECT_EQ(pixels, std::int64_t{width} * height);
    EXPECT_EQ(bottom, height);
  }
}

}  // namespace
}  // namespace tellurion::render
