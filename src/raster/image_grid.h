#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "geo/body.h"
#include "geo/geo_rect.h"
#include "io/resources.h"
#include "raster/tile.h"
#include "raster/time_extent.h"

namespace tellurion::raster {

/// The plane that images lie in.
struct MapPlane {
  enum class Kind : std::uint8_t {
    lonLat,       ///< x, y: longitude and latitude in degrees, of the body
    webMercator,  ///< EPSG:3857 and its like on other bodies: spherical formulas on the semi-major axis, metres
    other,        ///< as `definition` says
  };
  Kind kind = Kind::lonLat;
  std::string definition;  ///< of `other`: "EPSG:3031", WKT or whatever else PROJ takes; x east or right, y north or up
};

/// One resolution: images of one size in columns (from the left) and rows (from the top).
struct GridLevel {
  double left = 0.0;         ///< x of the outer left corner of image (0, 0), units of the plane
  double top = 0.0;          ///< y of its outer upper corner
  double pixelWidth = 0.0;   ///< units of the plane, > 0
  double pixelHeight = 0.0;  ///< likewise, > 0
  int imageWidth = 256;      ///< pixels
  int imageHeight = 256;
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  /// Of those, the ones that may exist: first <= i < end.
  std::int64_t firstColumn = 0, endColumn = 0;
  std::int64_t firstRow = 0, endRow = 0;
};

struct GridImageId {
  int level = 0;
  std::int64_t column = 0;
  std::int64_t row = 0;
  friend bool operator==(const GridImageId&, const GridImageId&) = default;
};

/// How heights stand in an image.
struct HeightEncoding {
  enum class Kind : std::uint8_t {
    band,          ///< one band of numbers (16-bit PNG, TIFF, BIL): value * scale + offset
    terrarium,     ///< (R * 256 + G + B / 256) - 32768
    mapboxRgb,     ///< -10000 + (R * 65536 + G * 256 + B) * 0.1
    centimetreRgb  ///< 24 bits c = round((h + 1000) * 100) * 16
  };
  Kind kind = Kind::band;
  double scale = 1.0;
  double offset_m = 0.0;
  std::optional<double> nodata;  ///< as stored
  bool bigEndian = false;        ///< of raw BIL
};

/// A layer of a server that gives images by row and column, or of which such can be asked: plain data, whatever the
/// protocol.
struct GridService {
  std::string name;  ///< for messages and the cache: server, layer, style, time
  Kind kind = Kind::imagery;
  geo::Body body = geo::earth();
  MapPlane plane;
  std::vector<GridLevel> levels;  ///< coarsest first, never empty
  /// So many of the first levels are maps of everything that the server does not offer by itself: it may refuse them
  /// though it has the others.
  std::size_t overviews = 0;
  geo::GeoRect bounds = geo::GeoRect::whole();
  HeightEncoding heights;
  std::optional<Rgba8> transparentColour;  ///< pixels of it are not covered
  std::string attribution;
  std::vector<TimeSpan> times;  ///< that the layer has, whichever of them these images are of; empty: none
  /// The request for an image; thread-safe, pure.
  std::function<io::ResourceRequest(const GridImageId&)> request;
};

}  // namespace tellurion::raster
