#include "raster/cloud_mask.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace tellurion::raster {
namespace {

constexpr int kReach_nodes = 2;
/// A cloud's darkest channel against its brightest: the sky tints it a little.
constexpr double kWhitish = 0.72;

/// How much brighter than the clear ground, in the darkest channel; 0 where it is too colourful for a cloud.
double excessOf(Rgba8 seen, Rgba8 clear) {
  const auto [low, high] = std::minmax({seen.r, seen.g, seen.b});
  if (static_cast<double>(low) < kWhitish * static_cast<double>(high)) return 0.0;
  return static_cast<double>(low) - static_cast<double>(std::max({clear.r, clear.g, clear.b}));
}

/// Marks what is at least half a cloud and hangs together with a whole one.
Raster<std::uint8_t> grown(const Raster<float>& excess) {
  Raster<std::uint8_t> clouds(excess.width, excess.height);
  std::vector<std::pair<int, int>> open;
  const auto mark = [&](int col, int row, double least) {
    if (col < 0 || row < 0 || col >= excess.width || row >= excess.height) return;
    if (clouds.at(col, row) != 0 || !(static_cast<double>(excess.at(col, row)) > least)) return;
    clouds.at(col, row) = 1;
    open.emplace_back(col, row);
  };
  for (int row = 0; row < excess.height; ++row) {
    for (int col = 0; col < excess.width; ++col)
      mark(col, row, kCloudExcess);
  }
  while (!open.empty()) {
    const auto [col, row] = open.back();
    open.pop_back();
    for (int d = 0; d < 9; ++d)
      mark(col + d % 3 - 1, row + d / 3 - 1, 0.5 * kCloudExcess);
  }
  return clouds;
}

Raster<std::uint8_t> widened(const Raster<std::uint8_t>& marked) {
  Raster<std::uint8_t> wide = marked;
  for (int row = 0; row < marked.height; ++row) {
    for (int col = 0; col < marked.width; ++col) {
      if (marked.at(col, row) == 0) continue;
      for (int r = std::max(row - kReach_nodes, 0); r <= std::min(row + kReach_nodes, marked.height - 1); ++r) {
        for (int c = std::max(col - kReach_nodes, 0); c <= std::min(col + kReach_nodes, marked.width - 1); ++c)
          wide.at(c, r) = 1;
      }
    }
  }
  return wide;
}

}  // namespace

io::Result<Raster<std::uint8_t>> findClouds(const ColourSampler& picture, const ColourSampler& clear,
                                            const LonLatGrid& grid) {
  const geo::Angle footprint = (grid.bounds.north - grid.bounds.south) / grid.height;
  const auto match = matchColours(clear, picture, grid.bounds, footprint);
  if (!match) return tl::unexpected(match.error());
  Raster<float> excess(grid.width, grid.height);
  std::vector<Rgba8> seen;
  std::vector<Rgba8> below;
  for (int row = 0; row < grid.height; ++row) {
    const auto places = grid.places(row);
    seen.assign(places.size(), {});
    below.assign(places.size(), {});
    if (auto ok = picture(places, footprint, seen); !ok) return tl::unexpected(ok.error());
    if (auto ok = clear(places, footprint, below); !ok) return tl::unexpected(ok.error());
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (seen[i].a == 0 || below[i].a == 0) continue;
      const Rgba8 expected = *match ? (*match)->apply(places[i], below[i]) : below[i];
      excess.at(static_cast<int>(i), row) = static_cast<float>(excessOf(seen[i], expected));
    }
  }
  return widened(grown(excess));
}

}  // namespace tellurion::raster
