#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geo/geodetic.h"

namespace tellurion::raster {

/// The stereographic plane that touches the unit sphere at a centre, in units of so many radians: circles of the sphere
/// are circles in it.
class StereographicPlane {
 public:
  struct Place {
    double x;  ///< to the right as seen from outside
    double y;
  };
  StereographicPlane(const geo::Direction& centre, double unit);
  /// Beyond, what is near the centre's antipode is too far away.
  bool holds(const geo::Direction& place) const;
  Place at(const geo::Direction& place) const;

  struct Box {
    double minX, minY, maxX, maxY;
    bool meets(const Box& o) const { return minX <= o.maxX && o.minX <= maxX && minY <= o.maxY && o.minY <= maxY; }
  };
  /// Holds the polygon of these corners, whose sides are great circles: in the plane, arcs of radius 2 radians or more.
  Box boxAround(std::span<const geo::Direction> corners) const;

 private:
  geo::Vec3 centre_;
  geo::Vec3 east_;
  geo::Vec3 north_;
  double unit_;
};

using Triangle = std::array<std::uint32_t, 3>;  ///< indices of corners, counterclockwise as seen from outside

/// The Delaunay triangles of places on the sphere (those whose circles hold no other place), by qhull, through GDAL, in
/// a plane that holds them all. Empty where they lie on a line or are fewer than three.
///
/// Four places of one circle, as the corners of a grid's cells are, have two ways to be cut: it is the one from the
/// place with the lowest index of the four, whichever qhull takes. So a triangle depends on the places around it, their
/// order and nothing else: not on the plane, and not on places farther away than its circle is wide.
std::vector<Triangle> delaunayTriangles(std::span<const geo::Direction> places, const StereographicPlane& plane);

}  // namespace tellurion::raster
