// Nothing shakes: where boards of centimetres are drawn against positions in double precision, 2 m above them, where no
// tile has such cells: exactly at a pole, on a body of the size of the sun.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "geo/body.h"
#include "geo/seed_test.h"
#include "render/synthetic_tiles_test.h"
#include "scene/picking.h"

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

TEST_F(Precision, CentimetresFromTwoMetresUpAtThePole) {
  expectSteady(geo::mars().ellipsoid, 90.0, 0.0);
  expectSteady(geo::earth().ellipsoid, -89.9999, 45.0);
}

TEST_F(Precision, CentimetresFromTwoMetresUpOnABodyLikeTheSun) {
  expectSteady(geo::Ellipsoid(6.957e8, 0.0), 33.0, -120.0);
}

}  // namespace
}  // namespace tellurion::render
