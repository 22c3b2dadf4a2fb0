// Nothing shakes: where tiles of the program's own making are drawn against positions in double precision, 2 m above
// their ground, everywhere on whole planets, whether they morph or not.

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "geo/body.h"
#include "geo/seed_test.h"
#include "render/synthetic_tiles_test.h"
#include "scene/parent_surface.h"
#include "scene/picking.h"
#include "scene/procedural_source_test.h"
#include "scene/terrain_mesh.h"

namespace tellurion::render {
namespace {

using raster::Rgba8;

constexpr int kSide = 32;  // cells a side
constexpr double kCell_m = 0.01;
constexpr scene::Viewport kSize{200, 200};
constexpr double kAllowed_px = 0.1;

Rgba8 colourOf(int col, int row) {
  return {static_cast<std::uint8_t>(8 * col + 3), static_cast<std::uint8_t>(8 * row + 3), 200, 255};
}

using Morph = std::array<float, 4>;

/// The middle of a tile as the program makes it, samples about a centimetre apart and as bumpy as gravel, with the
/// parent that it grows out of: the triangles of each cell are drawn in a colour of their own.
class TileMiddle {
 public:
  TileMiddle(tiling::Scheme scheme, const geo::Ellipsoid& ellipsoid, const geo::Direction& place, double height_m)
      : tiling_(scheme), ellipsoid_(ellipsoid), height_m_(height_m) {
    const double edge_m = tiling_.metrics(0).meanEdge.radians() * ellipsoid.semiMajorAxis_m();
    const auto level = static_cast<int>(std::lround(std::log2(edge_m / kCells / kCell_m)));
    const tiling::TileId id = tiling_.tileAt(place, level);
    const scene::SurfaceGrid grid = surfaceOf(id);
    const auto parent = scene::makeTerrainMesh(tiling_, ellipsoid, surfaceOf(id.parent()), nullptr, true).mesh;
    mesh_ = scene::makeTerrainMesh(tiling_, ellipsoid, grid, parent.get(), true).mesh;
    middle_ = grid.positions[grid.index(kCells / 2, kCells / 2)];
    const scene::ParentSurface from =
        scene::parentSurface(*parent, scene::vertexGrid_m(ellipsoid), id.quadrant(), kCells);
    for (int row = 0; row <= kSide; ++row) {
      for (int col = 0; col <= kSide; ++col) {
        const int c = first() + col;
        const int r = first() + row;
        points_.push_back({.place = geo::Vec2(c, r) / static_cast<double>(kCells),
                           .own = groundAt(id, c, r).m,
                           .parents = from.positions[static_cast<std::size_t>(r * (kCells + 1) + c)]});
      }
    }
    addTiles();
  }

  const geo::BodyPosition& middle() const { return middle_; }
  std::vector<synthetic::PaintedTile> tiles(const Morph& morph) const {
    std::vector<synthetic::PaintedTile> out = tiles_;
    for (synthetic::PaintedTile& painted : out)
      painted.tile.morph = morph;
    return out;
  }
  /// The longest way that a point goes from the parent's surface to the tile's own.
  double longestWay_m() const {
    double longest_m = 0.0;
    for (const Point& p : points_)
      longest_m = std::max(longest_m, geo::length(p.own - p.parents));
    return longest_m;
  }

  /// How far in pixels the cells of a picture lie beside where they belong: the way from a cell's outline, projected in
  /// double precision, to the middles of pixels that have its colour outside, or have not inside.
  struct Off {
    double most_px = 0.0;
    int compared = 0;
  };
  Off offIn(const raster::Raster<Rgba8>& picture, const scene::View& view, const Morph& morph) const {
    std::vector<scene::PixelPosition> corners;
    for (const Point& p : points_)
      corners.push_back(*scene::pixelOf(view, p.drawn(morph)));
    Off off;
    for (int row = 0; row < kSide; ++row) {
      for (int col = 0; col < kSide; ++col) {
        const auto at = [&](int c, int r) {
          return corners[static_cast<std::size_t>((row + r) * (kSide + 1) + col + c)];
        };
        const std::array outline{at(0, 0), at(0, 1), at(1, 1), at(1, 0)};
        compare(outline, colourOf(col, row), picture, off);
      }
    }
    return off;
  }

 private:
  static constexpr int kCells = 64;

  struct Point {
    geo::Vec2 place;    ///< in the tile, 0..1
    geo::Vec3 own;      ///< where it is in the tile's own surface, in double precision
    geo::Vec3 parents;  ///< and in its parent's

    geo::BodyPosition drawn(const Morph& morph) const {
      const auto at = [&](std::size_t corner) { return static_cast<double>(morph[corner]); };
      const double share = std::lerp(std::lerp(at(0), at(1), place.x), std::lerp(at(2), at(3), place.x), place.y);
      return {parents + (own - parents) * share};
    }
  };

  static int first() { return (kCells - kSide) / 2; }

  /// The same on all levels, as samples of tiles are.
  float heightAt(const geo::Direction& d) const {
    constexpr double kGravel_m = 0.004;
    return static_cast<float>(height_m_ + kGravel_m * scene::hashOf(d, 0));
  }
  geo::Direction directionAt(const tiling::TileId& id, int col, int row) const {
    return tiling_.direction(
        tiling::rootPointIn(id, static_cast<double>(col) / kCells, static_cast<double>(row) / kCells));
  }
  geo::BodyPosition groundAt(const tiling::TileId& id, int col, int row) const {
    const geo::Direction d = directionAt(id, col, row);
    return ellipsoid_.bodyFromDirection(d, static_cast<double>(heightAt(d)));
  }
  scene::SurfaceGrid surfaceOf(const tiling::TileId& id) const {
    scene::GroundSamples heights(kCells + 3, kCells + 3, static_cast<float>(height_m_));
    for (int row = 0; row <= kCells; ++row) {
      for (int col = 0; col <= kCells; ++col)
        heights.at(col + 1, row + 1) = heightAt(directionAt(id, col, row));
    }
    return scene::surfaceGrid(tiling_, ellipsoid_, id, heights);
  }

  void addTiles() {
    auto image = std::make_shared<scene::TextureImage>();
    image->serial = synthetic::nextSerial();
    image->isOpaque = true;
    image->mips.emplace_back(kSide, kSide);
    std::vector<std::uint16_t> vertexAt(static_cast<std::size_t>((kCells + 1) * (kCells + 1)));
    const int unit = scene::kPlaceUnits / kCells;
    const auto slot = [&](int col, int row) { return static_cast<std::size_t>(row * (kCells + 1) + col); };
    for (std::size_t i = 0; i < mesh_->vertices.size(); ++i)
      vertexAt[slot(mesh_->vertices[i].s / unit, mesh_->vertices[i].t / unit)] = static_cast<std::uint16_t>(i);
    for (int row = 0; row < kSide; ++row) {
      for (int col = 0; col < kSide; ++col) {
        image->mips[0].at(col, row) = colourOf(col, row);
        auto cell = std::make_shared<scene::TerrainMesh>();
        cell->serial = synthetic::nextSerial();
        cell->origin = mesh_->origin;
        cell->parentStep_m = mesh_->parentStep_m;
        for (const auto& [right, down] : std::array<std::array<int, 2>, 4>{{{0, 0}, {0, 1}, {1, 1}, {1, 0}}})
          cell->vertices.push_back(mesh_->vertices[vertexAt[slot(first() + col + right, first() + row + down)]]);
        cell->indices = {0, 1, 2, 0, 2, 3};
        cell->interior = {0, 6};
        synthetic::PaintedTile tile;
        tile.tile.mesh = cell;
        tile.colour = image;
        tile.colourWindow = {{(static_cast<float>(col) + 0.5f) / kSide, (static_cast<float>(row) + 0.5f) / kSide},
                             {0.0f, 0.0f}};
        tiles_.push_back(tile);
      }
    }
  }

  static void compare(const std::array<scene::PixelPosition, 4>& outline, const Rgba8& colour,
                      const raster::Raster<Rgba8>& picture, Off& off) {
    const auto [left, right] =
        std::minmax_element(outline.begin(), outline.end(), [](const auto& a, const auto& b) { return a.x < b.x; });
    const auto [top, bottom] =
        std::minmax_element(outline.begin(), outline.end(), [](const auto& a, const auto& b) { return a.y < b.y; });
    const auto within = [](double v, int size) { return std::clamp(static_cast<int>(v), 0, size); };
    for (int row = within(top->y - 2, picture.height); row < within(bottom->y + 3, picture.height); ++row) {
      for (int col = within(left->x - 2, picture.width); col < within(right->x + 3, picture.width); ++col) {
        const double inside_px = distanceInside(outline, {col + 0.5, row + 0.5});
        const bool shown = picture.at(col, row) == colour;
        off.compared += inside_px >= 0.0 ? 1 : 0;
        if (shown != (inside_px >= 0.0)) off.most_px = std::max(off.most_px, std::abs(inside_px));
      }
    }
  }

  /// Pixels to the nearest side of a convex outline, negative outside.
  static double distanceInside(const std::array<scene::PixelPosition, 4>& outline, const scene::PixelPosition& p) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 4; ++i) {
      const scene::PixelPosition& a = outline[i];
      const scene::PixelPosition& b = outline[(i + 1) % 4];
      const double cross = (p.x - a.x) * (b.y - a.y) - (p.y - a.y) * (b.x - a.x);
      least = std::min(least, cross / std::hypot(b.x - a.x, b.y - a.y));
    }
    return least;
  }

  tiling::Tiling tiling_;
  geo::Ellipsoid ellipsoid_;
  double height_m_;
  std::shared_ptr<const scene::TerrainMesh> mesh_;
  geo::BodyPosition middle_;
  std::vector<Point> points_;  ///< (kSide + 1)^2
  std::vector<synthetic::PaintedTile> tiles_;
};

/// Tiles of the program's own making.
class TilePrecision : public synthetic::GlTest, public testing::WithParamInterface<tiling::Scheme> {
 protected:
  static constexpr int kSteps = 10;
  static constexpr double kStep_m = 0.001;

  /// What is drawn is within half of kAllowed_px of where it belongs while the eye moves by millimetres, so between two
  /// pictures all of it moves as far as it should within kAllowed_px. Gives how far it was off.
  double expectSteady(const geo::Ellipsoid& ellipsoid, const geo::Direction& place, bool morphs,
                      std::mt19937_64& random) {
    const TileMiddle ground(GetParam(), ellipsoid, place, geo::uniform(random, -8000.0, 8800.0));
    Renderer renderer = makeRenderer();
    RenderTarget target = makeTarget(kSize);
    scene::Frame frame;
    frame.light.enabled = false;
    frame.vertexGrid_m = scene::vertexGrid_m(ellipsoid);
    // Else there is nothing to see of a morph: a pixel is 1.75 mm wide.
    EXPECT_GT(ground.longestWay_m(), 0.001);
    const geo::Geodetic below = ellipsoid.geodeticFromBody(ground.middle());
    frame.view = synthetic::viewAt(ellipsoid, below.lat.degrees(), below.lon.degrees(), below.height_m + 2.0,
                                   geo::uniform(random, 0, 360), -90, kSize, 10);
    const geo::LocalFrame local = geo::localFrameAt(ellipsoid, below);
    const double course = geo::uniform(random, 0.0, 2.0 * geo::kPi);
    const geo::Vec3 step = (local.east * std::cos(course) + local.north * std::sin(course)) * kStep_m;
    double most_px = 0.0;
    for (int i = 0; i < kSteps; ++i) {
      frame.view.eye = frame.view.eye + step;
      Morph morph{1.0f, 1.0f, 1.0f, 1.0f};
      if (morphs) {
        for (float& m : morph)
          m = static_cast<float>(geo::uniform(random, 0.0, 1.0));
      }
      synthetic::setTiles(frame, ground.tiles(morph));
      renderer.draw(frame, target);
      const TileMiddle::Off off = ground.offIn(readColour(target), frame.view, morph);
      EXPECT_LE(off.most_px, 0.5 * kAllowed_px)
          << "step " << i << " at " << below.lat.degrees() << ", " << below.lon.degrees() << ", " << below.height_m;
      EXPECT_GT(off.compared, 5000);
      most_px = std::max(most_px, off.most_px);
    }
    return most_px;
  }

  /// Poles and near them, date line, where three roots of the cube meet, and anywhere.
  static std::vector<geo::Direction> places(std::mt19937_64& random) {
    std::vector<geo::Direction> out{geo::directionFromDegrees(0.0, 180.0), geo::directionFromDegrees(35.2643897, 45.0),
                                    geo::directionFromDegrees(90.0, 0.0), geo::directionFromDegrees(-90.0, 0.0)};
    const auto anyLongitude = [&] { return geo::Angle::degrees(geo::uniform(random, -180, 180)); };
    for (const double side : {-1.0, 1.0}) {
      const double fromPole_deg = std::pow(10.0, geo::uniform(random, -7.0, 1.5));
      out.push_back(geo::directionFromLatLon(geo::Angle::degrees(side * (90.0 - fromPole_deg)), anyLongitude()));
    }
    while (out.size() < 10)
      out.push_back(
          geo::directionFromLatLon(geo::Angle::radians(std::asin(geo::uniform(random, -1.0, 1.0))), anyLongitude()));
    return out;
  }
};

TEST_P(TilePrecision, CentimetresFromTwoMetresUp) {
  auto random = geo::seededGenerator();
  for (const geo::Body& body : {geo::earth(), geo::mars()}) {
    for (const bool morphs : {false, true}) {
      double most_px = 0.0;
      for (const geo::Direction& place : places(random))
        most_px = std::max(most_px, expectSteady(body.ellipsoid, place, morphs, random));
      std::printf("%s, %s%s: at most %.4f pixels off\n", body.name.c_str(), std::string(nameOf(GetParam())).c_str(),
                  morphs ? ", morphing" : "", most_px);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Schemes, TilePrecision,
                         testing::Values(tiling::Scheme::geographic, tiling::Scheme::cube, tiling::Scheme::healpix),
                         [](const auto& scheme) { return std::string(nameOf(scheme.param)); });

}  // namespace
}  // namespace tellurion::render
