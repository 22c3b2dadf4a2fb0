#pragma once

#include <string>

#include "raster/service.h"
#include "raster/wms_capabilities.h"

namespace tellurion::raster {

/// A layer of a WMS (or several, parted by commas) as images of a grid that we lay over it: 512 pixels a side (fewer
/// where the server allows no more), longitude and latitude where the server has them, else EPSG:3857, else what PROJ
/// knows first. Level 0 has images of 180 degrees (or of the whole Mercator square) and every level halves them; it
/// begins and ends where the layer's scale limits and min_level, max_level say, at level 22 at the latest. The grid
/// does not depend on the layer's box, so all users ask for the same images. `source` is where the capabilities come
/// from. Pure. Fails (notFound) on a layer, style, format, reference or time that the server has not, naming what it
/// has.
io::Result<GridService> wmsService(const WmsCapabilities& capabilities, const ServiceLayer& entry, Kind kind,
                                   const geo::Body& body, const std::string& source);

}  // namespace tellurion::raster
