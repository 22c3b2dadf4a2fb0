#pragma once

// Inside the room: the bilinear rules of RasterFile for one place, which both ways of finding places share.

#include <array>
#include <cmath>

#include "raster/colour.h"
#include "raster/pixel_store.h"
#include "raster/raster.h"

namespace tellurion::raster {

/// Written so that NaN is outside.
inline bool isInside(const GridTopology& grid, double col, double row) {
  return col >= 0.0 && col <= grid.width && row >= 0.0 && row <= grid.height;
}

/// Of 0 to 2^31: as std::lround, which is a call into the library, but for the one number below a half.
inline std::uint32_t roundedUnsigned(double v) {
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(v + 0.5));
}

/// The four pixels around a place: the upper left one and the place between their middles, in [0, 1).
struct Between {
  int col;
  int row;
  double s;
  double t;
  /// Index of the nearest of the four; halfway the later one.
  std::size_t nearest() const { return (s >= 0.5 ? 1u : 0u) + (t >= 0.5 ? 2u : 0u); }
  std::array<double, 4> weights() const { return {(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t}; }
};

inline Between between(double col, double row) {
  const double left = std::floor(col - 0.5);
  const double top = std::floor(row - 0.5);
  return {static_cast<int>(left), static_cast<int>(top), (col - 0.5) - left, (row - 0.5) - top};
}

/// Written to `out` only where there is data.
void layHeight(const std::array<float, 4>& corners, const Between& place, float& out);
void layColour(const ColourTables& tables, const std::array<Rgba8, 4>& corners, const Between& place, Rgba8& out);

}  // namespace tellurion::raster
