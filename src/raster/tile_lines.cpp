#include "raster/tile_lines.h"

#include <limits>
#include <optional>

#include "raster/tile_places.h"

namespace tellurion::raster {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr int kSideRoots = 4;  // of the geographic tiling, around the equator

double partOf(Kind kind, int cells, int index) {
  return (index - (kind == Kind::elevation ? 1.0 : 0.5)) / cells;
}

tiling::LonLat lonLatAt(const tiling::Tiling& tiling, const tiling::TileId& id, double s, double t) {
  const tiling::RootPoint here = tiling::rootPointIn(id, s, t);
  const bool isInside = here.u >= 0.0 && here.u <= 1.0 && here.v >= 0.0 && here.v <= 1.0;
  const auto point = isInside ? std::optional(here) : tiling.wrapped(here);
  return point ? tiling.lonLat(*point).value_or(tiling::LonLat{kNone, kNone}) : tiling::LonLat{kNone, kNone};
}

}  // namespace

bool isOfLonLat(const Placement& placement, const tiling::Tiling& tiling) {
  return placement.isStraightLonLat() && tiling.scheme() == tiling::Scheme::geographic;
}

bool isOfLines(const tiling::TileId& id) {
  return id.root < kSideRoots;
}

PixelLines pixelLines(const Placement& placement, const tiling::Tiling& tiling, const tiling::TileId& id, Kind kind,
                      int cells) {
  const int side = sideOf(kind, cells);
  PixelLines lines;
  for (int i = 0; i < side; ++i) {
    const double part = partOf(kind, cells, i);
    lines.col.push_back(lonLatAt(tiling, id, part, 0.5).longitude_degrees);
    const double v = tiling::rootPointIn(id, 0.5, part).v;
    lines.row.push_back(v >= 0.0 && v <= 1.0 ? lonLatAt(tiling, id, 0.5, part).latitude_degrees : kNone);
  }
  placement.pixelsOfLonLat(lines.col, lines.row);
  return lines;
}

void pixelsOfSamples(const Placement& placement, const tiling::Tiling& tiling, const tiling::TileId& id, Kind kind,
                     int cells, std::span<const std::size_t> indices, PixelPlaces& out) {
  const auto side = static_cast<std::size_t>(sideOf(kind, cells));
  out.col.resize(indices.size());
  out.row.resize(indices.size());
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const double s = partOf(kind, cells, static_cast<int>(indices[i] % side));
    const double t = partOf(kind, cells, static_cast<int>(indices[i] / side));
    const tiling::LonLat at = lonLatAt(tiling, id, s, t);
    out.col[i] = at.longitude_degrees;
    out.row[i] = at.latitude_degrees;
  }
  placement.pixelsOfLonLat(out.col, out.row);
}

}  // namespace tellurion::raster
