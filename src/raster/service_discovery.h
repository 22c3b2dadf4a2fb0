#pragma once

#include <string>
#include <variant>
#include <vector>

#include "raster/service.h"
#include "raster/tms_service.h"
#include "raster/wms_capabilities.h"
#include "raster/wmts_capabilities.h"
#include "raster/worldwind_service.h"

namespace tellurion::raster {

/// What is at the other end of an entry's source.
struct FoundService {
  /// wms, wmts, tms, xyz, worldwind
  std::string type;
  std::string source;  ///< URL of the document, or of the tiles
  /// Nothing: tiles need no description.
  std::variant<std::monostate, WmsCapabilities, WmtsCapabilities, TileMap, std::vector<TileMapReference>,
               std::vector<WorldWindLayer>>
      description;
};

/// Asks what the source is. Of the entry only source, type and version count. Without a type it is told from the source
/// (a tile template) or from the document that is there, else the server is asked for the capabilities of each kind,
/// and has 8 seconds for each; where nobody answers, the first is the last.
/// A document may be a file here too, and tilemapresource.xml's folder stands for it. Waits for the network.
io::Result<FoundService> findService(const ServiceLayer& entry, io::Resources& resources);

inline constexpr double kDocumentPatience_s = 60.0;

/// The XML at a URL, file:// or path. Waits for the network.
io::Result<XmlElement> fetchDocument(const std::string& source, io::Resources& resources,
                                     double patience_s = kDocumentPatience_s);

}  // namespace tellurion::raster
