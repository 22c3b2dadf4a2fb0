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

/// Weights that add up to 65536, of a place rounded to 1/256 pixel.
inline std::array<std::uint32_t, 4> wholeWeights(double s, double t) {
  const auto right = roundedUnsigned(s * 256.0);
  const auto lower = roundedUnsigned(t * 256.0);
  return {(256 - right) * (256 - lower), right * (256 - lower), (256 - right) * lower, right * lower};
}

inline Rgba8 opaqueMean(const ColourTables& tables, const std::array<Rgba8, 4>& p, double s, double t) {
  const auto w = wholeWeights(s, t);
  const auto mean = [&](std::uint8_t a, std::uint8_t b, std::uint8_t c, std::uint8_t d) {
    const std::uint32_t sum =
        w[0] * tables.linear[a] + w[1] * tables.linear[b] + w[2] * tables.linear[c] + w[3] * tables.linear[d] + 32768u;
    return tables.srgb[sum >> 16u];
  };
  return {mean(p[0].r, p[1].r, p[2].r, p[3].r), mean(p[0].g, p[1].g, p[2].g, p[3].g),
          mean(p[0].b, p[1].b, p[2].b, p[3].b), 255};
}

/// Where not all of the four are wholly covered.
Rgba8 partlyCoveredMean(const ColourTables& tables, const std::array<Rgba8, 4>& p, const Between& place);

/// Where one of the four has no data: the mean of those that have, if the nearest does.
void layHeightBesideVoid(const std::array<float, 4>& corners, const Between& place, float& out);

/// Written to `out` only where there is data.
inline void layHeight(const std::array<float, 4>& v, const Between& place, float& out) {
  const double top = static_cast<double>(v[0]) * (1.0 - place.s) + static_cast<double>(v[1]) * place.s;
  const double bottom = static_cast<double>(v[2]) * (1.0 - place.s) + static_cast<double>(v[3]) * place.s;
  const double height = top * (1.0 - place.t) + bottom * place.t;
  if (std::isnan(height)) {
    layHeightBesideVoid(v, place, out);
  } else {
    out = static_cast<float>(height);
  }
}
inline void layColour(const ColourTables& tables, const std::array<Rgba8, 4>& p, const Between& place, Rgba8& out) {
  if ((p[0].a & p[1].a & p[2].a & p[3].a) == 255) {
    out = opaqueMean(tables, p, place.s, place.t);
  } else {
    out = over(partlyCoveredMean(tables, p, place), out);
  }
}

}  // namespace tellurion::raster
