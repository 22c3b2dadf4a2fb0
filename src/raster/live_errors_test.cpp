// The errors that live tiles of a raster state, against the finest samples that it has.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "raster/live_raster.h"

namespace tellurion::raster {
namespace {

constexpr int kCells = kElevationCells;
constexpr int kLevelsUp = 2;

/// Height of the tile's surface, bilinear, at a place in cells.
double surfaceAt(const Raster<float>& samples, double x, double y) {
  const int col = std::min(static_cast<int>(x), kCells - 1);
  const int row = std::min(static_cast<int>(y), kCells - 1);
  const double s = x - col, t = y - row;
  const auto at = [&](int dc, int dr) { return static_cast<double>(samples.at(col + dc + 1, row + dr + 1)); };
  return (at(0, 0) * (1 - s) + at(1, 0) * s) * (1 - t) + (at(0, 1) * (1 - s) + at(1, 1) * s) * t;
}

const Raster<float>& samplesOf(const SourceTile& tile) {
  return std::get<ElevationTile>(tile.payload).samples;
}

class LiveErrors : public testing::TestWithParam<tiling::Scheme> {
 protected:
  /// Of every tile on the two levels over the deepest: the largest distance to samples of the deepest, a share of the
  /// error that is stated.
  static std::vector<double> sharesOf(const std::string& path) {
    const auto source = liveRaster(path, Kind::elevation, GetParam()).value();
    const tiling::Tiling tiling(GetParam());
    std::vector<double> shares;
    std::vector<tiling::TileId> level;
    for (int root = 0; root < tiling.rootCount(); ++root)
      level.push_back({.level = 0, .root = static_cast<std::uint8_t>(root), .x = 0, .y = 0});
    const auto deepest = static_cast<std::uint8_t>(source->info().maxLevel);
    for (std::uint8_t l = 0; l < deepest; ++l) {
      std::vector<tiling::TileId> below;
      for (const tiling::TileId& id : level) {
        const TilePresence presence = *source->presence(id);
        if (l + kLevelsUp >= deepest) addShare(*source, id, deepest, shares);
        for (int q = 0; q < 4; ++q)
          if (((presence.childMask >> q) & 1) != 0) below.push_back(id.child(q));
      }
      level = std::move(below);
    }
    std::ranges::sort(shares);
    return shares;
  }

  static void addShare(const TileSource& source, const tiling::TileId& id, std::uint8_t deepest,
                       std::vector<double>& shares) {
    const auto tile = source.load(id).value();
    const std::uint32_t across = 1u << static_cast<unsigned>(deepest - id.level);
    double worst = -1.0;
    for (std::uint32_t i = 0; tile && i < across * across; ++i) {
      const std::uint32_t column = i % across, row = i / across;
      const tiling::TileId below{
          .level = deepest, .root = id.root, .x = id.x * across + column, .y = id.y * across + row};
      const auto fine = source.load(below).value();
      if (fine) worst = std::max(worst, worstOf(samplesOf(*tile), samplesOf(*fine), column, row, across));
    }
    if (worst >= 0.0) shares.push_back(worst / static_cast<double>(tile->statistics.error_m));
  }

  static double worstOf(const Raster<float>& coarse, const Raster<float>& fine, std::uint32_t column, std::uint32_t row,
                        std::uint32_t across) {
    double worst = -1.0;
    for (int y = 0; y <= kCells; ++y) {
      for (int x = 0; x <= kCells; ++x) {
        const double there =
            surfaceAt(coarse, (column * kCells + static_cast<std::uint32_t>(x)) / static_cast<double>(across),
                      (row * kCells + static_cast<std::uint32_t>(y)) / static_cast<double>(across));
        const double off = std::abs(there - static_cast<double>(fine.at(x + 1, y + 1)));
        if (off > worst) worst = off;  // never true of NaN
      }
    }
    return worst;
  }
};

TEST_P(LiveErrors, AreBoundsAlmostEverywhere) {
  for (const char* name : {"srtm3_alps_N46E008.tif", "santabarbara_dem_3m.tif"}) {
    const std::string path = std::string(TELLURION_SHARED_DATA_DIR "/earth/") + name;
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no data beside the project";
    const std::vector<double> shares = sharesOf(path);
    ASSERT_GT(shares.size(), 10u) << name;
    const auto within = static_cast<std::size_t>(std::ranges::upper_bound(shares, 1.001) - shares.begin());
    EXPECT_GT(20 * within, 19 * shares.size()) << name << ": 19 of 20";
    EXPECT_LT(shares.back(), 2.0) << name;
    EXPECT_GT(shares[shares.size() / 2], 0.5) << name << ": stated twice as large as it is";
    std::printf("%s: %zu tiles, error of the stated: median %.2f, most %.2f; within it %.1f%%\n", name, shares.size(),
                shares[shares.size() / 2], shares.back(),
                100.0 * static_cast<double>(within) / static_cast<double>(shares.size()));
  }
}

INSTANTIATE_TEST_SUITE_P(Tilings, LiveErrors,
                         testing::Values(tiling::Scheme::geographic, tiling::Scheme::cube, tiling::Scheme::healpix),
                         [](const auto& test) { return std::string(tiling::nameOf(test.param)); });

}  // namespace
}  // namespace tellurion::raster
