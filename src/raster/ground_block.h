#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "geo/geodetic.h"
#include "raster/point_triangles.h"

namespace tellurion::raster {

/// Flat triangles over a part of a sphere, found by place. Immutable, thread-safe.
class GroundBlock {
 public:
  struct Corner {
    geo::Direction place;
    float height_m = 0.0F;
  };
  /// All corners lie in the plane.
  GroundBlock(const StereographicPlane& plane, std::vector<Corner> corners, std::vector<Triangle> triangles);

  /// Linear over the triangle of the corners' directions that the place's own goes through; exact at corners. NODATA
  /// where none is. So it does not depend on the plane.
  float heightAt(const geo::Direction& place) const;
  std::uint64_t bytes() const;

 private:
  StereographicPlane::Box boxOf(const Triangle& triangle) const;
  int columnOf(double x) const;
  int rowOf(double y) const;
  template <class Visit>
  void forAllBins(const Visit& visit) const;

  StereographicPlane plane_;
  std::vector<Corner> corners_;
  std::vector<Triangle> triangles_;
  StereographicPlane::Box whole_{};
  std::vector<std::uint32_t> starts_;
  std::vector<std::uint32_t> inBins_;
};

}  // namespace tellurion::raster
