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

std::vector<std::size_t> openSamples(const tiling::Tiling& tiling, const tiling::TileId& id, Kind kind, int cells,
                                     const std::vector<bool>& known) {
  const int last = sideOf(kind, cells) - 1;
  std::vector<std::size_t> open;
  std::size_t index = 0;
  for (int row = 0; row <= last; ++row) {
    for (int column = 0; column <= last; ++column, ++index) {
      if (known[index]) continue;
      // Only a corner of the gutter may be nobody's.
      const bool isCorner = (row == 0 || row == last) && (column == 0 || column == last);
      if (!isCorner || placeOf(tiling, id, kind, cells, column, row)) open.push_back(index);
    }
  }
  return open;
}

OpenPlaces openPlaces(const tiling::Tiling& tiling, const tiling::TileId& id, Kind kind, int cells,
                      const std::vector<bool>& known) {
  const int side = sideOf(kind, cells);
  OpenPlaces open{openSamples(tiling, id, kind, cells, known), {}};
  open.places.reserve(open.indices.size());
  for (const std::size_t i : open.indices) {
    const auto index = static_cast<int>(i);
    open.places.push_back(*placeOf(tiling, id, kind, cells, index % side, index / side));
  }
  return open;
}

}  // namespace tellurion::raster
