// Nothing shakes: where things are drawn against positions in double precision, 2 m above the ground of whole planets.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "geo/body.h"
#include "geo/seed_test.h"
#include "render/synthetic_tiles_test.h"
#include "scene/picking.h"
#include "scene/terrain_mesh.h"

namespace tellurion::render {
namespace {

using raster::Rgba8;

constexpr int kSide = 32;  // cells a side
constexpr double kCell_m = 0.01;
constexpr scene::Viewport kSize{200, 200};
constexpr double kAllowed_px = 0.1;

/// A flat board of 1 cm cells lying on the ground, each cell a mesh and a colour of its own: places that no tile has
/// such cells at.
class Board {
 public:
  Board(const geo::Ellipsoid& ellipsoid, double lat, double lon)
      : frame_(geo::localFrameAt(ellipsoid, {.lat = geo::Angle::degrees(lat), .lon = geo::Angle::degrees(lon)})) {
    image_ = std::make_shared<scene::TextureImage>();
    image_->serial = synthetic::nextSerial();
    image_->isOpaque = true;
    image_->mips.emplace_back(kSide, kSide);
    for (int row = 0; row < kSide; ++row) {
      for (int col = 0; col < kSide; ++col) {
        image_->mips[0].at(col, row) = colourOf(col, row);
        tiles_.push_back(cell(col, row));
      }
    }
  }

  const std::vector<synthetic::PaintedTile>& tiles() const { return tiles_; }
  static Rgba8 colourOf(int col, int row) {
    return {static_cast<std::uint8_t>(8 * col + 3), static_cast<std::uint8_t>(8 * row + 3), 200, 255};
  }

  /// The cell that a ray meets.
  std::optional<std::array<int, 2>> cellAlong(const geo::Ray& ray) const {
    const geo::Mat3 enuFromBody = glm::transpose(frame_.bodyFromEnu());
    const geo::Vec3 eye = enuFromBody * (ray.origin - frame_.origin);
    const geo::Vec3 direction = enuFromBody * ray.direction;
    if (!(direction.z < 0.0)) return std::nullopt;
    const geo::Vec3 hit = eye - direction * (eye.z / direction.z);
    const std::array<int, 2> cell{static_cast<int>(std::floor(hit.x / kCell_m + kSide / 2)),
                                  static_cast<int>(std::floor(hit.y / kCell_m + kSide / 2))};
    const auto inside = [](int i) { return i >= 0 && i < kSide; };
    return inside(cell[0]) && inside(cell[1]) ? std::optional(cell) : std::nullopt;
  }

 private:
  geo::Vec3 corner_body(int col, int row) const {
    return frame_.origin.m +
           frame_.bodyFromEnu() * geo::Vec3((col - kSide / 2) * kCell_m, (row - kSide / 2) * kCell_m, 0.0);
  }

  synthetic::PaintedTile cell(int col, int row) const {
    auto mesh = std::make_shared<scene::TerrainMesh>();
    mesh->serial = synthetic::nextSerial();
    mesh->origin = synthetic::onGrid({corner_body(col, row)});
    for (const auto& [right, up] : std::array<std::array<int, 2>, 4>{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}}) {
      scene::TerrainVertex vertex;
      vertex.position_tile = geo::Vec3f(corner_body(col + right, row + up) - mesh->origin.m);
      mesh->vertices.push_back(vertex);
    }
    mesh->indices = {0, 1, 2, 0, 2, 3};
    mesh->interior = {0, 6};
    synthetic::PaintedTile tile;
    tile.tile.mesh = mesh;
    tile.colour = image_;
    tile.colourWindow = {{(static_cast<float>(col) + 0.5f) / kSide, (static_cast<float>(row) + 0.5f) / kSide},
                         {0.0f, 0.0f}};
    return tile;
  }

  geo::LocalFrame frame_;
  std::shared_ptr<scene::TextureImage> image_;
  std::vector<synthetic::PaintedTile> tiles_;
};

/// The middle of a tile as the program makes it, samples about a centimetre apart and as bumpy as gravel: the triangles
/// of each cell are drawn in a colour of their own.
class TileMiddle {
 public:
  TileMiddle(tiling::Scheme scheme, const geo::Ellipsoid& ellipsoid, const geo::Direction& place, double height_m)
      : cells_(64) {
    const tiling::Tiling tiling(scheme);
    const double edge_m = tiling.metrics(0).meanEdge.radians() * ellipsoid.semiMajorAxis_m();
    const tiling::TileId id = tiling.tileAt(place, static_cast<int>(std::lround(std::log2(edge_m / cells_ / kCell_m))));
    scene::GroundSamples heights(cells_ + 3, cells_ + 3);
    for (float& h : heights.samples)
      h = static_cast<float>(height_m + 0.001 * static_cast<double>((&h - heights.samples.data()) * 7 % 5));
    const scene::SurfaceGrid grid = scene::surfaceGrid(tiling, ellipsoid, id, heights);
    mesh_ = scene::makeTerrainMesh(tiling, ellipsoid, grid, nullptr, true).mesh;
    middle_ = grid.positions[grid.index(cells_ / 2, cells_ / 2)];
    for (int row = 0; row <= kSide; ++row) {
      for (int col = 0; col <= kSide; ++col) {
        const int c = first() + col;
        const int r = first() + row;
        const geo::Direction d = tiling.direction(tiling::rootPointIn(id, double(c) / cells_, double(r) / cells_));
        points_.push_back(ellipsoid.bodyFromDirection(d, static_cast<double>(heights.at(c + 1, r + 1))));
      }
    }
    addTiles();
  }

  const geo::BodyPosition& middle() const { return middle_; }
  const std::vector<synthetic::PaintedTile>& tiles() const { return tiles_; }

  /// How far in pixels the cells of a picture lie beside where they belong: the way from a cell's outline, projected in
  /// double precision, to the middles of pixels that have its colour outside, or have not inside.
  struct Off {
    double most_px = 0.0;
    int compared = 0;
  };
  Off offIn(const raster::Raster<Rgba8>& picture, const scene::View& view) const {
    std::vector<scene::PixelPosition> corners;
    for (const geo::BodyPosition& p : points_)
      corners.push_back(*scene::pixelOf(view, p));
    Off off;
    for (int row = 0; row < kSide; ++row) {
      for (int col = 0; col < kSide; ++col) {
        const auto at = [&](int c, int r) {
          return corners[static_cast<std::size_t>((row + r) * (kSide + 1) + col + c)];
        };
        const std::array outline{at(0, 0), at(0, 1), at(1, 1), at(1, 0)};
        compare(outline, Board::colourOf(col, row), picture, off);
      }
    }
    return off;
  }

 private:
  int first() const { return (cells_ - kSide) / 2; }

  void addTiles() {
    auto image = std::make_shared<scene::TextureImage>();
    image->serial = synthetic::nextSerial();
    image->isOpaque = true;
    image->mips.emplace_back(kSide, kSide);
    std::vector<std::uint16_t> vertexAt(static_cast<std::size_t>((cells_ + 1) * (cells_ + 1)));
    const int unit = scene::kPlaceUnits / cells_;
    const auto slot = [&](int col, int row) { return static_cast<std::size_t>(row * (cells_ + 1) + col); };
    for (std::size_t i = 0; i < mesh_->vertices.size(); ++i)
      vertexAt[slot(mesh_->vertices[i].s / unit, mesh_->vertices[i].t / unit)] = static_cast<std::uint16_t>(i);
    for (int row = 0; row < kSide; ++row) {
      for (int col = 0; col < kSide; ++col) {
        image->mips[0].at(col, row) = Board::colourOf(col, row);
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

  int cells_;
  std::shared_ptr<const scene::TerrainMesh> mesh_;
  geo::BodyPosition middle_;
  std::vector<geo::BodyPosition> points_;  ///< (kSide + 1)^2, in double precision
  std::vector<synthetic::PaintedTile> tiles_;
};

class Precision : public synthetic::GlTest {
 protected:
  /// The pixels that are of one cell also when moved by kAllowed_px in any direction must show that cell. Gives how
  /// many there were.
  static int expectCells(const Board& board, const scene::View& view, const raster::Raster<Rgba8>& picture) {
    int compared = 0;
    for (int row = 0; row < kSize.height; ++row) {
      for (int col = 0; col < kSize.width; ++col) {
        const auto cellAt = [&](double dx, double dy) {
          return board.cellAlong(scene::rayThrough(view, {col + 0.5 + dx, row + 0.5 + dy}));
        };
        const auto cell = cellAt(kAllowed_px, kAllowed_px);
        const bool sure = cell && cell == cellAt(-kAllowed_px, kAllowed_px) &&
                          cell == cellAt(kAllowed_px, -kAllowed_px) && cell == cellAt(-kAllowed_px, -kAllowed_px);
        if (!sure) continue;
        ++compared;
        if (picture.at(col, row) != Board::colourOf((*cell)[0], (*cell)[1])) {
          ADD_FAILURE() << "pixel " << col << ", " << row << " does not show cell " << (*cell)[0] << ", " << (*cell)[1];
          return compared;
        }
      }
    }
    return compared;
  }

  static void expectSteady(const geo::Ellipsoid& ellipsoid, double lat, double lon) {
    auto random = geo::seededGenerator();
    const Board board(ellipsoid, lat, lon);
    Renderer renderer = makeRenderer();
    RenderTarget target = makeTarget(kSize);
    scene::Frame frame;
    frame.light.enabled = false;
    synthetic::setTiles(frame, board.tiles());
    scene::View view = synthetic::viewAt(ellipsoid, lat, lon, 2.0, geo::uniform(random, 0, 360), -90, kSize, 10);
    for (int step = 0; step < 40; ++step) {
      const auto move = [&] { return geo::uniform(random, -0.002, 0.002); };
      view.eye = view.eye + geo::Vec3(move(), move(), move());
      frame.view = view;
      renderer.draw(frame, target);
      EXPECT_GT(expectCells(board, view, readColour(target)), 10000) << "step " << step;
      if (HasFailure()) return;
    }
  }
};

/// Tiles of the program's own making.
class TilePrecision : public Precision, public testing::WithParamInterface<tiling::Scheme> {
 protected:
  static constexpr int kSteps = 10;
  static constexpr double kStep_m = 0.001;

  /// What is drawn is within half of kAllowed_px of where it belongs while the eye moves by millimetres, so between two
  /// pictures all of it moves as far as it should within kAllowed_px. Gives how far it was off.
  double expectSteady(const geo::Ellipsoid& ellipsoid, const geo::Direction& place, std::mt19937_64& random) {
    const TileMiddle ground(GetParam(), ellipsoid, place, geo::uniform(random, -8000.0, 8800.0));
    Renderer renderer = makeRenderer();
    RenderTarget target = makeTarget(kSize);
    scene::Frame frame;
    frame.light.enabled = false;
    frame.vertexGrid_m = scene::vertexGrid_m(ellipsoid);
    synthetic::setTiles(frame, ground.tiles());
    const geo::Geodetic below = ellipsoid.geodeticFromBody(ground.middle());
    frame.view = synthetic::viewAt(ellipsoid, below.lat.degrees(), below.lon.degrees(), below.height_m + 2.0,
                                   geo::uniform(random, 0, 360), -90, kSize, 10);
    const geo::LocalFrame local = geo::localFrameAt(ellipsoid, below);
    const double course = geo::uniform(random, 0.0, 2.0 * geo::kPi);
    const geo::Vec3 step = (local.east * std::cos(course) + local.north * std::sin(course)) * kStep_m;
    double most_px = 0.0;
    for (int i = 0; i < kSteps; ++i) {
      frame.view.eye = frame.view.eye + step;
      renderer.draw(frame, target);
      const TileMiddle::Off off = ground.offIn(readColour(target), frame.view);
      EXPECT_LE(off.most_px, 0.5 * kAllowed_px)
          << "step " << i << " at " << below.lat.degrees() << ", " << below.lon.degrees() << ", " << below.height_m;
      EXPECT_GT(off.compared, 5000);
      most_px = std::max(most_px, off.most_px);
    }
    return most_px;
  }

  /// Poles, date line, where three roots of the cube meet, and anywhere. The geographic tiling's cells are a centimetre
  /// wide both ways only away from the poles.
  static std::vector<geo::Direction> places(std::mt19937_64& random) {
    const bool geographic = GetParam() == tiling::Scheme::geographic;
    std::vector<geo::Direction> out{geo::directionFromDegrees(0.0, 180.0), geo::directionFromDegrees(35.2643897, 45.0)};
    if (!geographic) out.push_back(geo::directionFromDegrees(90.0, 0.0));
    if (!geographic) out.push_back(geo::directionFromDegrees(-90.0, 0.0));
    while (out.size() < 7) {
      const double most = geographic ? std::sin(geo::kPi / 3.0) : 1.0;
      out.push_back(geo::directionFromLatLon(geo::Angle::radians(std::asin(geo::uniform(random, -most, most))),
                                             geo::Angle::degrees(geo::uniform(random, -180, 180))));
    }
    return out;
  }
};

TEST_P(TilePrecision, CentimetresFromTwoMetresUp) {
  auto random = geo::seededGenerator();
  for (const geo::Body& body : {geo::earth(), geo::mars()}) {
    double most_px = 0.0;
    for (const geo::Direction& place : places(random))
      most_px = std::max(most_px, expectSteady(body.ellipsoid, place, random));
    std::printf("%s, %s: at most %.4f pixels off\n", body.name.c_str(), std::string(nameOf(GetParam())).c_str(),
                most_px);
  }
}

INSTANTIATE_TEST_SUITE_P(Schemes, TilePrecision,
                         testing::Values(tiling::Scheme::geographic, tiling::Scheme::cube, tiling::Scheme::healpix),
                         [](const auto& scheme) { return std::string(nameOf(scheme.param)); });

TEST_F(Precision, CentimetresFromTwoMetresUpAtThePole) {
  expectSteady(geo::mars().ellipsoid, 90.0, 0.0);
  expectSteady(geo::earth().ellipsoid, -89.9999, 45.0);
}

TEST_F(Precision, CentimetresFromTwoMetresUpOnABodyLikeTheSun) {
  expectSteady(geo::Ellipsoid(6.957e8, 0.0), 33.0, -120.0);
}

}  // namespace
}  // namespace tellurion::render
