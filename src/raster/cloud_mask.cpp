#include "raster/cloud_mask.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace tellurion::raster {
namespace {

constexpr int kReach_nodes = 1;
/// A cloud's darkest channel against its brightest: the sky tints it a little.
constexpr double kWhitish = 0.72;

/// Of what is a cloud, what is enough beside one.
constexpr double kBeside = 0.7;
/// Times the usual difference of the two pictures.
constexpr double kUnusual = 3.0;

bool isWhitish(Rgba8 c) {
  const auto [low, high] = std::minmax({c.r, c.g, c.b});
  return static_cast<double>(low) >= kWhitish * static_cast<double>(high);
}

/// How much brighter than the clear ground, in the darkest channel.
float excessOf(Rgba8 seen, Rgba8 clear) {
  return static_cast<float>(std::min({seen.r, seen.g, seen.b})) -
         static_cast<float>(std::max({clear.r, clear.g, clear.b}));
}

/// What must be exceeded for a cloud. What is usual is told from the middle and the upper quarter: the lower half has
/// no clouds, but the fields of a bright country are all above the middle.
double leastExcess(std::vector<float> excesses) {
  if (excesses.empty()) return kCloudExcess;
  const auto middle = excesses.begin() + static_cast<std::ptrdiff_t>(excesses.size() / 2);
  const auto upper = excesses.begin() + static_cast<std::ptrdiff_t>(excesses.size() * 3 / 4);
  std::ranges::nth_element(excesses, upper);
  std::nth_element(excesses.begin(), middle, upper);
  constexpr double kQuartile = 0.6745;  // of a normal distribution, in standard deviations from its middle
  const double usual = static_cast<double>(*upper - *middle) / kQuartile;
  return std::max(kCloudExcess, static_cast<double>(*middle) + kUnusual * usual);
}

/// Marks what exceeds, and what nearly does and hangs together with it.
Raster<std::uint8_t> grown(const Raster<float>& excess, double cloud) {
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
      mark(col, row, cloud);
  }
  while (!open.empty()) {
    const auto [col, row] = open.back();
    open.pop_back();
    for (int d = 0; d < 9; ++d)
      mark(col + d % 3 - 1, row + d / 3 - 1, kBeside * cloud);
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
  const auto match = matchColours(clear, picture, {grid.bounds}, footprint);
  if (!match) return tl::unexpected(match.error());
  Raster<float> excess(grid.width, grid.height);
  std::vector<float> all;
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
      all.push_back(excessOf(seen[i], expected));
      if (isWhitish(seen[i])) excess.at(static_cast<int>(i), row) = all.back();
    }
  }
  return widened(grown(excess, leastExcess(std::move(all))));
}

}  // namespace tellurion::raster
