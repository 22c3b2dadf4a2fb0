#pragma once

#include <string>
#include <string_view>

#include "raster/service.h"

namespace tellurion::raster {

/// Whether a text is a URL or path with places for a tile's level, column and row.
bool isTileTemplate(std::string_view source);

/// Fails where a place's name is not known, or one is missing.
io::Result<void> checkTileTemplate(const std::string& source);

/// Tiles by a template in EPSG:3857 (level 0 is one tile) or EPSG:4326 (two tiles side by side), rows from the north:
/// {z} level, {x} column, {y} row, {-y} row from the south, {q} the quadkey instead of the three, {s} or {s:abc} one of
/// several servers. Also {level} {col} {row} and {TileMatrix} {TileCol} {TileRow}. A path or file:// reads local files.
/// Without max_level: 19. Pure.
io::Result<GridService> xyzService(const ServiceLayer& entry, Kind kind, const geo::Body& body);

}  // namespace tellurion::raster
