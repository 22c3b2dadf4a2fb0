#include "raster/reduce.h"

#include <algorithm>
#include <array>

#include "raster/colour.h"

namespace tellurion::raster {
namespace {

Rgba8 meanOfFour(const ColourTables& tables, const std::array<Rgba8, 4>& pixels) {
  std::uint32_t coverage = 0;
  std::array<std::uint64_t, 3> light{};
  for (const Rgba8& p : pixels) {
    coverage += p.a;
    light[0] += std::uint64_t{p.a} * tables.linear[p.r];
    light[1] += std::uint64_t{p.a} * tables.linear[p.g];
    light[2] += std::uint64_t{p.a} * tables.linear[p.b];
  }
  if (coverage == 0) return {};
  const auto encoded = [&](std::uint64_t sum) { return tables.srgb[(sum + coverage / 2) / coverage]; };
  // Something is covered, so the mean is not rounded down to "no data".
  const auto alpha = static_cast<std::uint8_t>(std::max<std::uint32_t>(1, (coverage + 2) / 4));
  return {encoded(light[0]), encoded(light[1]), encoded(light[2]), alpha};
}

}  // namespace

Raster<Rgba8> halved(const Raster<Rgba8>& image) {
  if (image.width == 0 || image.height == 0) return {};
  const ColourTables tables = colourTables();
  Raster<Rgba8> half(std::max(1, image.width / 2), std::max(1, image.height / 2));
  for (int row = 0; row < half.height; ++row) {
    const int top = 2 * row;
    const int bottom = std::min(top + 1, image.height - 1);
    for (int col = 0; col < half.width; ++col) {
      const int left = 2 * col;
      const int right = std::min(left + 1, image.width - 1);
      half.at(col, row) = meanOfFour(
          tables, {image.at(left, top), image.at(right, top), image.at(left, bottom), image.at(right, bottom)});
    }
  }
  return half;
}

}  // namespace tellurion::raster
