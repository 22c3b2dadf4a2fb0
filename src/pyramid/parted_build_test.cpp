// A build cut into parts: joined, they are the same bytes as one process's build.
#include "pyramid/parted_build.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <random>
#include <thread>

#include "geo/seed_test.h"
#include "pyramid/synthetic_rasters_test.h"
#include "pyramid/verify.h"

namespace tellurion::pyramid::testing {
namespace {

namespace fs = std::filesystem;
using tiling::Scheme;

class PartedBuildTest : public ::testing::TestWithParam<Scheme> {
 protected:
  BuildOptions elevation(const std::string& name) const {
    const fs::path coarse = folder_ / "globe.tif";
    const fs::path fine = folder_ / "fine.tif";
    if (!fs::exists(fine)) {
      writeHillyGlobe(coarse);
      writeElevation(fine, degreesGrid(7, 45, 9, 47, 30, 30), [](int c, int r) { return 800.0 + c * 30 - r * 10; });
    }
    BuildOptions options;
    options.output = folder_ / name;
    options.inputs = {coarse.string(), fine.string()};
    options.scheme = GetParam();
    options.jobs = 2;
    return options;
  }
  /// With a hole, so that there are pieces and tiles without data.
  BuildOptions imagery(const std::string& name) const {
    const fs::path path = folder_ / "colours.tif";
    if (!fs::exists(path)) {
      writeColour(path, degreesGrid(-30, -20, 60, 70, 420, 420), [](int c, int r) {
        const bool isHole = c > 90 && c < 280 && r > 70 && r < 330;
        return raster::Rgba8{static_cast<std::uint8_t>(c), static_cast<std::uint8_t>(r),
                             static_cast<std::uint8_t>(c * r / 3), static_cast<std::uint8_t>(isHole ? 0 : 255)};
      });
    }
    BuildOptions options;
    options.output = folder_ / name;
    options.inputs = {path.string()};
    options.kind = raster::Kind::imagery;
    options.scheme = GetParam();
    options.jobs = 2;
    return options;
  }
  /// All parts in some order, joined; the names of the shards.
  std::vector<fs::path> makeAll(const PartedBuild& build) const {
    fs::create_directories(build.folder());
    std::vector<std::size_t> order(build.parts().size());
    std::vector<fs::path> shards;
    for (std::size_t i = 0; i < order.size(); ++i) {
      order[i] = i;
      shards.push_back(build.shard(i));
    }
    std::mt19937 random(geo::testSeed());
    std::ranges::shuffle(order, random);
    std::ranges::shuffle(shards, random);
    for (const std::size_t part : order) {
      const auto made = build.make(part);
      EXPECT_TRUE(made.has_value()) << io::describe(made.error());
    }
    return shards;
  }
  /// The build's options, but for the output's name.
  void expectTheSame(const BuildOptions& whole, const BuildOptions& parted) const {
    ASSERT_NE(builtPyramid(whole), nullptr);
    const auto build = PartedBuild::plan(parted);
    ASSERT_TRUE(build.has_value()) << io::describe(build.error());
    EXPECT_GT(build->parts().size(), 1u);
    const auto shards = makeAll(*build);
    const auto merged = mergeShards({.output = parted.output, .shards = shards, .jobs = 1});
    ASSERT_TRUE(merged.has_value()) << io::describe(merged.error());
    EXPECT_TRUE(bytesOf(whole.output) == bytesOf(parted.output));
  }
  TemporaryFolder folder_;
};

TEST_P(PartedBuildTest, ElevationInPartsIsTheSameBytes) {
  BuildOptions whole = elevation("whole.tdb");
  BuildOptions parted = elevation("parted.tdb");
  whole.fillVoids_m = parted.fillVoids_m = 0.0;
  expectTheSame(whole, parted);
}

// Finer heights move coarser ones, of other parts too.
TEST_P(PartedBuildTest, FilledElevationInPartsIsTheSameBytes) {
  expectTheSame(elevation("whole.tdb"), elevation("parted.tdb"));
}

TEST_P(PartedBuildTest, ImageryInPartsIsTheSameBytes) {
  expectTheSame(imagery("whole.tdb"), imagery("parted.tdb"));
}

// Every option comes back out of a shard: its build's key is the same.
TEST_P(PartedBuildTest, OptionsAreInTheShards) {
  BuildOptions parted = elevation("parted.tdb");
  parted.body = geo::earth();
  parted.maxLevel = 4;
  parted.nodata = -12345.0;
  parted.fillVoids_m = 5000.0;
  parted.maxError_m = 0.5;
  parted.region = geo::GeoRect::fromDegrees(-50.1, 100.2, 50.3, -170.4);
  parted.inputs.pop_back();
  BuildOptions whole = parted;
  whole.output = folder_ / "whole.tdb";
  expectTheSame(whole, parted);
  BuildOptions pictures = imagery("pictures.tdb");
  pictures.inputs.push_back(pictures.inputs.front());
  pictures.format = TileFormat::webp;
  pictures.cleaning = {.matchColours = true, .feather_m = 20000.0, .cutAt = {}, .clouds = true};
  whole = pictures;
  whole.output = folder_ / "wholePictures.tdb";
  expectTheSame(whole, pictures);
}

TEST_P(PartedBuildTest, AStoppedMergeAndAStoppedPartGoOnWithTheSameBytes) {
  ASSERT_NE(builtPyramid(imagery("whole.tdb")), nullptr);
  const BuildOptions parted = imagery("parted.tdb");
  const auto build = PartedBuild::plan(parted);
  ASSERT_TRUE(build.has_value());
  fs::create_directories(build->folder());
  std::stop_source stopped;
  stopped.request_stop();
  const auto part = build->make(0, stopped.get_token());
  ASSERT_FALSE(part.has_value());
  EXPECT_EQ(part.error().code, io::Failure::Code::cancelled);
  const auto shards = makeAll(*build);
  std::mt19937 random(geo::testSeed());
  io::Result<BuildReport> joined = io::fail(io::Failure::Code::cancelled, "");
  int runs = 0;
  for (; !joined && runs < 100; ++runs) {
    std::stop_source stop;
    if (runs == 0) stop.request_stop();  // once at least, however fast the machine
    const std::jthread impatient(
        [&, patience = std::chrono::milliseconds(random() % 10u + 4u * static_cast<unsigned>(runs))] {
          std::this_thread::sleep_for(patience);
          stop.request_stop();
        });
    joined = build->join(shards, {}, stop.get_token());
    if (!joined) {
      ASSERT_EQ(joined.error().code, io::Failure::Code::cancelled) << io::describe(joined.error());
    }
  }
  EXPECT_GT(runs, 1);
  EXPECT_TRUE(bytesOf(folder_ / "whole.tdb") == bytesOf(parted.output));
}

TEST_P(PartedBuildTest, WhatIsNoPartOfTheBuildIsNamed) {
  const BuildOptions parted = imagery("parted.tdb");
  const auto build = PartedBuild::plan(parted);
  ASSERT_TRUE(build.has_value());
  auto shards = makeAll(*build);
  const auto message = [&](const std::vector<fs::path>& some) {
    const auto merged = mergeShards({.output = parted.output, .shards = some});
    EXPECT_FALSE(merged.has_value());
    return merged ? std::string() : io::describe(merged.error());
  };
  EXPECT_NE(message({shards.begin() + 2, shards.end()}).find("2 of the build's"), std::string::npos);
  auto twice = shards;
  fs::copy_file(shards.front(), folder_ / "copy.tdb");
  twice.push_back(folder_ / "copy.tdb");
  EXPECT_NE(message(twice).find("the same part"), std::string::npos);
  BuildOptions other = imagery("other.tdb");
  other.format = TileFormat::png;
  const auto otherBuild = PartedBuild::plan(other);
  ASSERT_TRUE(otherBuild.has_value());
  fs::create_directories(otherBuild->folder());
  ASSERT_TRUE(otherBuild->make(0).has_value());
  auto mixed = shards;
  mixed.back() = otherBuild->shard(0);
  EXPECT_NE(message(mixed).find("of another build"), std::string::npos);
  ASSERT_NE(builtPyramid(imagery("whole.tdb")), nullptr);
  EXPECT_NE(message({folder_ / "whole.tdb"}).find("finished tile database"), std::string::npos);
  // A shard opened as a database says what it is.
  const auto reader = PyramidReader::open(shards.front());
  ASSERT_FALSE(reader.has_value());
  EXPECT_NE(reader.error().message.find("merge"), std::string::npos) << reader.error().message;
  // A damaged tile is found, and its shard named.
  const auto largest = *std::ranges::max_element(shards, {}, [](const fs::path& p) { return fs::file_size(p); });
  std::string bytes = bytesOf(largest);
  for (std::size_t i = bytes.size() / 2; i < bytes.size() / 2 + 4096; ++i)
    bytes[i] = static_cast<char>(bytes[i] ^ 0x55);
  std::ofstream(largest, std::ios::binary) << bytes;
  EXPECT_NE(message(shards).find(largest.filename().string()), std::string::npos);
  EXPECT_FALSE(fs::exists(parted.output));
}

TEST_P(PartedBuildTest, SharesAreMadeAndJoinedByWhoeverComes) {
  const auto whole = builtPyramid(imagery("whole.tdb"));
  ASSERT_NE(whole, nullptr);
  const BuildOptions parted = imagery("parted.tdb");
  const PartsSink untold{};
  ASSERT_TRUE(buildShare(parted, 1, 3, untold).has_value());
  EXPECT_FALSE(fs::exists(parted.output));
  const auto together = buildTogether(parted, untold);
  ASSERT_TRUE(together.has_value()) << io::describe(together.error());
  EXPECT_TRUE(bytesOf(folder_ / "whole.tdb") == bytesOf(parted.output));
  EXPECT_FALSE(fs::exists(folder_ / "parted.tdb.parts")) << "what is joined is in the way";
  const auto again = buildTogether(parted, untold);
  ASSERT_TRUE(again.has_value());
  EXPECT_TRUE(again->alreadyComplete);
  BuildOptions append = parted;
  append.append = true;
  EXPECT_FALSE(buildTogether(append, untold).has_value());
}

INSTANTIATE_TEST_SUITE_P(Tilings, PartedBuildTest, ::testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

}  // namespace
}  // namespace tellurion::pyramid::testing
