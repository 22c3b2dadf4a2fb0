// Extending a database: the same promises as of a fresh one, and only what the new inputs touch is made again.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "pyramid/elevation_promises_test.h"
#include "pyramid/height_query.h"
#include "pyramid/synthetic_rasters_test.h"
#include "pyramid/verify.h"

namespace tellurion::pyramid::testing {
namespace {

using tiling::Scheme;
using tiling::TileId;

class Append : public ::testing::TestWithParam<Scheme> {
 protected:
  BuildOptions options(const std::vector<std::string>& inputs, bool append, const std::string& name = "out.tdb") const {
    BuildOptions options;
    options.output = folder_ / name;
    options.inputs = inputs;
    options.scheme = GetParam();
    options.append = append;
    return options;
  }
  std::string globe() const {
    const std::filesystem::path path = folder_ / "globe.tif";
    writeElevation(path, degreesGrid(-180, -90, 180, 90, 360, 180),
                   [](int c, int r) { return std::round(hills(89.5 - r, -179.5 + c)); });
    return path.string();
  }
  /// Square, its sides crossing tile and face borders; a hole in its middle.
  std::string patch(const std::string& name, double west, double south, double size, double level) const {
    GridSpec spec = degreesGrid(west, south, west + size, south + size, 60, 60);
    spec.nodata = -9999;
    const std::filesystem::path path = folder_ / name;
    writeElevation(path, spec, [level](int c, int r) {
      return std::hypot(c - 30, r - 30) < 9 ? -9999.0
                                            : std::round(level + 200.0 * std::sin(0.7 * c) * std::cos(0.9 * r));
    });
    return path.string();
  }
  TemporaryFolder folder_;
};

double height(HeightQuery& query, double lat, double lon) {
  const auto answer = query.at(geo::directionFromDegrees(lat, lon));
  EXPECT_TRUE(answer.has_value());
  return answer && *answer ? (*answer)->height_m : std::numeric_limits<double>::quiet_NaN();
}

void expectSound(const std::filesystem::path& path) {
  const auto report = verifyPyramid(path);
  ASSERT_TRUE(report.has_value()) << io::describe(report.error());
  EXPECT_TRUE(report->sound()) << report->faults.front();
}

TEST_P(Append, FinerDataOverAGlobeKeepsEveryPromise) {
  ASSERT_NE(builtPyramid(options({globe()}, false)), nullptr);
  const auto reader = builtPyramid(options({patch("a.tif", 40, -5, 9, 3000)}, true));
  ASSERT_NE(reader, nullptr);
  expectSound(folder_ / "out.tdb");
  expectEdgesShared(*reader);
  expectDecimated(*reader);
  expectErrorsBound(*reader);
  auto query = HeightQuery::create(reader);
  ASSERT_TRUE(query.has_value());
  EXPECT_NEAR(height(*query, -4.5, 40.5), 3000, 210);
  EXPECT_NEAR(height(*query, -40.0, 100.5), hills(-40.0, 100.5), 60);
}

TEST_P(Append, ACoarseModelShowsThroughAHoleWhereNothingIsFilled) {
  BuildOptions below = options({globe()}, false);
  BuildOptions above = options({patch("a.tif", 40, -5, 9, 3000)}, true);
  below.fillVoids_m = above.fillVoids_m = 0.0;
  ASSERT_NE(builtPyramid(below), nullptr);
  const auto reader = builtPyramid(above);
  ASSERT_NE(reader, nullptr);
  auto query = HeightQuery::create(reader);
  ASSERT_TRUE(query.has_value());
  for (const double aside : {0.0, 0.5, 1.0})
    EXPECT_NEAR(height(*query, -0.5, 44.5 + aside), hills(-0.5, 44.5 + aside), 60) << aside;
}

TEST_P(Append, PatchOverPatchesOfOtherDepthsKeepsEveryPromise) {
  ASSERT_NE(builtPyramid(options({globe(), patch("a.tif", 40, -5, 9, 3000)}, false)), nullptr);
  ASSERT_NE(builtPyramid(options({patch("b.tif", 46, 1, 3, 6000)}, true)), nullptr);
  const auto reader = builtPyramid(options({patch("c.tif", 30, -20, 30, -2000)}, true));
  ASSERT_NE(reader, nullptr);
  expectSound(folder_ / "out.tdb");
  expectEdgesShared(*reader);
  expectDecimated(*reader);
  expectErrorsBound(*reader);
}

TEST_P(Append, SamplesAreThoseOfAFreshBuildWhereDepthsAgree) {
  const std::string below = globe();
  GridSpec spec = degreesGrid(-100, 20, -20, 60, 80, 40);
  spec.nodata = -9999;
  const std::filesystem::path above = folder_ / "above.tif";
  writeElevation(above, spec, [](int c, int r) { return (c + r) % 17 < 4 ? -9999.0 : 100.0 + c - r; });
  const auto fresh = builtPyramid(options({below, above.string()}, false, "fresh.tdb"));
  ASSERT_NE(builtPyramid(options({below}, false)), nullptr);
  const auto appended = builtPyramid(options({above.string()}, true));
  ASSERT_TRUE(fresh != nullptr && appended != nullptr);
  const std::vector<TileId> tiles = storedTiles(*fresh);
  ASSERT_EQ(tiles, storedTiles(*appended));
  for (const TileId& id : tiles) {
    const raster::SourceTile a = loaded(*fresh, id);
    const raster::SourceTile b = loaded(*appended, id);
    for (int r = 1; r < heightsOf(a).height - 1; ++r) {
      for (int c = 1; c < heightsOf(a).width - 1; ++c) {
        // A sample that both rasters reach is rounded twice: half a step each.
        ASSERT_TRUE(raster::isNoData(heightsOf(a).at(c, r)) == raster::isNoData(heightsOf(b).at(c, r)));
        if (raster::isNoData(heightsOf(a).at(c, r))) continue;
        ASSERT_NEAR(static_cast<double>(heightsOf(a).at(c, r)), static_cast<double>(heightsOf(b).at(c, r)), 0.0626);
      }
    }
  }
}

TEST_P(Append, AgainIsAlreadyComplete) {
  ASSERT_NE(builtPyramid(options({globe()}, false)), nullptr);
  const BuildOptions append = options({patch("a.tif", 170, -80, 20, 10)}, true);
  ASSERT_NE(builtPyramid(append), nullptr);
  const std::string bytes = bytesOf(folder_ / "out.tdb");
  const auto again = buildPyramid(append);
  ASSERT_TRUE(again.has_value());
  EXPECT_TRUE(again->alreadyComplete);
  EXPECT_EQ(bytes, bytesOf(folder_ / "out.tdb"));
}

TEST_P(Append, AnInputThatCannotBeReadLeavesTheDatabaseAsItWas) {
  ASSERT_NE(builtPyramid(options({globe()}, false)), nullptr);
  const std::string bytes = bytesOf(folder_ / "out.tdb");
  const std::string sound = patch("a.tif", 40, -5, 9, 3000);
  const std::string damaged = patch("b.tif", 40, -5, 9, 3000);
  std::filesystem::resize_file(damaged, std::filesystem::file_size(damaged) / 2);
  const auto built = buildPyramid(options({damaged}, true));
  ASSERT_FALSE(built.has_value());
  EXPECT_NE(built.error().message.find("as it was"), std::string::npos) << io::describe(built.error());
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.tdb.part"));
  EXPECT_EQ(bytes, bytesOf(folder_ / "out.tdb"));
  EXPECT_TRUE(buildPyramid(options({sound}, true)).has_value());
}

TEST_P(Append, NeedsADatabaseOfItsKindTilingAndBody) {
  const std::string input = globe();
  const auto missing = buildPyramid(options({input}, true));
  ASSERT_FALSE(missing.has_value());
  EXPECT_EQ(missing.error().code, io::Failure::Code::notFound);
  ASSERT_NE(builtPyramid(options({input}, false)), nullptr);
  BuildOptions other = options({patch("a.tif", 0, 0, 5, 1)}, true);
  other.scheme = GetParam() == Scheme::cube ? Scheme::healpix : Scheme::cube;
  EXPECT_FALSE(buildPyramid(other).has_value());
  other = options({patch("a.tif", 0, 0, 5, 1)}, true);
  other.body = geo::mars();
  EXPECT_FALSE(buildPyramid(other).has_value());
  other = options({patch("a.tif", 0, 0, 5, 1)}, true);
  other.kind = raster::Kind::imagery;
  EXPECT_FALSE(buildPyramid(other).has_value());
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.tdb.part"));
}

INSTANTIATE_TEST_SUITE_P(Tilings, Append, ::testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

}  // namespace
}  // namespace tellurion::pyramid::testing
