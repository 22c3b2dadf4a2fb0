#pragma once

#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace tellurion::raster {

/// A rectangle of values, row-major, row 0 on top.
template <class T>
struct Raster {
  int width = 0;
  int height = 0;
  std::vector<T> samples;

  Raster() = default;
  Raster(int w, int h, T fill = T{})
      : width(w), height(h), samples(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), fill) {}

  T& at(int col, int row) { return samples[index(col, row)]; }
  const T& at(int col, int row) const { return samples[index(col, row)]; }
  std::span<const T> row(int r) const { return {samples.data() + index(0, r), static_cast<std::size_t>(width)}; }

 private:
  std::size_t index(int col, int row) const {
    assert(col >= 0 && col < width && row >= 0 && row < height);
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(col);
  }
};

/// Elevation: metres, NaN where there is no data. NODATA is never zero and never blended into real values.
inline constexpr float kNoData = std::numeric_limits<float>::quiet_NaN();
inline bool isNoData(float v) {
  return std::isnan(v);
}

/// Imagery: sRGB colour, not premultiplied; a is the coverage, 0 where there is no data.
struct Rgba8 {
  std::uint8_t r = 0;
  std::uint8_t g = 0;
  std::uint8_t b = 0;
  std::uint8_t a = 0;

  friend bool operator==(const Rgba8&, const Rgba8&) = default;
};

}  // namespace tellurion::raster
