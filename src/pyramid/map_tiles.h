#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "pyramid/export_samples.h"

namespace tellurion::pyramid {

/// How others cut a map into tiles. Web Mercator (EPSG:3857): one tile at zoom 0, up to 85.05 degrees north and south.
/// Geodetic (EPSG:4326): two tiles of 180 degrees at zoom 0, west and east.
enum class MapScheme : std::uint8_t { mercator, geodetic };

inline constexpr int kMapTilePixels = 256;
inline constexpr int kMostZoom = 24;

/// Column x from the west, row y from the north.
struct MapTile {
  int zoom = 0;
  std::int64_t x = 0;
  std::int64_t y = 0;
};

std::int64_t mapColumns(MapScheme scheme, int zoom);
std::int64_t mapRows(MapScheme scheme, int zoom);
geo::GeoRect rectOf(MapScheme scheme, const MapTile& tile);
/// The centres of a tile's pixels.
PlaceGrid pixelsOf(MapScheme scheme, const MapTile& tile);
/// Degrees between pixels of a zoom, on the equator.
double pixelStep_degrees(MapScheme scheme, int zoom);
/// The coarsest zoom whose pixels are no more than a tenth larger than `spacing_degrees`, kMostZoom at most.
int zoomFor(MapScheme scheme, double spacing_degrees);

/// Which tiles are to be made: those of some zooms that touch what is covered, and a region if there is one.
struct MapExtent {
  MapScheme scheme = MapScheme::mercator;
  int minZoom = 0;
  int maxZoom = 0;
  std::vector<CoveredRect> covered;
  std::optional<geo::GeoRect> region;
};

struct MapStep {
  MapTile tile;
  /// The rectangles of what is covered that it touches: at least one.
  std::shared_ptr<const std::vector<CoveredRect>> covered;
};

/// Tile after tile, depth first, so that neighbours follow each other; memory does not depend on their number.
class MapWalk {
 public:
  explicit MapWalk(const MapExtent& extent);  ///< must outlive it
  std::optional<MapStep> next();

 private:
  const MapExtent& extent_;
  std::vector<MapStep> waiting_;  ///< the rectangles are those that the parent touches
};

/// How many tiles a walk gives; counts no further than `most`, nor than a stop.
std::uint64_t countOf(const MapExtent& extent, std::uint64_t most, const std::stop_token& stop);

}  // namespace tellurion::pyramid
