#pragma once

#include <vector>

#include "geo/body.h"
#include "geo/geo_rect.h"
#include "geo/geodetic.h"

namespace tellurion::raster {

/// Nodes in equal steps of longitude and latitude over a rectangle, in the middles of width x height cells; row 0
/// north. Columns go on around where the rectangle runs around the body.
struct LonLatGrid {
  geo::GeoRect bounds;
  int width = 1;
  int height = 1;

  bool wraps() const;
  geo::Angle latitude(int row) const;
  /// Of a row's nodes, west to east.
  std::vector<geo::Direction> places(int row) const;
  double rowStep_m(const geo::Body& body) const;
  double columnStep_m(const geo::Body& body, int row) const;

  /// Where a place lies among the nodes: the four around it and how far it is from the first, 0..1. Outside the
  /// rectangle: at the nearest nodes.
  struct Spot {
    int col0 = 0;
    int col1 = 0;
    int row0 = 0;
    int row1 = 0;
    double right = 0.0;
    double down = 0.0;
  };
  Spot spotOf(const geo::Direction& place) const;
};

/// The grid over `bounds` whose steps are no wider than `spacing` on the unit sphere, as far as mostNodes a side allow.
LonLatGrid gridOfSpacing(const geo::GeoRect& bounds, geo::Angle spacing, int mostNodes);

}  // namespace tellurion::raster
