#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "geo/body.h"
#include "io/failure.h"
#include "raster/image_grid.h"

namespace tellurion::raster {

/// A pixel of the standards' scale denominators.
inline constexpr double kStandardPixel_m = 0.00028;

/// A coordinate reference system as map servers use it.
struct MapReference {
  std::string name;  ///< "EPSG:3857", "CRS:84": one way to write it, whatever the server's
  MapPlane plane;
  bool northFirst = false;     ///< its definition gives y (or latitude) before x
  double metresPerUnit = 1.0;  ///< for the scale denominators of the standards, which measure degrees on WGS 84
  /// Units of the plane in one of the reference: not 1 where a server shows another body in the Earth's EPSG:3857.
  double planePerUnit = 1.0;
};

/// "urn:ogc:def:crs:EPSG:6.18:3:3857", "http://www.opengis.net/def/crs/EPSG/0/3857", "epsg:900913" -> "EPSG:3857";
/// "urn:ogc:def:crs:OGC:1.3:CRS84", "OGC:CRS84" -> "CRS:84". What is not known stays, in capitals.
std::string referenceName(std::string_view crs);

/// The body that references of the IAU are of (IAU_2015:49900: Mars), when all of them that are in the list are of one,
/// and it is known by name (geo::bodyByName); others say nothing of a body.
std::optional<geo::Body> bodyOfReferences(std::span<const std::string> references);

/// What the name of a reference means on a body; PROJ knows all but the commonest. Longitude and latitude are the
/// body's own, whatever body the code was made for. Fails (unsupported) where PROJ does not know it or it has no plane.
io::Result<MapReference> mapReference(std::string_view crs, const geo::Body& body);

}  // namespace tellurion::raster
