#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "raster/service.h"
#include "raster/xml_document.h"

/// The Tile Map Service of OSGeo: tilemapresource.xml, rows from the south.
namespace tellurion::raster {

struct TmsLevel {
  std::string href;  ///< folder of the level; may be relative
  double unitsPerPixel = 0.0;
  int order = 0;
};

/// A <TileMap>.
struct TileMap {
  std::string title;
  std::string abstract;
  std::string crs;
  std::optional<std::array<double, 4>> box;  ///< minx, miny, maxx, maxy, as written
  std::array<double, 2> origin{};            ///< lower left corner of tile (0, 0)
  int tileWidth = 256;
  int tileHeight = 256;
  std::string format;  ///< MIME type
  std::string extension;
  std::vector<TmsLevel> levels;  ///< coarsest first
};

/// One that a <TileMapService> lists.
struct TileMapReference {
  std::string title;
  std::string crs;
  std::string href;
};

/// Fails where the root is no <TileMap> or has no usable level.
io::Result<TileMap> parseTileMap(const XmlElement& root, const std::string& where);

/// Empty: the root is no <TileMapService>, or it lists none. Fails on more than 20,000.
io::Result<std::vector<TileMapReference>> parseTileMapService(const XmlElement& root, const std::string& where);

/// `source` is where the document comes from. Levels are numbered by their order for min_level and max_level. Pure.
io::Result<GridService> tmsService(const TileMap& map, const ServiceLayer& entry, Kind kind, const geo::Body& body,
                                   const std::string& source);

}  // namespace tellurion::raster
