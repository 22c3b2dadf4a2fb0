#include <algorithm>
#include <cmath>

#include "scene/relief.h"
#include "scene/terrain_mesh.h"

namespace tellurion::scene {
namespace {

/// Under this share of the square of a cell's own size two gutter samples are one place.
constexpr double kSamePlace2 = 1e-12;

geo::Vec3 triangleNormal(const geo::Vec3& a, const geo::Vec3& b, const geo::Vec3& c) {
  return geo::cross(b - a, c - a);
}

/// The ground's normal at a sample, not yet of unit length, either way round; zero where a cliff leaves it none.
geo::Vec3 normalAt(const SurfaceGrid& grid, int col, int row) {
  const auto at = [&](int c, int r) { return grid.positions[grid.index(c, r)].m; };
  const geo::Vec3 left = at(col - 1, row);
  const geo::Vec3 right = at(col + 1, row);
  const geo::Vec3 above = at(col, row - 1);
  const geo::Vec3 below = at(col, row + 1);
  const bool atCorner = (col == 0 || col == grid.cells) && (row == 0 || row == grid.cells);
  if (atCorner) {
    const geo::Vec3 outerCol = col == 0 ? left : right;
    const geo::Vec3 outerRow = row == 0 ? above : below;
    const geo::Vec3 innerCol = col == 0 ? right : left;
    const geo::Vec3 innerRow = row == 0 ? below : above;
    const geo::Vec3 apart = outerCol - outerRow;
    const geo::Vec3 size = innerCol - innerRow;
    // Three tiles meet: both gutters hold the one sample that lies along the third edge.
    if (geo::dot(apart, apart) < kSamePlace2 * geo::dot(size, size))
      return triangleNormal(innerCol, innerRow, outerCol);
  }
  return geo::cross(right - left, below - above);
}

/// To the nearest, so that rough ground does not lean to one side.
std::uint8_t texel(double v) {
  return static_cast<std::uint8_t>(std::clamp(std::floor(v * 127.0 + 128.5), 0.0, 255.0));
}

raster::Rgba8 reliefAt(const SurfaceGrid& grid, int col, int row) {
  const geo::Vec3 up = grid.up[grid.index(col, row)].n;
  geo::Vec3 normal = normalAt(grid, col, row);
  const double size = geo::length(normal);
  normal = size > 0.0 ? normal * ((geo::dot(normal, up) < 0.0 ? -1.0 : 1.0) / size) : up;
  const geo::Vec3 relief = normal - up;
  return {texel(relief.x), texel(relief.y), texel(relief.z), 255};
}

}  // namespace

std::shared_ptr<const TextureImage> makeRelief(const SurfaceGrid& grid) {
  raster::Raster<raster::Rgba8> picture(grid.cells + 1, grid.cells + 1);
  for (int row = 0; row <= grid.cells; ++row) {
    for (int col = 0; col <= grid.cells; ++col)
      picture.at(col, row) = reliefAt(grid, col, row);
  }
  auto image = std::make_shared<TextureImage>();
  image->serial = nextSerial();
  image->mips.push_back(std::move(picture));
  return image;
}

}  // namespace tellurion::scene
