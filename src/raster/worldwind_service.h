#pragma once

#include <string>
#include <vector>

#include "raster/service.h"
#include "raster/xml_document.h"

/// Tile servers of NASA World Wind: square tiles in longitude and latitude, rows and columns from the south-west corner
/// of the body.
namespace tellurion::raster {

/// Tiles of `level_zero_degrees` a side at level 0, `tile_pixels` (512) pixels. Either a server that is asked for a
/// data set (the entry's layer, or T in the URL's query): SOURCE?T=dataset&L=level&X=column&Y=row, or a folder, on a
/// server or here: SOURCE/L/RRRR/RRRR_CCCC.ext, ext by the entry's format (png). Without max_level: 9. Pure.
io::Result<GridService> worldWindService(const ServiceLayer& entry, Kind kind, const geo::Body& body);

/// A layer of a configuration, as the entry that means the same.
struct WorldWindLayer {
  std::string title;
  Kind kind = Kind::imagery;
  ServiceLayer entry;  ///< with its type: worldwind or wms
};

/// Whether the root is that of a configuration: World Wind .NET's LayerSet and World, World Wind Java's Layer and
/// ElevationModel.
bool isWorldWindConfiguration(const XmlElement& root);

/// The layers in it that come from a server. What it only names (shapes, place names, files of the program) is not in
/// the list. Fails where none is left.
io::Result<std::vector<WorldWindLayer>> parseWorldWindConfiguration(const XmlElement& root, const std::string& where);

}  // namespace tellurion::raster
