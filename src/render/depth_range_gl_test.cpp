// One centimetre at 2 m and a mountain at 300 km in one picture: what is nearer hides what is farther, whichever is
// drawn first. Through the renderer's own projection and depth, which whoever draws things into its target shares.

#include <algorithm>
#include <cmath>
#include <optional>

#include "geo/body.h"
#include "geo/seed_test.h"
#include "render/synthetic_tiles_test.h"
#include "scene/picking.h"

namespace tellurion::render {
namespace {

using raster::Rgba8;

constexpr scene::Viewport kSize{160, 120};
constexpr double kFov_deg = 4.0;   ///< a pixel is 0.6 mm at 2 m, 90 m at 300 km
constexpr double kSure_px = 0.02;  ///< beside an edge by this, a pixel's centre is on the side where it seems to be
constexpr double kNear_m = 2.0;
constexpr double kFar_m = 300e3;
constexpr double kNearStep_m = 2e-6;  ///< ten steps of depth there
constexpr double kFarStep_m = 0.4;    ///< likewise

/// A rectangle in space: middle and half sides.
struct Panel {
  geo::BodyPosition middle;
  geo::Vec3 right;
  geo::Vec3 up;
  Rgba8 colour;

  /// Metres along the ray; nothing where it passes by. `grown` times as large.
  std::optional<double> along(const geo::Ray& ray, double grown) const {
    const geo::Vec3 normal = geo::cross(right, up);
    const double distance = geo::dot(middle - ray.origin, normal) / geo::dot(ray.direction, normal);
    const geo::Vec3 at = ray.origin + ray.direction * distance - middle;
    const double x = geo::dot(at, right) / geo::dot(right, right);
    const double y = geo::dot(at, up) / geo::dot(up, up);
    const bool hit = distance > 0.0 && std::max(std::abs(x), std::abs(y)) <= grown;
    return hit ? std::optional(distance) : std::nullopt;
  }
};

synthetic::PaintedTile tileOf(const Panel& panel) {
  auto mesh = std::make_shared<scene::TerrainMesh>();
  mesh->serial = synthetic::nextSerial();
  mesh->origin = panel.middle;
  for (const auto& [x, y] : std::array<std::array<double, 2>, 4>{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}}) {
    scene::TerrainVertex vertex;
    vertex.position_tile = geo::Vec3f(panel.right * x + panel.up * y);
    mesh->vertices.push_back(vertex);
  }
  mesh->indices = {0, 1, 2, 0, 2, 3};
  mesh->interior = {0, 6};
  synthetic::PaintedTile tile;
  tile.tile.mesh = mesh;
  tile.colour = synthetic::plainImage(panel.colour);
  return tile;
}

class DepthRange : public synthetic::GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    random_ = geo::seededGenerator();
    view_ = synthetic::viewAt(geo::earth().ellipsoid, uniform(-80, 80), uniform(-180, 180), 4000.0, uniform(0, 360), 0,
                              kSize, kFov_deg);
  }

  double uniform(double low, double high) { return geo::uniform(random_, low, high); }

  /// A panel at a place of the view: metres to the right, up and away, its half sides, and how it leans (radians about
  /// the view's own axes).
  Panel panel(const geo::Vec3& at, double halfWidth_m, double halfHeight_m, double yaw, double pitch,
              Rgba8 colour) const {
    const geo::Mat3 body = glm::transpose(view_.viewFromBody);
    const geo::Vec3 right(std::cos(yaw), 0.0, std::sin(yaw));
    const geo::Vec3 up =
        glm::normalize(geo::Vec3(0.0, std::cos(pitch), std::sin(pitch)) - right * (right.z * std::sin(pitch)));
    return {.middle = view_.eye + body * geo::Vec3(at.x, at.y, -at.z),
            .right = body * right * halfWidth_m,
            .up = body * up * halfHeight_m,
            .colour = colour};
  }

  /// The same panel that much farther along every ray.
  Panel behind(const Panel& front, double share, Rgba8 colour) const {
    return {.middle = view_.eye + (front.middle - view_.eye) * (1.0 + share),
            .right = front.right * (1.0 + share),
            .up = front.up * (1.0 + share),
            .colour = colour};
  }

  /// Each pixel that is surely in a panel, or surely in none, shows the nearest panel's colour and distance, in both
  /// orders. Gives how many pixels show each panel.
  std::vector<int> expectNearest(const std::vector<Panel>& panels) {
    std::vector<synthetic::PaintedTile> tiles;
    for (const Panel& one : panels)
      tiles.push_back(tileOf(one));
    Renderer renderer = makeRenderer();
    RenderTarget target = makeTarget(kSize);
    scene::Frame frame;
    frame.view = view_;
    frame.light.enabled = false;
    std::vector<int> shown(panels.size(), 0);
    for (int order = 0; order < 2; ++order) {
      synthetic::setTiles(frame, tiles);
      renderer.draw(frame, target);
      const auto picture = readColour(target);
      const auto distances = readDistance(target, view_);
      for (int row = 0; row < kSize.height; ++row) {
        for (int col = 0; col < kSize.width; ++col)
          expectNearest(panels, picture.at(col, row), static_cast<double>(distances.at(col, row)), col, row, shown);
      }
      std::reverse(tiles.begin(), tiles.end());
    }
    return shown;
  }

  scene::View view_;
  std::mt19937_64 random_;

 private:
  void expectNearest(const std::vector<Panel>& panels, Rgba8 colour, double distance_m, int col, int row,
                     std::vector<int>& shown) const {
    const geo::Ray ray = scene::rayThrough(view_, {col + 0.5, row + 0.5});
    const Panel* nearest = nullptr;
    double nearest_m = std::numeric_limits<double>::infinity();
    for (const Panel& one : panels) {
      // The share of its half side that kSure_px is.
      const double share = kSure_px * geo::length(one.middle - view_.eye) * view_.pixelAngle() /
                           std::min(geo::length(one.right), geo::length(one.up));
      const auto surely = one.along(ray, 1.0 - share);
      if (surely.has_value() != one.along(ray, 1.0 + share).has_value()) return;
      if (!surely || *surely >= nearest_m) continue;
      nearest = &one;
      nearest_m = *surely;
    }
    if (nearest == nullptr) {
      EXPECT_TRUE(std::isnan(distance_m)) << col << ", " << row;
      return;
    }
    EXPECT_EQ(colour, nearest->colour) << "pixel " << col << ", " << row << ", at " << nearest_m << " m";
    // Where a panel leans, a vertex that is rounded to a 256th of a pixel moves it along the ray.
    EXPECT_NEAR(distance_m, nearest_m, 4e-6 * nearest_m) << "pixel " << col << ", " << row;
    ++shown[static_cast<std::size_t>(nearest - panels.data())];
  }
};

TEST_F(DepthRange, AnObjectOfACentimetreStandsBeforeAMountain) {
  // A cube's face of 1 cm, a wall 1 mm behind it on the left, two ridges 300 km away on the right, 1 m apart, and a
  // plain behind all.
  const Panel object = panel({0.0, 0.0, kNear_m}, 0.005, 0.005, 0.0, 0.0, {255, 0, 0, 255});
  const Panel wall = panel({-0.05, 0.0, kNear_m + 0.001}, 0.05, 0.02, 0.0, 0.0, {0, 255, 0, 255});
  const Panel ridge = panel({4000.0, -2000.0, kFar_m}, 4000.0, 3000.0, 0.0, 0.0, {0, 0, 255, 255});
  const Panel second = panel({3000.0, -1000.0, kFar_m + 1.0}, 4000.0, 3000.0, 0.0, 0.0, {255, 255, 0, 255});
  const Panel plain = panel({0.0, -7000.0, kFar_m + 50.0}, 14000.0, 6000.0, 0.0, 0.0, {255, 0, 255, 255});
  const std::vector<int> shown = expectNearest({object, wall, ridge, second, plain});
  for (const int pixels : shown)
    EXPECT_GT(pixels, 100);
}

TEST_F(DepthRange, SurfacesAFewStepsOfDepthApartAreToldApart) {
  for (int i = 0; i < 10; ++i) {
    const Panel near = panel({uniform(-0.02, 0.02), uniform(-0.01, 0.01), kNear_m}, 0.02, 0.015, uniform(-0.001, 0.001),
                             uniform(-0.001, 0.001), {255, 0, 0, 255});
    const Panel afterNear = behind(near, kNearStep_m / kNear_m, {0, 255, 0, 255});
    const Panel far = panel({uniform(-2000, 2000), uniform(-1000, 1000), kFar_m}, 12000.0, 9000.0,
                            uniform(-0.001, 0.001), uniform(-0.001, 0.001), {0, 0, 255, 255});
    const Panel afterFar = behind(far, kFarStep_m / kFar_m, {255, 255, 0, 255});
    const std::vector<int> shown = expectNearest({near, afterNear, far, afterFar});
    EXPECT_GT(shown[0], 1000);
    EXPECT_EQ(shown[1], 0);
    EXPECT_GT(shown[2], 1000);
    EXPECT_EQ(shown[3], 0);
    if (HasFailure()) return;
  }
}

// The measure can fail: what is nearer than a step of depth is a toss-up.
TEST_F(DepthRange, SurfacesWithinAStepOfDepthAreNot) {
  const Panel far = panel({0, 0, kFar_m}, 12000.0, 9000.0, 0.3, 0.2, {0, 0, 255, 255});
  const Panel same = behind(far, 1e-9, {255, 255, 0, 255});
  Renderer renderer = makeRenderer();
  RenderTarget target = makeTarget(kSize);
  scene::Frame frame;
  frame.view = view_;
  frame.light.enabled = false;
  const std::vector<Panel> panels{far, same};
  int wrong = 0;
  for (const bool farFirst : {true, false}) {
    synthetic::setTiles(frame,
                        farFirst ? std::vector{tileOf(far), tileOf(same)} : std::vector{tileOf(same), tileOf(far)});
    renderer.draw(frame, target);
    for (const Rgba8& pixel : readColour(target).samples)
      wrong += pixel == same.colour ? 1 : 0;
  }
  EXPECT_GT(wrong, 1000);
}

}  // namespace
}  // namespace tellurion::render
