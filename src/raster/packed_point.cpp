#include "raster/packed_point.h"

#include <algorithm>
#include <cmath>

namespace tellurion::raster {
namespace {

using tiling::kMaxLevel;
using tiling::TileId;

constexpr double kParts = 65536.0;

struct InCell {
  std::uint32_t cell;
  std::uint16_t part;
};
InCell inCell(double along) {
  const double cells = along * static_cast<double>(std::int64_t{1} << kMaxLevel);
  const double whole = std::clamp(std::floor(cells), 0.0, static_cast<double>((std::int64_t{1} << kMaxLevel) - 1));
  const double part = std::clamp(std::floor((cells - whole) * kParts), 0.0, kParts - 1.0);
  return {static_cast<std::uint32_t>(whole), static_cast<std::uint16_t>(part)};
}

/// On its root, in cells of the deepest level.
struct OnRoot {
  double x;
  double y;
};
OnRoot onRoot(const PackedPoint& point) {
  const TileId id = tiling::tileFromHealpixNested(kMaxLevel, point.cell);
  return {id.x + (point.u + 0.5) / kParts, id.y + (point.v + 0.5) / kParts};
}

}  // namespace

std::uint64_t cellOf(const PackedPoint& point, int level) {
  return point.cell >> (2 * (kMaxLevel - level));
}

PackedPoint packedPoint(const geo::Direction& place, float height_m) {
  const tiling::RootPoint at = kPointIndex.rootPoint(place);
  const InCell u = inCell(at.u);
  const InCell v = inCell(at.v);
  const TileId cell{.level = kMaxLevel, .root = static_cast<std::uint8_t>(at.root), .x = u.cell, .y = v.cell};
  return {.cell = tiling::healpixNested(cell), .u = u.part, .v = v.part, .height_m = height_m};
}

geo::Direction placeOf(const PackedPoint& point) {
  const TileId id = tiling::tileFromHealpixNested(kMaxLevel, point.cell);
  const OnRoot at = onRoot(point);
  const double size = tiling::tileSize(kMaxLevel);
  return kPointIndex.direction({.root = id.root, .u = at.x * size, .v = at.y * size});
}

PackedPoint meanPoint(std::span<const PackedPoint> points) {
  if (points.size() == 1) return points.front();
  double x = 0.0;
  double y = 0.0;
  double height_m = 0.0;
  for (const PackedPoint& point : points) {
    const OnRoot at = onRoot(point);
    x += at.x;
    y += at.y;
    height_m += static_cast<double>(point.height_m);
  }
  const auto count = static_cast<double>(points.size());
  const double size = tiling::tileSize(kMaxLevel);
  const InCell u = inCell(x / count * size);
  const InCell v = inCell(y / count * size);
  const std::uint8_t root = tiling::tileFromHealpixNested(kMaxLevel, points.front().cell).root;
  return {.cell = tiling::healpixNested({.level = kMaxLevel, .root = root, .x = u.cell, .y = v.cell}),
          .u = u.part,
          .v = v.part,
          .height_m = static_cast<float>(height_m / count)};
}

}  // namespace tellurion::raster
