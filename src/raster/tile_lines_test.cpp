// Samples along meridians and parallels against the same through directions, and against each other where tiles meet.
#include "raster/tile_lines.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <random>
#include <tuple>

#include "raster/raster_fixture_test.h"
#include "raster/tile_places.h"

namespace tellurion::raster::testing {
namespace {

constexpr int kCells = 16;

/// All of the Earth, 1.5 degrees a pixel, noise, with some voids.
void makeEarth(const std::string& path, int bands) {
  makeRaster(path, {.width = 240,
                    .height = 120,
                    .type = bands == 1 ? GDT_Int16 : GDT_Byte,
                    .bands = bands,
                    .transform = {-180, 1.5, 0, 90, 0, -1.5},
                    .value =
                        [](int band, int col, int row) {
                          const auto noise = static_cast<unsigned>(col * 7919 + row * 104729 + band * 31) * 2654435761u;
                          return noise % 97 == 0 ? 255.0 : static_cast<double>((noise >> 16u) % 200);
                        },
                    .tune =
                        [](GDALDataset& data) {
                          for (int b = 1; b <= data.GetRasterCount(); ++b)
                            data.GetRasterBand(b)->SetNoDataValue(255.0);
                        }});
}

std::vector<tiling::TileId> someTiles(std::mt19937& random) {
  std::vector<tiling::TileId> tiles;
  for (std::uint8_t root = 0; root < 6; ++root) {
    tiles.push_back({0, root, 0, 0});
    for (int i = 0; i < 12; ++i)
      tiles.push_back(
          {4, root, static_cast<std::uint32_t>(random() % 16u), static_cast<std::uint32_t>(random() % 16u)});
  }
  return tiles;
}

std::vector<std::size_t> ownedSamples(const tiling::Tiling& tiling, const tiling::TileId& id, Kind kind) {
  const auto side = static_cast<std::size_t>(sideOf(kind, kCells));
  return openSamples(tiling, id, kind, kCells, std::vector<bool>(side * side, false));
}

TEST(TileLines, HeightsAreThoseOfDirections) {
  const ScratchFolder folder;
  makeEarth(folder.file("earth.tif"), 1);
  RasterFile file = openOrDie(folder.file("earth.tif"), Kind::elevation);
  const tiling::Tiling tiling(tiling::Scheme::geographic);
  std::mt19937 random(5);
  for (const tiling::TileId& id : someTiles(random)) {
    const OpenPlaces all =
        openPlaces(tiling, id, Kind::elevation, kCells, std::vector<bool>(std::size_t{19} * 19, false));
    std::vector<float> byLines(all.indices.size(), kNoData);
    std::vector<float> byDirections(all.indices.size(), kNoData);
    ASSERT_TRUE(file.sampleTile(tiling, id, kCells, all.indices, {}, byLines));
    ASSERT_TRUE(file.sampleHeights(all.places, {}, byDirections));
    for (std::size_t i = 0; i < byLines.size(); ++i) {
      // Beside a void one of the two may just not reach it.
      if (isNoData(byLines[i]) || isNoData(byDirections[i])) continue;
      EXPECT_NEAR(byLines[i], byDirections[i], 1e-3) << "sample " << all.indices[i] << " of root " << int{id.root};
    }
    const auto voids = [](const std::vector<float>& v) { return std::ranges::count_if(v, isNoData); };
    EXPECT_NEAR(static_cast<double>(voids(byLines)), static_cast<double>(voids(byDirections)), 2.0);
  }
}

// Neighbours' shared samples and gutters have the same bits, across the borders of roots and caps too.
TEST(TileLines, APlaceHasOneHeight) {
  const ScratchFolder folder;
  makeEarth(folder.file("earth.tif"), 1);
  RasterFile file = openOrDie(folder.file("earth.tif"), Kind::elevation);
  const tiling::Tiling tiling(tiling::Scheme::geographic);
  struct Less {
    bool operator()(const geo::Vec3& a, const geo::Vec3& b) const {
      return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
    }
  };
  std::map<geo::Vec3, float, Less> heights;
  std::size_t met = 0;
  for (std::uint8_t root = 0; root < 6; ++root) {
    for (std::uint32_t i = 0; i < 16; ++i) {
      const tiling::TileId id{2, root, i % 4, i / 4};
      const OpenPlaces all =
          openPlaces(tiling, id, Kind::elevation, kCells, std::vector<bool>(std::size_t{19} * 19, false));
      std::vector<float> values(all.indices.size(), kNoData);
      ASSERT_TRUE(file.sampleTile(tiling, id, kCells, all.indices, {}, values));
      for (std::size_t k = 0; k < values.size(); ++k) {
        const auto [at, isNew] = heights.emplace(all.places[k].n, values[k]);
        if (isNew) continue;
        ++met;
        EXPECT_EQ(std::bit_cast<std::uint32_t>(at->second), std::bit_cast<std::uint32_t>(values[k]));
      }
    }
  }
  EXPECT_GT(met, 5000u);
}

TEST(TileLines, ColoursAreThoseOfDirections) {
  const ScratchFolder folder;
  makeEarth(folder.file("earth.tif"), 3);
  RasterFile file = openOrDie(folder.file("earth.tif"), Kind::imagery);
  const tiling::Tiling tiling(tiling::Scheme::geographic);
  std::mt19937 random(7);
  for (const tiling::TileId& id : someTiles(random)) {
    const std::vector<std::size_t> indices = ownedSamples(tiling, id, Kind::imagery);
    std::vector<geo::Direction> places;
    for (const std::size_t i : indices)
      places.push_back(*placeOf(tiling, id, Kind::imagery, kCells, static_cast<int>(i % 18), static_cast<int>(i / 18)));
    std::vector<Rgba8> byLines(indices.size());
    std::vector<Rgba8> byDirections(indices.size());
    ASSERT_TRUE(file.sampleTile(tiling, id, kCells, indices, {}, byLines));
    ASSERT_TRUE(file.sampleColours(places, {}, byDirections));
    if (!isOfLines(id)) continue;  // within 1/256 of a pixel: raster_places_test
    for (std::size_t i = 0; i < indices.size(); ++i) {
      // A place just between two weights of 1/256 may take either.
      EXPECT_NEAR(byLines[i].r, byDirections[i].r, 3) << "sample " << indices[i];
      EXPECT_NEAR(byLines[i].b, byDirections[i].b, 3);
      EXPECT_EQ(byLines[i].a, byDirections[i].a);
    }
  }
}

}  // namespace
}  // namespace tellurion::raster::testing
