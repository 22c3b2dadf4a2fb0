// What a build is from outside: the same bytes on every way, clear words on every failure.
#include "pyramid/pyramid_builder.h"
#include "geo/seed_test.h"

#include <gdal_priv.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>
#include <thread>

#include "io/sqlite.h"
#include "pyramid/build_plan.h"
#include "pyramid/synthetic_rasters_test.h"
#include "pyramid/tile_maker.h"
#include "pyramid/verify.h"
#include "raster/live_tiles.h"

namespace tellurion::pyramid::testing {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;

class PyramidBuilder : public ::testing::Test {
 protected:
  BuildOptions options(const std::string& output, std::vector<std::string> inputs) const {
    BuildOptions options;
    options.output = folder_ / output;
    options.inputs = std::move(inputs);
    return options;
  }
  std::string globe(const std::string& name = "globe.tif") const { return writeHillyGlobe(folder_ / name); }
  TemporaryFolder folder_;
};

TEST_F(PyramidBuilder, AnyNumberOfThreadsGivesTheSameBytes) {
  const std::string input = globe();
  for (const int jobs : {1, 2, 7}) {
    BuildOptions build = options("jobs" + std::to_string(jobs) + ".tdb", {input});
    build.jobs = jobs;
    ASSERT_TRUE(buildPyramid(build).has_value());
    EXPECT_EQ(bytesOf(folder_ / "jobs1.tdb"), bytesOf(build.output)) << jobs << " threads";
  }
}

TEST_F(PyramidBuilder, GoesOnAfterEveryStopWithTheSameBytes) {
  const std::string input = globe();
  const BuildOptions whole = options("whole.tdb", {input});
  ASSERT_TRUE(buildPyramid(whole).has_value());
  BuildOptions stopped = options("stopped.tdb", {input});
  const unsigned seed = geo::testSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  int stops = 0;
  io::Result<BuildReport> built = io::fail(Code::cancelled, "");
  for (int run = 0; !built && run < 1000; ++run) {
    const std::chrono::milliseconds patience(std::uniform_int_distribution<int>(0, 40 + 10 * run)(random));
    std::stop_source source;
    const std::jthread impatient([&] {
      std::this_thread::sleep_for(patience);
      source.request_stop();
    });
    built = buildPyramid(stopped, {}, source.get_token());
    if (built) break;
    ++stops;
    ASSERT_EQ(built.error().code, Code::cancelled) << io::describe(built.error());
    ASSERT_FALSE(fs::exists(stopped.output));
  }
  ASSERT_TRUE(built.has_value());
  EXPECT_GT(stops, 0);
  EXPECT_EQ(bytesOf(whole.output), bytesOf(stopped.output));
  EXPECT_FALSE(fs::exists(folder_ / "stopped.tdb.part"));
}

TEST_F(PyramidBuilder, AFileLeftBeforeItsFirstCommitIsTakenUp) {
  const std::string input = globe();
  const BuildOptions whole = options("whole.tdb", {input});
  ASSERT_TRUE(buildPyramid(whole).has_value());
  const BuildOptions blank = options("blank.tdb", {input});
  writeElevation(folder_ / "x.tif", degreesGrid(0, 0, 1, 1, 2, 2), [](int, int) { return 0; });
  fs::resize_file(folder_ / "x.tif", 0);
  fs::rename(folder_ / "x.tif", folder_ / "blank.tdb.part");
  ASSERT_TRUE(buildPyramid(blank).has_value());
  EXPECT_EQ(bytesOf(whole.output), bytesOf(blank.output));
}

TEST_F(PyramidBuilder, FinishedButNotYetRenamedIsOnlyRenamed) {
  const BuildOptions build = options("out.tdb", {globe()});
  ASSERT_TRUE(buildPyramid(build).has_value());
  const std::string bytes = bytesOf(build.output);
  fs::rename(build.output, folder_ / "out.tdb.part");
  const auto again = buildPyramid(build);
  ASSERT_TRUE(again.has_value()) << io::describe(again.error());
  EXPECT_TRUE(again->resumed);
  EXPECT_EQ(bytes, bytesOf(build.output));
}

TEST_F(PyramidBuilder, AgainIsAlreadyComplete) {
  const BuildOptions build = options("out.tdb", {globe()});
  const auto first = buildPyramid(build);
  ASSERT_TRUE(first.has_value());
  EXPECT_FALSE(first->alreadyComplete);
  const auto again = buildPyramid(build);
  ASSERT_TRUE(again.has_value());
  EXPECT_TRUE(again->alreadyComplete);
  EXPECT_EQ(again->tiles, first->tiles);
  EXPECT_EQ(again->maxLevel, 2);
}

TEST_F(PyramidBuilder, AnotherBuildIsNotOverwritten) {
  const std::string input = globe();
  ASSERT_TRUE(buildPyramid(options("out.tdb", {input})).has_value());
  BuildOptions other = options("out.tdb", {input});
  other.maxLevel = 1;
  const auto refused = buildPyramid(other);
  ASSERT_FALSE(refused.has_value());
  EXPECT_NE(refused.error().message.find("--append"), std::string::npos);
  fs::rename(folder_ / "out.tdb", folder_ / "out.tdb.part");
  const auto left = buildPyramid(other);
  ASSERT_FALSE(left.has_value());
  EXPECT_NE(left.error().message.find("start over"), std::string::npos);
}

TEST_F(PyramidBuilder, AChangedInputIsAnotherBuild) {
  const std::string input = globe();
  ASSERT_TRUE(buildPyramid(options("out.tdb", {input})).has_value());
  fs::last_write_time(input, fs::last_write_time(input) + std::chrono::seconds(5));
  EXPECT_FALSE(buildPyramid(options("out.tdb", {input})).has_value());
}

TEST_F(PyramidBuilder, ASideFileIsPartOfTheBuild) {
  const std::string input = globe();
  ASSERT_TRUE(buildPyramid(options("out.tdb", {input})).has_value());
  const auto say = [&](const char* what) { std::ofstream(input + ".aux.xml") << what; };
  say("<PAMDataset>\n <PAMRasterBand band=\"1\">\n  <NoDataValue>-5</NoDataValue>\n </PAMRasterBand>\n</PAMDataset>\n");
  EXPECT_FALSE(buildPyramid(options("out.tdb", {input})).has_value());
  ASSERT_TRUE(buildPyramid(options("second.tdb", {input})).has_value());
  EXPECT_TRUE(buildPyramid(options("second.tdb", {input}))->alreadyComplete);
  fs::last_write_time(input + ".aux.xml", fs::last_write_time(input) + std::chrono::seconds(5));
  EXPECT_TRUE(buildPyramid(options("second.tdb", {input}))->alreadyComplete) << "merely touched";
  say("<PAMDataset>\n <PAMRasterBand band=\"1\">\n  <NoDataValue>-6</NoDataValue>\n </PAMRasterBand>\n</PAMDataset>\n");
  EXPECT_FALSE(buildPyramid(options("second.tdb", {input})).has_value());
}

TEST_F(PyramidBuilder, StatisticsThatOthersLeaveBesideAnInputDoNotMatter) {
  const std::string input = globe();
  ASSERT_TRUE(buildPyramid(options("out.tdb", {input})).has_value());
  {
    const std::unique_ptr<GDALDataset> looked(GDALDataset::Open(input.c_str()));
    double statistics[4];
    ASSERT_EQ(looked->GetRasterBand(1)->ComputeStatistics(FALSE, statistics, statistics + 1, statistics + 2,
                                                          statistics + 3, nullptr, nullptr),
              CE_None);
    GUIntBig* counts = nullptr;
    double least = 0.0;
    double most = 0.0;
    int buckets = 0;
    ASSERT_EQ(looked->GetRasterBand(1)->GetDefaultHistogram(&least, &most, &buckets, &counts, TRUE, nullptr, nullptr),
              CE_None);
    VSIFree(counts);
  }
  ASSERT_TRUE(fs::exists(input + ".aux.xml"));
  EXPECT_TRUE(buildPyramid(options("out.tdb", {input}))->alreadyComplete);
}

TEST_F(PyramidBuilder, ANameWrittenOtherwiseIsTheSameBuild) {
  const std::string input = globe();
  const fs::path detour = folder_ / "." / "globe.tif";
  ASSERT_NE(detour.string(), input);
  ASSERT_TRUE(buildPyramid(options("plain.tdb", {input})).has_value());
  ASSERT_TRUE(buildPyramid(options("detour.tdb", {detour.string()})).has_value());
  EXPECT_EQ(bytesOf(folder_ / "plain.tdb"), bytesOf(folder_ / "detour.tdb"));
  const auto again = buildPyramid(options("plain.tdb", {detour.string()}));
  ASSERT_TRUE(again.has_value());
  EXPECT_TRUE(again->alreadyComplete);
}

TEST_F(PyramidBuilder, TheBodysNameIsPartOfTheBuild) {
  const std::string input = globe();
  BuildOptions build = options("out.tdb", {input});
  build.body = geo::earth();
  ASSERT_TRUE(buildPyramid(build).has_value());
  build.body = geo::Body{"terra", geo::earth().ellipsoid};
  EXPECT_FALSE(buildPyramid(build).has_value());
}

TEST_F(PyramidBuilder, WhatIsNoDatabaseIsNotOverwritten) {
  const std::string input = globe();
  fs::copy_file(input, folder_ / "out.tdb");
  const std::string before = bytesOf(folder_ / "out.tdb");
  const auto refused = buildPyramid(options("out.tdb", {input}));
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, Code::corrupt);
  EXPECT_EQ(before, bytesOf(folder_ / "out.tdb"));
}

TEST_F(PyramidBuilder, NoDataAtAllIsAFailureThatLeavesNothing) {
  GridSpec spec = degreesGrid(0, 0, 10, 10, 20, 20);
  spec.nodata = -9999;
  writeElevation(folder_ / "void.tif", spec, [](int, int) { return -9999; });
  const auto built = buildPyramid(options("out.tdb", {(folder_ / "void.tif").string()}));
  ASSERT_FALSE(built.has_value());
  EXPECT_NE(built.error().message.find("no input has any data"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "out.tdb"));
  EXPECT_FALSE(fs::exists(folder_ / "out.tdb.part"));
}

TEST_F(PyramidBuilder, AnInputThatCannotBeReadLeavesNothingInTheWay) {
  const std::string sound = globe();
  const std::string damaged = globe("damaged.tif");
  fs::resize_file(damaged, fs::file_size(damaged) / 2);
  for (const std::vector<std::string>& inputs : {std::vector{damaged}, std::vector{sound, damaged}}) {
    const auto built = buildPyramid(options("out.tdb", inputs));
    ASSERT_FALSE(built.has_value());
    EXPECT_EQ(built.error().code, Code::corrupt);
    EXPECT_EQ(built.error().where, damaged);
    EXPECT_FALSE(fs::exists(folder_ / "out.tdb"));
    EXPECT_FALSE(fs::exists(folder_ / "out.tdb.part"));
  }
  EXPECT_TRUE(buildPyramid(options("out.tdb", {sound})).has_value());
}

TEST_F(PyramidBuilder, AnInputThatCannotBeReadRemovesWhatAStoppedRunLeft) {
  const std::string damaged = globe();
  fs::resize_file(damaged, fs::file_size(damaged) / 2);
  std::stop_source stopped;
  stopped.request_stop();
  const BuildOptions build = options("out.tdb", {damaged});
  EXPECT_EQ(buildPyramid(build, {}, stopped.get_token()).error().code, Code::cancelled);
  ASSERT_TRUE(fs::exists(folder_ / "out.tdb.part"));
  EXPECT_EQ(buildPyramid(build).error().code, Code::corrupt);
  EXPECT_FALSE(fs::exists(folder_ / "out.tdb.part"));
}

TEST_F(PyramidBuilder, AnInputThatGoesAwayKeepsWhatIsDone) {
  const std::string input = globe();
  BuildOptions build = options("out.tdb", {input});
  build.jobs = 1;
  std::vector<std::string> inputs = {input};
  for (int i = 0; i < 20; ++i) {  // so many that files are closed and opened again
    const std::string name = "strip" + std::to_string(i) + ".tif";
    writeElevation(folder_ / name, degreesGrid(-40 + 2 * i, -3, -38 + 2 * i, 3, 40, 120), [i](int, int) { return i; });
    inputs.push_back((folder_ / name).string());
  }
  build.inputs = inputs;
  bool isAway = false;
  const auto built = buildPyramid(build, [&](const BuildProgress& progress) {
    if (isAway || progress.done < 100) return;
    isAway = true;
    for (const std::string& path : inputs)
      fs::rename(path, path + ".away");
  });
  if (built) GTEST_SKIP() << "no input was opened again";
  EXPECT_NE(std::ranges::find(inputs, built.error().where), inputs.end()) << io::describe(built.error());
  EXPECT_TRUE(fs::exists(folder_ / "out.tdb.part"));
  for (const std::string& path : inputs)
    fs::rename(path + ".away", path);
  EXPECT_TRUE(buildPyramid(build)->resumed);
}

TEST_F(PyramidBuilder, LittleOfAnElevationFileIsLostToItsPages) {
  const BuildOptions build = options("out.tdb", {std::string(TELLURION_SOURCE_DIR "/data/mars/mola_dem_4ppd.tif")});
  const auto reader = builtPyramid(build);
  ASSERT_NE(reader, nullptr);
  const auto summary = reader->summary();
  ASSERT_TRUE(summary.has_value());
  std::uint64_t payload = 0;
  for (const LevelSummary& level : summary->levels)
    payload += level.payloadBytes;
  EXPECT_GT(static_cast<double>(payload), 0.9 * static_cast<double>(fs::file_size(build.output)));
}

TEST_F(PyramidBuilder, FilesMayHaveAllThePagesThatTheFormatCanNumberAndSayWhenTheyHave) {
  const BuildOptions build = options("out.tdb", {globe()});
  ASSERT_TRUE(buildPyramid(build).has_value());
  const auto database = TileDatabase::open(build.output, io::SqliteConnection::Mode::write);
  ASSERT_TRUE(database.has_value());
  const io::SqliteConnection& connection = database->connection();
  EXPECT_EQ(connection.integer("PRAGMA max_page_count").value_or(0), 4294967294);
  const std::int64_t pages = connection.integer("PRAGMA page_count").value_or(0);
  ASSERT_TRUE(connection.execute("PRAGMA max_page_count = " + std::to_string(pages)).has_value());
  const auto full = connection.execute("CREATE TABLE more AS SELECT * FROM tiles");
  ASSERT_FALSE(full.has_value());
  EXPECT_NE(full.error().message.find("all the pages"), std::string::npos) << full.error().message;
}

TEST_F(PyramidBuilder, FilesWithTheFormerPagesAreReadAndAppendedTo) {
  BuildOptions build = options("out.tdb", {globe()});
  ASSERT_TRUE(buildPyramid(build).has_value());
  {
    const auto connection = io::SqliteConnection::open(build.output, io::SqliteConnection::Mode::write);
    ASSERT_TRUE(connection.has_value());
    EXPECT_EQ(connection->integer("PRAGMA page_size").value_or(0), 1024);
    ASSERT_TRUE(connection->execute("PRAGMA page_size = 4096").has_value());
    ASSERT_TRUE(connection->execute("VACUUM").has_value());
    EXPECT_EQ(connection->integer("PRAGMA page_size").value_or(0), 4096);
  }
  ASSERT_TRUE(verifyPyramid(build.output)->sound());
  writeElevation(folder_ / "more.tif", degreesGrid(0, 0, 10, 10, 80, 80), [](int c, int r) { return 10 * c + r; });
  build.inputs = {(folder_ / "more.tif").string()};
  build.append = true;
  ASSERT_TRUE(buildPyramid(build).has_value());
  EXPECT_TRUE(verifyPyramid(build.output)->sound());
}

TEST_F(PyramidBuilder, WarningsOfSamplingAreReportedOnce) {
  writeElevation(folder_ / "void.tif", degreesGrid(0, 0, 40, 40, 200, 200),
                 [](int c, int r) { return (c + r) % 7 == 0 ? -32767 : 100; });
  std::vector<std::string> inputs = {globe(), (folder_ / "void.tif").string()};
  for (int i = 0; i < 20; ++i) {  // so many that files are closed again
    const fs::path path = folder_ / ("strip" + std::to_string(i) + ".tif");
    writeElevation(path, degreesGrid(2 * i, -3, 2 * i + 2, 3, 8, 24), [i](int, int) { return 10 * i; });
    inputs.push_back(path.string());
  }
  for (const int jobs : {1, 4}) {
    BuildOptions build = options("jobs" + std::to_string(jobs) + ".tdb", inputs);
    build.jobs = jobs;
    const auto report = buildPyramid(build);
    ASSERT_TRUE(report.has_value()) << io::describe(report.error());
    int told = 0;
    for (const std::string& warning : report->warnings)
      told += warning.starts_with(inputs[1]) && warning.find("--nodata") != std::string::npos ? 1 : 0;
    EXPECT_EQ(told, 1) << jobs << " threads";
  }
}

TEST_F(PyramidBuilder, AMissingInputIsNamed) {
  const auto built = buildPyramid(options("out.tdb", {(folder_ / "nowhere.tif").string()}));
  ASSERT_FALSE(built.has_value());
  EXPECT_NE(io::describe(built.error()).find("nowhere.tif"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "out.tdb.part"));
}

TEST_F(PyramidBuilder, AMissingFolderIsNamed) {
  const auto built = buildPyramid(options("no/such/folder/out.tdb", {globe()}));
  ASSERT_FALSE(built.has_value());
  EXPECT_NE(io::describe(built.error()).find("no/such/folder"), std::string::npos);
}

TEST_F(PyramidBuilder, BodiesMustAgree) {
  GridSpec mars = degreesGrid(0, 0, 10, 10, 20, 20);
  mars.reference = "+proj=longlat +R=3396190 +no_defs";
  writeElevation(folder_ / "mars.tif", mars, [](int, int) { return 1; });
  const std::string path = (folder_ / "mars.tif").string();
  EXPECT_FALSE(buildPyramid(options("both.tdb", {globe(), path})).has_value());
  const auto reader = builtPyramid(options("mars.tdb", {path}));
  ASSERT_NE(reader, nullptr);
  EXPECT_EQ(reader->info().body, geo::mars());
}

TEST_F(PyramidBuilder, ManyInputsAreOpenedInTurns) {
  std::vector<std::string> inputs;
  for (int i = 0; i < 40; ++i) {
    const fs::path path = folder_ / ("strip" + std::to_string(i) + ".tif");
    writeElevation(path, degreesGrid(-40 + 2 * i, -3, -38 + 2 * i, 3, 8, 24), [i](int, int) { return 10 * i; });
    inputs.push_back(path.string());
  }
  const auto reader = builtPyramid(options("out.tdb", inputs));
  ASSERT_NE(reader, nullptr);
  const auto summary = reader->summary();
  ASSERT_TRUE(summary.has_value());
  EXPECT_EQ(summary->sources, inputs);
  EXPECT_NEAR(reader->info().bounds.width.degrees(), 80.0, 1e-9);
}

TEST(BuildPlan, DepthIsTheFirstLevelAsFineAsTheInput) {
  using raster::Kind;
  const tiling::Tiling tiling(tiling::Scheme::geographic);
  const geo::Angle spacing = tiling.metrics(4).largestEdge / 64;
  for (const Kind kind : {Kind::elevation, Kind::imagery}) {
    EXPECT_EQ(raster::levelOfSpacing(tiling, 64, spacing, kind), 4);
    EXPECT_EQ(raster::levelOfSpacing(tiling, 64, spacing / 1.005, kind), 4);
    EXPECT_EQ(raster::levelOfSpacing(tiling, 64, spacing / 1.02, kind), 5);
    EXPECT_EQ(raster::levelOfSpacing(tiling, 64, spacing * 1.5, kind), 4);
    EXPECT_EQ(raster::levelOfSpacing(tiling, 64, spacing * 2.0, kind), 3);
    EXPECT_EQ(raster::levelOfSpacing(tiling, 64, geo::Angle::degrees(1000), kind), 0);
    EXPECT_EQ(raster::levelOfSpacing(tiling, 64, geo::Angle::radians(1e-30), kind), tiling::kMaxLevel);
  }
}

TEST(BuildPlan, HealpixPicturesAreNotDeeperForTheirPolesAlone) {
  const tiling::Tiling tiling(tiling::Scheme::healpix);
  const tiling::LevelMetrics level = tiling.metrics(4);
  ASSERT_GT(level.largestEdge.radians(), 1.3 * level.meanEdge.radians());
  const geo::Angle spacing = level.meanEdge * 1.11 / 64;
  EXPECT_EQ(raster::levelOfSpacing(tiling, 64, spacing, raster::Kind::imagery), 4);
  EXPECT_EQ(raster::levelOfSpacing(tiling, 64, spacing, raster::Kind::elevation), 5);
  EXPECT_EQ(raster::levelOfSpacing(tiling, 64, level.meanEdge / 64, raster::Kind::imagery), 5);
}

TEST(BuildMemory, PartsAreNoMoreThanTheWhole) {
  constexpr std::uint64_t kMiB = std::uint64_t{1} << 20u;
  for (const std::uint64_t bytes : {128 * kMiB, 200 * kMiB, 1024 * kMiB, 16384 * kMiB}) {
    for (const int jobs : {1, 2, 4, 16}) {
      for (const std::size_t inputs : {1u, 3u, 16u, 5000u}) {
        const MemoryBudget budget = memoryBudget(bytes, jobs, inputs);
        const std::uint64_t worker = budget.openFiles * budget.bytesPerFile + budget.lattices * (kMiB / 4);
        const std::uint64_t all =
            budget.blockCacheBytes + static_cast<std::uint64_t>(jobs) * worker + budget.window * 4 * kMiB;
        if (bytes >= 200 * kMiB || jobs <= 2) {
          EXPECT_LE(all + 80 * kMiB, bytes) << bytes / kMiB << " MiB, " << jobs << " threads, " << inputs << " inputs";
        }
        EXPECT_GE(budget.openFiles, 1u);
        EXPECT_LE(budget.openFiles, inputs);
        EXPECT_GE(budget.window, 2u);
      }
    }
  }
}

TEST(BuildPlan, HeightStepIsAPowerOfTwo) {
  EXPECT_EQ(heightStepFor(1.0), 1.0 / 16);
  EXPECT_EQ(heightStepFor(0.5), 1.0 / 32);
  EXPECT_EQ(heightStepFor(0.3048), 1.0 / 64);
  EXPECT_EQ(heightStepFor(0.0), 0.0);
  EXPECT_EQ(heightStepFor(std::nan("")), 0.0);
}

}  // namespace
}  // namespace tellurion::pyramid::testing
