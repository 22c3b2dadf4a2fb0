#include "raster/tile_places.h"

namespace tellurion::raster {

int sideOf(Kind kind, int cells) {
  return cells + (kind == Kind::elevation ? 1 : 0) + 2 * kGutter;
}

std::optional<geo::Direction> placeOf(const tiling::Tiling& tiling, const tiling::TileId& id, Kind kind, int cells,
                                      int column, int row) {
  const double shift = kind == Kind::elevation ? 1.0 : 0.5;
  const double s = (column - shift) / cells;
  const double t = (row - shift) / cells;
  const auto point = tiling.wrapped(tiling::rootPointIn(id, s, t));
  if (!point) return std::nullopt;
  return tiling.direction(*point);
}

OpenPlaces openPlaces(const tiling::Tiling& tiling, const tiling::TileId& id, Kind kind, int cells,
                      const std::vector<bool>& known) {
  const int side = sideOf(kind, cells);
  OpenPlaces open;
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      const auto index = static_cast<std::size_t>(row * side + column);
      if (known[index]) continue;
      const auto place = placeOf(tiling, id, kind, cells, column, row);
      if (!place) continue;
      open.indices.push_back(index);
      open.places.push_back(*place);
    }
  }
  return open;
}

}  // namespace tellurion::raster
