#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "geo/body.h"
#include "geo/geo_rect.h"
#include "raster/image_grid.h"

/// Grids whose spacing halves from level to level, and what of a grid lies inside a box.
namespace tellurion::raster {

/// In units of a plane.
struct PlaneBox {
  double left = 0.0, bottom = 0.0, right = 0.0, top = 0.0;
};

/// The box of a plane around a rectangle of longitude and latitude. Across the date line it has the plane's full width.
/// `other` planes: edges and middle are projected. Nothing: the rectangle is nowhere in the plane.
std::optional<PlaneBox> planeBox(const MapPlane& plane, const geo::GeoRect& rect, const geo::Body& body);

/// The square images that a plane is cut into at level 0, and all levels below by halving. lonLat: two of 180 degrees
/// side by side; webMercator: one of the whole square; other: squares whose side is the power of two of the plane's
/// unit that holds `box`, with corners at multiples of it, so that every user of a plane cuts it along the same lines.
struct DoublingGrid {
  double left = 0.0, top = 0.0;
  double side = 0.0;  ///< of an image of level 0
  std::int64_t columns = 1, rows = 1;
};
DoublingGrid doublingGrid(const MapPlane& plane, const PlaneBox& box, const geo::Body& body);

GridLevel levelOf(const DoublingGrid& grid, int level, int imagePixels);

/// Levels coarser than level 0 of a grid of lonLat or webMercator, coarsest first: each one image of the whole plane,
/// whose pixels double until a turn has no more than 256 of them. Empty: of other planes, and where the images do not
/// halve.
std::vector<GridLevel> overviewLevels(const MapPlane& plane, const DoublingGrid& grid, int imagePixels);

/// Narrows first and end of columns and rows to the images that touch the box. False: none is left.
bool limitTo(const PlaneBox& box, GridLevel& level);

}  // namespace tellurion::raster
