// Against what PROJ's own program says, and GDAL's grids read plainly.
#include "raster/vertical_datum.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <random>

#include "geo/seed_test.h"
#include "raster/raster_fixture_test.h"

namespace tellurion::raster {
namespace {

using testing::makeRaster;
using testing::ScratchFolder;

const std::string kEgm96File = TELLURION_SHARED_DATA_DIR "/earth/egm96_geoid_15min.tif";

double zeroAt(VerticalDatum& datum, double lat, double lon) {
  const std::array places{geo::directionFromDegrees(lat, lon)};
  std::array<double, 1> out{};
  const auto ok = datum.heightsOfZero(places, out);
  EXPECT_TRUE(ok) << io::describe(ok.error());
  return out[0];
}

std::optional<VerticalDatum> opened(const std::string& name, const geo::Body& body = geo::earth()) {
  auto datum = VerticalDatum::open(name, body, geo::GeoRect::whole());
  if (datum) return std::move(*datum);
  EXPECT_EQ(datum.error().code, io::Failure::Code::notFound) << io::describe(datum.error());
  return std::nullopt;
}

/// Heights above WGS 84 of EGM96's zero at places, as cs2cs prints them; empty where it is not installed.
std::vector<double> ofCs2cs(const std::string& input, std::size_t count) {
  const std::string command = "cs2cs -f %.6f EPSG:4326+5773 EPSG:4979 " + input + " 2>/dev/null";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(::popen(command.c_str(), "r"), ::pclose);
  std::vector<double> heights;
  double lat = 0.0;
  double lon = 0.0;
  double height = 0.0;
  while (pipe && heights.size() < count && std::fscanf(pipe.get(), "%lf %lf %lf", &lat, &lon, &height) == 3)
    heights.push_back(height);
  return heights;
}

TEST(VerticalDatum, Egm96IsWhatPROJsProgramSaysByNameByCodeAndFromAFile) {
  auto byName = opened("egm96");
  if (!byName) GTEST_SKIP() << "PROJ's grid of EGM96 is not installed";
  auto byCode = opened("EPSG:5773");
  ASSERT_TRUE(byCode.has_value());
  ASSERT_EQ(byName->files().size(), 1u);

  const unsigned seed = geo::testSeed();
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> lat(-90.0, 90.0);
  std::uniform_real_distribution<double> lon(-180.0, 180.0);
  std::vector<std::pair<double, double>> places{{90, 0}, {-90, 0}, {0, 180}, {0, -180}, {27.9881, 86.925}, {0, 0}};
  while (places.size() < 500)
    places.emplace_back(lat(random), lon(random));
  const ScratchFolder folder;
  const std::unique_ptr<FILE, int (*)(FILE*)> file(std::fopen(folder.file("places").c_str(), "w"), std::fclose);
  for (const auto& [north, east] : places)
    std::fprintf(file.get(), "%.12f %.12f 0\n", north, east);
  std::fflush(file.get());
  const auto expected = ofCs2cs(folder.file("places"), places.size());
  if (expected.empty()) GTEST_SKIP() << "cs2cs is not installed";
  ASSERT_EQ(expected.size(), places.size());
  const bool hasFile = std::filesystem::exists(kEgm96File);
  auto byFile = hasFile ? opened(kEgm96File) : std::nullopt;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto [north, east] = places[i];
    EXPECT_NEAR(zeroAt(*byName, north, east), expected[i], 2e-6) << north << " " << east;
    EXPECT_NEAR(zeroAt(*byCode, north, east), expected[i], 2e-6) << north << " " << east;
    // The same model's values from another maker; interpolated in 32 bits here, and near a pole by other neighbours.
    if (byFile) {
      EXPECT_NEAR(zeroAt(*byFile, north, east), expected[i], 0.02) << north << " " << east;
    }
  }
}

TEST(VerticalDatum, AMissingGridIsNamedAndHeightsAreNotTakenAsTheyAre) {
  auto datum = VerticalDatum::open("egm2008", geo::earth(), geo::GeoRect::whole());
  if (datum) GTEST_SKIP() << "the grid of EGM2008 is installed here";
  EXPECT_EQ(datum.error().code, io::Failure::Code::notFound);
  EXPECT_NE(datum.error().message.find("us_nga_egm08_25.tif"), std::string::npos) << datum.error().message;
  EXPECT_NE(datum.error().message.find("--vertical-datum FILE"), std::string::npos) << datum.error().message;
}

TEST(VerticalDatum, WhatIsNoVerticalReferenceIsRefused) {
  const auto code = [](const std::string& name, const geo::Body& body = geo::earth()) {
    const auto datum = VerticalDatum::open(name, body, geo::GeoRect::whole());
    EXPECT_FALSE(datum.has_value()) << name;
    return datum ? io::Failure::Code::cancelled : datum.error().code;
  };
  EXPECT_EQ(code("EPSG:4326"), io::Failure::Code::invalidArgument);
  EXPECT_EQ(code("EPSG:99999"), io::Failure::Code::invalidArgument);
  EXPECT_EQ(code("EPSG:"), io::Failure::Code::invalidArgument);
  EXPECT_EQ(code("no such file"), io::Failure::Code::notFound);
  EXPECT_EQ(code("egm96", geo::mars()), io::Failure::Code::invalidArgument);
}

TEST(VerticalDatum, AGridOfAnyBodyIsInterpolatedAndItsBorderIsNotCrossed) {
  const ScratchFolder folder;
  makeRaster(folder.file("areoid.tif"),
             {.width = 20, .height = 10, .transform = {10, 1, 0, 20, 0, -1}, .value = [](int, int c, int r) {
                return 3.0 * c - 2.0 * r;
              }});
  auto datum = opened(folder.file("areoid.tif"), geo::mars());
  ASSERT_TRUE(datum.has_value());
  EXPECT_NEAR(zeroAt(*datum, 15.0, 20.0), 3.0 * 9.5 - 2.0 * 4.5, 1e-5);
  const std::array outside{geo::directionFromDegrees(15.0, 20.0), geo::directionFromDegrees(5.0, 20.0)};
  std::array<double, 2> out{};
  const auto refused = datum->heightsOfZero(outside, out);
  ASSERT_FALSE(refused.has_value());
  EXPECT_NE(refused.error().message.find("5.0000,20.0000"), std::string::npos) << refused.error().message;
}

}  // namespace
}  // namespace tellurion::raster
