#pragma once

#include <array>
#include <optional>
#include <string>

#include "raster/image_grid.h"

namespace tellurion::raster {

/// A layer on a server as a scene file names it (docs/scene-file.md). Empty means: as the server says, or the usual.
struct ServiceLayer {
  std::string source;  ///< URL; of XYZ and REST templates with {x} {y} {z}, {-y}, {s}, ...
  std::string type;    ///< wms, wmts, tms, xyz, worldwind; empty: told from the source
  std::string layer;
  std::string style;
  std::string format;     ///< MIME type
  std::string crs;        ///< EPSG:4326, EPSG:3857, CRS:84, ...
  std::string version;    ///< 1.1.1, 1.3.0
  std::string time;       ///< ISO 8601
  std::string matrixSet;  ///< WMTS
  std::string encoding;   ///< elevation: band, terrarium, mapbox, centimetre
  std::string byteOrder;  ///< of raw heights (BIL): little, big
  std::string attribution;
  std::optional<double> scale, offset_m, nodata;        ///< elevation
  std::optional<double> levelZero_degrees;              ///< World Wind: side of a tile of level 0
  std::optional<int> tilePixels, minLevel, maxLevel;    ///< maxLevel: as the source counts them
  std::optional<std::array<double, 4>> bounds_degrees;  ///< west, south, east, north
};

/// What a scene's entry means, the server asked for its capabilities where that is needed. Waits for the network; for a
/// thread of its own. Failures say what the server offers instead.
io::Result<GridService> openService(const ServiceLayer& layer, Kind kind, const geo::Body& body,
                                    io::Resources& resources);

/// So long openHeights() waits for a map of everything.
inline constexpr double kOverviewPatience_s = 20.0;

/// The same of elevation that is to be read: without GridService::overviews where the server refuses the first of them,
/// or does not bring it in `patience_s` seconds, since the heights of all roots are read on it. The image is found in
/// the cache then.
io::Result<GridService> openHeights(const ServiceLayer& layer, const geo::Body& body, io::Resources& resources,
                                    double patience_s = kOverviewPatience_s);

}  // namespace tellurion::raster
