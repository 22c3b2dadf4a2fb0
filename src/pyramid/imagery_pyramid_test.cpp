#include <gtest/gtest.h>

#include <cmath>

#include "pyramid/synthetic_rasters_test.h"
#include "pyramid/verify.h"
#include "raster/codec.h"

namespace tellurion::pyramid::testing {
namespace {

using raster::kGutter;
using raster::Rgba8;
using tiling::Edge;
using tiling::Scheme;
using tiling::TileId;

constexpr int kSize = raster::kImageryPixels;

/// A smooth colour of each place.
Rgba8 colourAt(double lat, double lon) {
  const geo::Vec3 n = geo::directionFromDegrees(lat, lon).n;
  const auto byte = [](double v) { return static_cast<std::uint8_t>(std::lround(128.0 + 100.0 * v)); };
  return {byte(std::sin(4 * n.x)), byte(n.y), byte(std::cos(5 * n.z)), 255};
}

void expectNear(Rgba8 a, Rgba8 b, int tolerance, const std::string& what) {
  EXPECT_NEAR(int{a.r}, int{b.r}, tolerance) << what;
  EXPECT_NEAR(int{a.g}, int{b.g}, tolerance) << what;
  EXPECT_NEAR(int{a.b}, int{b.b}, tolerance) << what;
  EXPECT_EQ(int{a.a}, int{b.a}) << what;
}

Rgba8 pixelAtEdge(const raster::Raster<Rgba8>& tile, Edge edge, int along, int depth) {
  const int near = kGutter + depth;
  const int far = kGutter + kSize - 1 - depth;
  const int place = kGutter + along;
  switch (edge) {
    case Edge::top:
      return tile.at(place, near);
    case Edge::right:
      return tile.at(far, place);
    case Edge::bottom:
      return tile.at(place, far);
    case Edge::left:
      return tile.at(near, place);
  }
  return {};
}

class ImageryPyramid : public ::testing::TestWithParam<Scheme> {
 protected:
  BuildOptions options(const std::string& input) const {
    BuildOptions options;
    options.output = folder_ / "out.tdb";
    options.inputs = {input};
    options.scheme = GetParam();
    options.kind = raster::Kind::imagery;
    return options;
  }
  std::string globe() const {
    constexpr double kPixel = 360.0 / 2048;
    writeColour(folder_ / "globe.tif", degreesGrid(-180, -90, 180, 90, 2048, 1024),
                [](int c, int r) { return colourAt(90.0 - kPixel * (r + 0.5), -180.0 + kPixel * (c + 0.5)); });
    return (folder_ / "globe.tif").string();
  }
  void expectSound() const {
    const auto report = verifyPyramid(folder_ / "out.tdb");
    ASSERT_TRUE(report.has_value()) << io::describe(report.error());
    EXPECT_TRUE(report->sound()) << report->faults.front();
  }
  TemporaryFolder folder_;
};

TEST_P(ImageryPyramid, ColoursAreTheSourcesOnEveryLevel) {
  const auto reader = builtPyramid(options(globe()));
  ASSERT_NE(reader, nullptr);
  EXPECT_GE(reader->info().maxLevel, 1);
  expectSound();
  const tiling::Tiling tiling(GetParam());
  for (const TileId& id : storedTiles(*reader)) {
    const raster::SourceTile tile = loaded(*reader, id);
    for (int r = 3; r < kSize; r += 25) {
      for (int c = 3; c < kSize; c += 25) {
        const auto place =
            geo::geodeticFromDirection(tiling.direction(tiling::rootPointIn(id, (c + 0.5) / kSize, (r + 0.5) / kSize)));
        // JPEG, twice on the coarser levels.
        expectNear(pixelsOf(tile).at(c + kGutter, r + kGutter), colourAt(place.lat.degrees(), place.lon.degrees()), 8,
                   "level " + std::to_string(id.level));
      }
    }
  }
}

TEST_P(ImageryPyramid, GuttersShowTheNeighbour) {
  const auto reader = builtPyramid(options(globe()));
  ASSERT_NE(reader, nullptr);
  const tiling::Tiling tiling(GetParam());
  for (const TileId& id : storedTiles(*reader)) {
    const raster::SourceTile tile = loaded(*reader, id);
    for (const Edge edge : tiling::kEdges) {
      const tiling::EdgeNeighbour beyond = tiling.edgeNeighbour(id, edge);
      const raster::SourceTile neighbour = loaded(*reader, beyond.tile);
      for (int i = 0; i < kSize; i += 5) {
        const int along = beyond.reversed ? kSize - 1 - i : i;
        expectNear(pixelAtEdge(pixelsOf(tile), edge, i, -1), pixelAtEdge(pixelsOf(neighbour), beyond.edge, along, 0), 9,
                   "level " + std::to_string(id.level) + " edge " + std::to_string(static_cast<int>(edge)));
      }
    }
  }
}

TEST_P(ImageryPyramid, UncoveredStaysUncovered) {
  // Crosses the date line; its middle is uncovered.
  writeColour(folder_ / "local.tif", degreesGrid(170, -10, 190, 10, 200, 200), [](int c, int r) {
    return std::hypot(c - 100, r - 100) < 40 ? Rgba8{255, 0, 255, 0} : Rgba8{10, 200, 30, 255};
  });
  const auto reader = builtPyramid(options((folder_ / "local.tif").string()));
  ASSERT_NE(reader, nullptr);
  expectSound();
  std::size_t uncovered = 0;
  for (const TileId& id : storedTiles(*reader)) {
    const raster::SourceTile tile = loaded(*reader, id);
    for (const Rgba8 p : pixelsOf(tile).samples) {
      if (p.a == 0) ++uncovered;
      if (p.a == 0) continue;
      ASSERT_NEAR(int{p.r}, 10, 12);
      ASSERT_NEAR(int{p.g}, 200, 12);
    }
  }
  EXPECT_GT(uncovered, 0U);
}

TEST_P(ImageryPyramid, AppendedOverAGlobe) {
  ASSERT_NE(builtPyramid(options(globe())), nullptr);
  writeColour(folder_ / "local.tif", degreesGrid(40, -6, 52, 6, 240, 240), [](int, int) {
    return Rgba8{250, 0, 0, 255};
  });
  BuildOptions append = options((folder_ / "local.tif").string());
  append.append = true;
  const auto reader = builtPyramid(append);
  ASSERT_NE(reader, nullptr);
  expectSound();
  const tiling::Tiling tiling(GetParam());
  const auto colour = [&](double lat, double lon) {
    const geo::Direction place = geo::directionFromDegrees(lat, lon);
    for (int level = reader->info().maxLevel; level >= 0; --level) {
      const TileId id = tiling.tileAt(place, level);
      const auto tile = reader->load(id);
      if (!tile || !*tile) continue;
      const tiling::RootPoint p = tiling.rootPoint(place);
      const double scale = std::exp2(level) * kSize;
      const auto c = static_cast<int>(p.u * scale - id.x * double{kSize});
      const auto r = static_cast<int>(p.v * scale - id.y * double{kSize});
      return pixelsOf(**tile).at(c + kGutter, r + kGutter);
    }
    return Rgba8{};
  };
  expectNear(colour(1.0, 46.0), {250, 0, 0, 255}, 6, "inside");
  expectNear(colour(5.0, 60.0), colourAt(5.0, 60.0), 8, "beside");
  expectNear(colour(-60.0, -100.0), colourAt(-60.0, -100.0), 8, "far away");
}

INSTANTIATE_TEST_SUITE_P(Tilings, ImageryPyramid, ::testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

}  // namespace
}  // namespace tellurion::pyramid::testing
