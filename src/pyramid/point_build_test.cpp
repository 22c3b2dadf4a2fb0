// Databases that are made of points, alone and with rasters, on every tiling.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>

#include "geo/seed_test.h"
#include "pyramid/elevation_promises_test.h"
#include "pyramid/height_query.h"
#include "pyramid/parted_build.h"
#include "pyramid/synthetic_rasters_test.h"
#include "pyramid/verify.h"

namespace tellurion::pyramid::testing {
namespace {

namespace fs = std::filesystem;
using tiling::Scheme;

struct Point {
  double lat;
  double lon;
  double height_m;
};

/// Some metres of height over kilometres.
double gentle(double lat, double lon) {
  return 500.0 + 200.0 * std::sin(3.0 * lat) * std::cos(2.0 * lon);
}

class PointBuild : public ::testing::TestWithParam<Scheme> {
 protected:
  std::vector<Point> spread(int count, double south, double west, double north, double east) {
    std::vector<Point> points;
    for (int i = 0; i < count; ++i) {
      const double lat = geo::uniform(random_, south, north);
      const double lon = geo::uniform(random_, west, east);
      points.push_back({lat, lon, gentle(lat, lon)});
    }
    return points;
  }
  std::string table(const std::vector<Point>& points, const std::string& name = "points.csv") const {
    std::ofstream file(folder_ / name);
    file << "lon,lat,height\n";
    for (const Point& point : points)
      file << fmt::format("{:.7f},{:.7f},{:.3f}\n", point.lon, point.lat, point.height_m);
    return (folder_ / name).string();
  }
  BuildOptions options(std::vector<std::string> inputs, const std::string& name = "out.tdb") const {
    BuildOptions options;
    options.output = folder_ / name;
    options.inputs = std::move(inputs);
    options.scheme = GetParam();
    return options;
  }
  std::string globe() const {
    const fs::path path = folder_ / "globe.tif";
    writeElevation(path, degreesGrid(-180, -90, 180, 90, 360, 180), [](int, int) { return 1000.0; });
    return path.string();
  }
  void expectKept(const std::shared_ptr<const PyramidReader>& reader) const {
    ASSERT_NE(reader, nullptr);
    const auto report = verifyPyramid(folder_ / "out.tdb");
    ASSERT_TRUE(report.has_value()) << io::describe(report.error());
    EXPECT_TRUE(report->sound()) << report->faults.front();
    expectEdgesShared(*reader);
    expectDecimated(*reader);
    expectErrorsBound(*reader);
  }
  static std::optional<double> height(const HeightQuery& query, double lat, double lon) {
    const auto answer = query.at(geo::directionFromDegrees(lat, lon));
    EXPECT_TRUE(answer.has_value());
    return answer && *answer ? std::optional((*answer)->height_m) : std::nullopt;
  }
  std::mt19937_64 random_ = geo::seededGenerator();
  TemporaryFolder folder_;
};

TEST_P(PointBuild, HasTheHeightsBetweenItsPointsAndNoneElsewhere) {
  const auto reader = builtPyramid(options({table(spread(6000, 45.0, 179.0, 47.0, 181.0))}));
  expectKept(reader);
  const auto query = HeightQuery::create(reader);
  ASSERT_TRUE(query.has_value());
  for (const Point& asked : spread(500, 45.1, 179.1, 46.9, 180.9)) {
    const auto found = height(*query, asked.lat, asked.lon);
    ASSERT_TRUE(found.has_value()) << asked.lat << " " << asked.lon;
    EXPECT_NEAR(*found, asked.height_m, 2.0);
  }
  EXPECT_FALSE(height(*query, 48.0, 180.0).has_value());
  EXPECT_FALSE(height(*query, 46.0, -170.0).has_value());
  const geo::GeoRect bounds = reader->info().bounds;
  EXPECT_NEAR(bounds.south.degrees(), 45.0, 0.1);
  EXPECT_NEAR(bounds.north.degrees(), 47.0, 0.1);
  EXPECT_NEAR(bounds.width.degrees(), 2.0, 0.2);
}

TEST_P(PointBuild, IsTheSameBytesWhateverTheOrderOfPointsAndJobs) {
  std::vector<Point> points = spread(1500, 45.0, 6.0, 47.0, 9.0);
  std::ranges::copy(spread(1500, 45.8, 7.0, 46.1, 7.3), std::back_inserter(points));
  BuildOptions whole = options({table(points)}, "whole.tdb");
  whole.jobs = 1;
  ASSERT_NE(builtPyramid(whole), nullptr);
  const auto time = fs::last_write_time(folder_ / "points.csv");
  std::ranges::shuffle(points, random_);
  table(points);
  fs::last_write_time(folder_ / "points.csv", time);
  BuildOptions shuffled = whole;
  shuffled.output = folder_ / "shuffled.tdb";
  shuffled.jobs = 3;
  ASSERT_NE(builtPyramid(shuffled), nullptr);
  EXPECT_TRUE(bytesOf(whole.output) == bytesOf(shuffled.output));
}

TEST_P(PointBuild, IsDeepWherePointsAreDense) {
  std::vector<Point> points = spread(2000, 45.0, 6.0, 47.0, 8.0);
  std::ranges::copy(spread(4000, 45.9, 6.9, 46.1, 7.1), std::back_inserter(points));
  const auto reader = builtPyramid(options({table(points)}));
  expectKept(reader);
  const auto query = HeightQuery::create(reader);
  ASSERT_TRUE(query.has_value());
  const auto dense = query->at(geo::directionFromDegrees(46.0, 7.0));
  const auto sparse = query->at(geo::directionFromDegrees(45.3, 6.3));
  ASSERT_TRUE(dense && *dense && sparse && *sparse);
  EXPECT_GE((*dense)->level, (*sparse)->level + 3);
  for (const Point& asked : spread(1000, 45.2, 6.2, 46.8, 7.8)) {
    const auto found = height(*query, asked.lat, asked.lon);
    ASSERT_TRUE(found.has_value()) << asked.lat << " " << asked.lon;
    EXPECT_NEAR(*found, asked.height_m, 6.0);
  }
}

// Points 300 m below a raster: where they end the coarser ground comes down to them, and there is no step.
TEST_P(PointBuild, OverARasterMeetsItSoftlyInOneBuildAndAppended) {
  const std::string raster = globe();
  std::vector<Point> points = spread(2500, 45.0, 6.0, 46.0, 7.0);
  for (Point& point : points)
    point.height_m = 700.0;
  const std::string survey = table(points);
  for (const bool isAppended : {false, true}) {
    fs::remove(folder_ / "out.tdb");
    BuildOptions once = options({raster, survey});
    if (isAppended) {
      ASSERT_NE(builtPyramid(options({raster})), nullptr);
      once.inputs = {survey};
      once.append = true;
    }
    const auto reader = builtPyramid(once);
    expectKept(reader);
    const auto query = HeightQuery::create(reader);
    ASSERT_TRUE(query.has_value());
    EXPECT_NEAR(height(*query, 45.5, 6.5).value_or(0.0), 700.0, 0.1);
    EXPECT_NEAR(height(*query, 50.0, 20.0).value_or(0.0), 1000.0, 0.1);
    double before = 700.0;
    double steepest = 0.0;
    for (double lon = 6.5; lon < 9.0; lon += 0.001) {
      const auto at = height(*query, 45.5, lon);
      ASSERT_TRUE(at.has_value()) << lon;
      steepest = std::max(steepest, std::abs(*at - before));
      before = *at;
    }
    EXPECT_LT(steepest, 15.0);  // 300 m over 1 km would be 25 or more
    EXPECT_GT(before, 950.0);
  }
}

TEST_P(PointBuild, AveragesPointsWhereLessDepthIsAskedFor) {
  std::vector<Point> points = spread(40000, 45.0, 6.0, 46.0, 7.0);
  for (Point& point : points)
    point.height_m = 500.0 + geo::uniform(random_, -100.0, 100.0);
  BuildOptions coarse = options({table(points)});
  coarse.maxLevel = 6;
  const auto reader = builtPyramid(coarse);
  ASSERT_NE(reader, nullptr);
  const auto query = HeightQuery::create(reader);
  ASSERT_TRUE(query.has_value());
  double sum = 0.0;
  for (const Point& asked : spread(500, 45.2, 6.2, 45.8, 6.8))
    sum += std::pow(height(*query, asked.lat, asked.lon).value_or(0.0) - 500.0, 2.0);
  EXPECT_LT(std::sqrt(sum / 500.0), 30.0);  // 58 of the points themselves, some 40 of triangles between them
}

TEST_P(PointBuild, OptionsAreInTheKeyAndInTheShards) {
  std::ofstream file(folder_ / "map.csv");
  file << "a,b,c,d\n";
  for (int i = 0; i < 900; ++i)
    file << fmt::format("{},{},{},7\n", 500000 + 1000 * (i % 30) + i, 5000000 + 1000 * (i / 30), i);
  file.close();
  BuildOptions first = options({(folder_ / "map.csv").string()});
  first.points = {.columns = {"a", "b", "c"}, .reference = "EPSG:32632"};
  BuildOptions second = first;
  second.points.columns[2] = "d";
  BuildOptions third = first;
  third.points.reference = "EPSG:32633";
  const auto key = keyOfBuild(first);
  ASSERT_TRUE(key.has_value()) << io::describe(key.error());
  EXPECT_NE(*key, keyOfBuild(second).value_or(*key));
  EXPECT_NE(*key, keyOfBuild(third).value_or(*key));
  ASSERT_NE(builtPyramid(first), nullptr);
  BuildOptions parted = first;
  parted.output = folder_ / "parted.tdb";
  const auto build = PartedBuild::plan(parted);
  ASSERT_TRUE(build.has_value());
  fs::create_directories(build->folder());
  std::vector<fs::path> shards;
  for (std::size_t i = 0; i < build->parts().size(); ++i) {
    ASSERT_TRUE(build->make(i).has_value());
    shards.push_back(build->shard(i));
  }
  ASSERT_TRUE(mergeShards({.output = parted.output, .shards = shards, .jobs = 1}).has_value());
  EXPECT_TRUE(bytesOf(first.output) == bytesOf(parted.output));
  first.points.columns.pop_back();
  EXPECT_FALSE(keyOfBuild(first).has_value());
}

INSTANTIATE_TEST_SUITE_P(Schemes, PointBuild, ::testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& of) { return std::string(tiling::nameOf(of.param)); });

TEST(PointBuildRefusals, SayWhatToDo) {
  const TemporaryFolder folder;
  std::ofstream line(folder / "line.csv");
  line << "lon,lat,height\n";
  for (int i = 0; i < 500; ++i)
    line << fmt::format("{},{},5\n", 7.0 + 0.001 * i * i, 46.0 + 0.0005 * i * i);
  line.close();
  BuildOptions options;
  options.output = folder / "out.tdb";
  options.inputs = {(folder / "line.csv").string()};
  auto built = buildPyramid(options);
  ASSERT_FALSE(built.has_value());
  EXPECT_NE(built.error().message.find("cover no ground"), std::string::npos) << built.error().message;
  options.kind = raster::Kind::imagery;
  built = buildPyramid(options);
  ASSERT_FALSE(built.has_value());
  EXPECT_NE(built.error().message.find("--kind elevation"), std::string::npos) << built.error().message;
  std::ofstream many(folder / "many.csv");
  many << "lon,lat,height\n";
  for (int i = 0; i < 1700000; ++i)
    many << "1,2,3\n";
  many.close();
  options.kind = raster::Kind::elevation;
  options.memoryBytes = kLeastMemory;
  options.inputs = {(folder / "many.csv").string()};
  built = buildPyramid(options);
  ASSERT_FALSE(built.has_value());
  EXPECT_NE(built.error().message.find("a quarter of --memory"), std::string::npos) << built.error().message;
}

}  // namespace
}  // namespace tellurion::pyramid::testing
