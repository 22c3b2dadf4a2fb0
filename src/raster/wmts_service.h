#pragma once

#include <string>

#include "raster/service.h"
#include "raster/wmts_capabilities.h"

namespace tellurion::raster {

/// A layer of a WMTS in one of its tile matrix sets: the entry's, else one in longitude and latitude, else EPSG:3857,
/// else the first that PROJ knows. Tiles come by the layer's URL template where there is one for the format, else by
/// key-value requests. Levels are the matrices, coarsest first, those of the entry's min_level to max_level counted
/// from 0. `source` is where the capabilities come from. Pure. Fails (notFound) on a layer, style, format, matrix set
/// or time that the server has not, naming what it has.
io::Result<GridService> wmtsService(const WmtsCapabilities& capabilities, const ServiceLayer& entry, Kind kind,
                                    const geo::Body& body, const std::string& source);

}  // namespace tellurion::raster
