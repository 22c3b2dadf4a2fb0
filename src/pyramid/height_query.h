#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include "geo/geodetic.h"
#include "raster/tile_source.h"

namespace tellurion::pyramid {

struct HeightAnswer {
  double height_m = 0.0;  ///< metres above the ellipsoid (or above what the source's heights are above)
  geo::Vec3 normal_enu;   ///< unit normal of the bilinear surface there: east, north, up; the body's curvature included
  int level = 0;          ///< of the tile that answered
};

/// Heights of a place from the finest tile that holds it. The surface is bilinear between a tile's samples; where the
/// nearest of the four samples (of several equally near ones any) is NODATA there is no height, else the weights are
/// shared among those that have data. One thread only (it keeps the tiles it used last).
class HeightQuery {
 public:
  /// `source` must hold elevation. Keeps at most `cachedTiles` decoded tiles (about 20 kB each).
  static io::Result<HeightQuery> create(std::shared_ptr<const raster::TileSource> source,
                                        std::size_t cachedTiles = 4096);
  ~HeightQuery();
  HeightQuery(HeightQuery&&) noexcept;
  HeightQuery& operator=(HeightQuery&&) noexcept;

  /// `level`: no deeper than this. Nothing where there is no data. Fails on what load() fails on.
  io::Result<std::optional<HeightAnswer>> at(const geo::Direction& place, std::optional<int> level = {});

 private:
  struct State;
  explicit HeightQuery(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tellurion::pyramid
