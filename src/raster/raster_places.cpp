#include "raster/raster_places.h"

#include "raster/lattice_filler.h"

namespace tellurion::raster {
namespace {

/// A raster's pixels as a tile sees them: points, or squares with their sides.
class PointPlane {
 public:
  using Places = PixelPlaces;
  static constexpr std::array kColumns{&PixelPlaces::col, &PixelPlaces::row};

  explicit PointPlane(const Placement& placement) : placement_(placement) {}
  void exact(std::span<const geo::Direction> directions, PixelPlaces& out) const { placement_.pixels(directions, out); }
  double turn() const { return placement_.period(); }
  double xTolerance() const { return kRasterPlaceError_pixels; }
  double yTolerance() const { return kRasterPlaceError_pixels; }

 private:
  const Placement& placement_;
};

class SquarePlane {
 public:
  using Places = PixelPlaces;
  static constexpr std::array kColumns{&PixelPlaces::col, &PixelPlaces::row, &PixelPlaces::width, &PixelPlaces::height};

  SquarePlane(const Placement& placement, geo::Angle side) : placement_(placement), side_(side) {}
  void exact(std::span<const geo::Direction> directions, PixelPlaces& out) const {
    placement_.squares(directions, side_, out);
  }
  double turn() const { return placement_.period(); }
  double xTolerance() const { return kRasterPlaceError_pixels; }
  double yTolerance() const { return kRasterPlaceError_pixels; }

 private:
  const Placement& placement_;
  geo::Angle side_;
};

template <class Plane>
PixelPlaces filled(const Plane& plane, const tiling::Tiling& tiling, const tiling::TileId& id, int cells) {
  PixelPlaces places;
  LatticeFiller filler(plane, tiling, id, Kind::imagery, cells);
  filler.fill(places);
  return places;
}

}  // namespace

PixelPlaces tilePixels(const Placement& placement, const tiling::Tiling& tiling, const tiling::TileId& id, int cells,
                       geo::Angle side) {
  PixelPlaces places = side.radians() > 0.0 ? filled(SquarePlane(placement, side), tiling, id, cells)
                                            : filled(PointPlane(placement), tiling, id, cells);
  placement.settle(places);
  return places;
}

}  // namespace tellurion::raster
