#pragma once

#include <cstdint>
#include <stop_token>
#include <string>
#include <vector>

#include "io/failure.h"
#include "raster/lon_lat_grid.h"
#include "raster/raster.h"

namespace tellurion::raster {

/// Which nodes of a grid lie inside the polygons of vector files that GDAL reads (Shapefile, GeoJSON, GeoPackage,
/// FlatGeobuf, KML): 1 inside any, 0 elsewhere. All layers count; lines and points do not. Files without a spatial
/// reference are longitude and latitude in degrees; longitudes are taken modulo 360. Safe on untrusted files as far as
/// GDAL's drivers are. Fails with notFound, unsupported (no such driver, no polygons, coordinates that are no such
/// degrees), corrupt, cancelled.
io::Result<Raster<std::uint8_t>> insidePolygons(const std::vector<std::string>& files, const LonLatGrid& grid,
                                                const std::stop_token& stop = {});

}  // namespace tellurion::raster
