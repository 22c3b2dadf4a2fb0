// --region: a part of the inputs, and nothing else of them; --format and --memory, which go with large builds.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "pyramid/database.h"
#include "pyramid/height_query.h"
#include "pyramid/synthetic_rasters_test.h"
#include "pyramid/verify.h"
#include "raster/codec.h"

namespace tellurion::pyramid::testing {
namespace {

using tiling::Scheme;

std::optional<double> heightAt(const std::shared_ptr<const PyramidReader>& reader, double lat, double lon) {
  const auto query = HeightQuery::create(reader);
  EXPECT_TRUE(query.has_value());
  const auto answer = query->at(geo::directionFromDegrees(lat, lon));
  EXPECT_TRUE(answer.has_value());
  return answer && *answer ? std::optional((*answer)->height_m) : std::nullopt;
}

class BuildRegion : public ::testing::TestWithParam<Scheme> {
 protected:
  BuildOptions options(const std::string& input, const std::string& name) const {
    BuildOptions options;
    options.output = folder_ / name;
    options.inputs = {input};
    options.scheme = GetParam();
    return options;
  }
  std::string globe() const { return writeHillyGlobe(folder_ / "globe.tif"); }
  /// A mosaic of 172,800 x 86,400 pixels out of 8 x 4 files of 20 x 20, all damaged but those of `sound`.
  std::string mosaic(const std::vector<int>& sound) const {
    std::string sources;
    for (int i = 0; i < 32; ++i) {
      const std::string name = fmt::format("part{}.tif", i);
      const int column = i % 8;
      const int row = i / 8;
      const bool isSound = std::ranges::find(sound, i) != sound.end();
      if (isSound) {
        const double west = -180.0 + 45.0 * column;
        const double south = 45.0 - 45.0 * row;
        writeElevation(folder_ / name, degreesGrid(west, south, west + 45, south + 45, 20, 20),
                       [i](int, int) { return 100.0 + i; });
      } else {
        std::ofstream(folder_ / name) << "II*this was a TIFF once";
      }
      sources += fmt::format(
          R"(<SimpleSource><SourceFilename relativeToVRT="1">{}</SourceFilename><SourceBand>1</SourceBand>
<SourceProperties RasterXSize="20" RasterYSize="20" DataType="Int16" BlockXSize="20" BlockYSize="20"/>
<SrcRect xOff="0" yOff="0" xSize="20" ySize="20"/><DstRect xOff="{}" yOff="{}" xSize="21600" ySize="21600"/></SimpleSource>)",
          name, 21600 * column, 21600 * row);
    }
    const std::filesystem::path path = folder_ / "mosaic.vrt";
    std::ofstream(path) << R"(<VRTDataset rasterXSize="172800" rasterYSize="86400"><SRS>EPSG:4326</SRS>)"
                        << "<GeoTransform>-180,0.0020833333333333333,0,90,0,-0.0020833333333333333</GeoTransform>"
                        << R"(<VRTRasterBand dataType="Int16" band="1">)" << sources << "</VRTRasterBand></VRTDataset>";
    return path.string();
  }
  TemporaryFolder folder_;
};

TEST_P(BuildRegion, IsAsIfTheInputEndedAtItsEdges) {
  const std::string input = globe();
  for (const auto& [name, region] : {std::pair("alps", geo::GeoRect::fromDegrees(40, 0, 52, 20)),
                                     std::pair("dateline", geo::GeoRect::fromDegrees(-10, 170, 5, -165)),
                                     std::pair("pole", geo::GeoRect::fromDegrees(80, -180, 90, 180))}) {
    const auto whole = builtPyramid(options(input, std::string(name) + "whole.tdb"));
    BuildOptions some = options(input, std::string(name) + ".tdb");
    some.region = region;
    const auto part = builtPyramid(some);
    ASSERT_TRUE(whole && part);
    int within = 0;
    for (double lat = -89.3; lat < 90; lat += 2.9) {
      for (double lon = -179.1; lon < 180; lon += 3.7) {
        // Between the outermost samples of the region there is no surface.
        const bool isInside = region.contains(geo::Angle::degrees(lat), geo::Angle::degrees(lon));
        const bool isNear =
            region.grown(geo::Angle::degrees(1)).contains(geo::Angle::degrees(lat), geo::Angle::degrees(lon));
        const auto height = heightAt(part, lat, lon);
        if (!isNear) {
          EXPECT_FALSE(height.has_value()) << lat << ", " << lon;
        }
        if (!isInside || !height) continue;
        ++within;
        const auto same = heightAt(whole, lat, lon);
        ASSERT_TRUE(same.has_value());
        EXPECT_EQ(*height, *same) << lat << ", " << lon;
      }
    }
    EXPECT_GT(within, 5) << name;
    const auto report = verifyPyramid(some.output);
    ASSERT_TRUE(report.has_value());
    EXPECT_TRUE(report->sound()) << report->faults.front();
  }
}

TEST_P(BuildRegion, ReadsNothingElse) {
  BuildOptions some = options(mosaic({12}), "some.tdb");
  some.region = geo::GeoRect::fromDegrees(20.0, 10.0, 20.3, 10.3);  // in part 12: 0 to 45 east, 0 to 45 north
  const auto part = builtPyramid(some);
  ASSERT_NE(part, nullptr);
  EXPECT_EQ(heightAt(part, 20.15, 10.15), 112.0);
  EXPECT_FALSE(heightAt(part, 20.15, 11.0).has_value());
  // The rest would not have been readable: a region beside says so.
  BuildOptions beside = options((folder_ / "mosaic.vrt").string(), "beside.tdb");
  beside.region = geo::GeoRect::fromDegrees(-20.3, 10.0, -20.0, 10.3);
  const auto failed = buildPyramid(beside);
  ASSERT_FALSE(failed.has_value());
  EXPECT_NE(failed.error().where.find("mosaic.vrt"), std::string::npos) << io::describe(failed.error());
}

TEST_P(BuildRegion, BesideTheInputIsAnError) {
  const std::filesystem::path path = folder_ / "alps.tif";
  writeElevation(path, degreesGrid(5, 44, 10, 48, 40, 40), [](int, int) { return 1.0; });
  BuildOptions beside = options(path.string(), "out.tdb");
  beside.region = geo::GeoRect::fromDegrees(-10, -20, 0, -10);
  const auto failed = buildPyramid(beside);
  ASSERT_FALSE(failed.has_value());
  EXPECT_NE(failed.error().message.find("region"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.tdb.part"));
}

// Neither workers nor memory are in the bytes, in the region's cut tiles either.
TEST_P(BuildRegion, TheResultDependsOnNeitherWorkersNorMemory) {
  const std::string input = globe();
  std::string first;
  for (const auto& [jobs, memory] :
       {std::pair(1, kLeastMemory), std::pair(3, kLeastMemory), std::pair(2, kLeastMemory * 8)}) {
    BuildOptions some = options(input, fmt::format("{}_{}.tdb", jobs, memory));
    some.region = geo::GeoRect::fromDegrees(-33, -51, 47, 62);
    some.jobs = jobs;
    some.memoryBytes = memory;
    ASSERT_NE(builtPyramid(some), nullptr);
    const std::string bytes = bytesOf(some.output);
    if (first.empty()) first = bytes;
    EXPECT_TRUE(bytes == first) << jobs << " jobs, " << memory << " bytes";
  }
}

TEST(BuildFormat, IsThatOfEveryTile) {
  const TemporaryFolder folder;
  writeColour(folder / "in.tif", degreesGrid(-180, -90, 180, 90, 512, 256), [](int c, int r) {
    return raster::Rgba8{static_cast<std::uint8_t>(c / 2), static_cast<std::uint8_t>(r), 90, 255};
  });
  for (const TileFormat format : {TileFormat::jpeg, TileFormat::png, TileFormat::webp}) {
    BuildOptions options;
    options.output = folder / std::string(nameOf(format));
    options.inputs = {(folder / "in.tif").string()};
    options.kind = raster::Kind::imagery;
    options.scheme = Scheme::geographic;
    options.format = format;
    ASSERT_TRUE(buildPyramid(options).has_value());
    auto database = TileDatabase::open(options.output, io::SqliteConnection::Mode::read);
    ASSERT_TRUE(database.has_value());
    auto rows = database->connection().prepare("SELECT payload FROM tiles");
    ASSERT_TRUE(rows.has_value());
    int count = 0;
    while (*rows->step()) {
      const auto header = raster::readImageHeader(rows->blob(0));
      ASSERT_TRUE(header.has_value());
      EXPECT_EQ(static_cast<int>(header->format), static_cast<int>(format)) << nameOf(format);
      ++count;
    }
    EXPECT_GT(count, 5);
    const auto report = verifyPyramid(options.output);
    ASSERT_TRUE(report.has_value());
    EXPECT_TRUE(report->sound()) << report->faults.front();
  }
}

INSTANTIATE_TEST_SUITE_P(Schemes, BuildRegion, ::testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

}  // namespace
}  // namespace tellurion::pyramid::testing
