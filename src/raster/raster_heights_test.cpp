#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "raster/raster_fixture_test.h"

namespace tellurion::raster {
namespace {

using geo::Angle;
using testing::heightAt;
using testing::MadeRaster;
using testing::makeRaster;
using testing::openOrDie;
using testing::ScratchFolder;

/// 20 x 10 pixels of one degree from 10 E, 50 N.
MadeRaster oneDegree(std::function<double(int, int, int)> value) {
  return {.width = 20, .height = 10, .transform = {10, 1, 0, 50, 0, -1}, .value = std::move(value)};
}

/// The whole body in pixels of ten degrees, beginning at `west`.
MadeRaster tenDegreeWorld(double west, std::function<double(int, int, int)> value) {
  return {.width = 36, .height = 18, .transform = {west, 10, 0, 90, 0, -10}, .value = std::move(value)};
}

TEST(RasterHeights, InfoTellsWhatTheFileIs) {
  const ScratchFolder folder;
  auto made = oneDegree([](int, int col, int row) { return col + row; });
  made.type = GDT_Int16;
  makeRaster(folder.file("a.tif"), made);
  const auto file = openOrDie(folder.file("a.tif"), Kind::elevation);
  const RasterInfo& info = file.info();
  EXPECT_EQ(info.width, 20);
  EXPECT_EQ(info.height, 10);
  EXPECT_EQ(info.bands, 1);
  EXPECT_EQ(info.body, geo::earth());
  EXPECT_EQ(info.heightQuantum_m, 1.0);
  EXPECT_NEAR(info.bounds.south.degrees(), 40.0, 1e-9);
  EXPECT_NEAR(info.bounds.west.degrees(), 10.0, 1e-9);
  EXPECT_NEAR(info.bounds.width.degrees(), 20.0, 1e-9);
  // A degree of longitude is shortest, so counts, at each place; longest of them at the southern edge.
  EXPECT_NEAR(info.finestSpacing.degrees(), std::cos(Angle::degrees(41).radians()), 2e-4);
  EXPECT_TRUE(info.warnings.empty());
}

TEST(RasterHeights, MiddlesOfPixelsHoldTheStoredValues) {
  const ScratchFolder folder;
  makeRaster(folder.file("a.tif"), oneDegree([](int, int col, int row) { return 100.0 * row + col; }));
  auto file = openOrDie(folder.file("a.tif"), Kind::elevation);
  for (int row = 0; row < 10; ++row) {
    for (int col = 0; col < 20; ++col) {
      EXPECT_FLOAT_EQ(heightAt(file, 49.5 - row, 10.5 + col), static_cast<float>(100 * row + col));
    }
  }
}

TEST(RasterHeights, BilinearInsideClampedInTheOuterHalfPixelNothingOutside) {
  const ScratchFolder folder;
  makeRaster(folder.file("a.tif"),
             oneDegree([](int, int col, int row) { return 3.0 * (col + 0.5) - 7.0 * (row + 0.5); }));
  auto file = openOrDie(folder.file("a.tif"), Kind::elevation);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int i = 0; i < 5000; ++i) {
    const double lat = 45.0 + 5.5 * uniform(random);
    const double lon = 20.0 + 10.5 * uniform(random);
    const double col = std::clamp(lon - 10.0, 0.5, 19.5);
    const double row = std::clamp(50.0 - lat, 0.5, 9.5);
    const bool inside = lat >= 40.0 && lat <= 50.0 && lon >= 10.0 && lon <= 30.0;
    const float height = heightAt(file, lat, lon);
    ASSERT_EQ(std::isnan(height), !inside) << lat << " " << lon;
    if (inside) {
      ASSERT_NEAR(height, 3.0 * col - 7.0 * row, 1e-4);
    }
  }
  for (const double lon : {10.0, 30.0})
    EXPECT_FALSE(std::isnan(heightAt(file, 45.0, lon)));
  for (const double lat : {40.0, 50.0})
    EXPECT_FALSE(std::isnan(heightAt(file, lat, 20.0)));
}

TEST(RasterHeights, NothingIsWrittenWhereThereIsNoData) {
  const ScratchFolder folder;
  makeRaster(folder.file("a.tif"), oneDegree([](int, int, int) { return 5.0; }));
  auto file = openOrDie(folder.file("a.tif"), Kind::elevation);
  const std::array directions{geo::directionFromDegrees(0, 0), geo::directionFromDegrees(45, 20)};
  std::array<float, 2> out{-1.0f, -1.0f};
  ASSERT_TRUE(file.sampleHeights(directions, {}, out));
  EXPECT_EQ(out[0], -1.0f);
  EXPECT_EQ(out[1], 5.0f);
}

TEST(RasterHeights, NanDirectionsAndWrongCallsAreAnswered) {
  const ScratchFolder folder;
  makeRaster(folder.file("a.tif"), oneDegree([](int, int, int) { return 5.0; }));
  auto file = openOrDie(folder.file("a.tif"), Kind::elevation);
  const double nan = std::nan("");
  const std::array directions{geo::Direction{geo::Vec3(nan, 0, 0)}, geo::Direction{geo::Vec3(0, 0, nan)},
                              geo::Direction{geo::Vec3(0, 0, 0)}};
  std::array<float, 3> out{1.0f, 2.0f, 3.0f};
  ASSERT_TRUE(file.sampleHeights(directions, {}, out));
  ASSERT_TRUE(file.sampleHeights(directions, Angle::degrees(3), out));
  EXPECT_EQ(out, (std::array<float, 3>{1.0f, 2.0f, 3.0f}));
  EXPECT_FALSE(file.sampleHeights(directions, {}, std::span(out).first(2)));
  std::array<Rgba8, 3> colours{};
  EXPECT_FALSE(file.sampleColours(directions, {}, colours));
  EXPECT_TRUE(file.sampleHeights({}, {}, {}));
}

TEST(RasterHeights, NearestNoDataDecidesAndTheRestIsRenormalised) {
  const ScratchFolder folder;
  auto made = oneDegree([](int, int col, int row) { return col == 5 && row == 5 ? -9999.0 : 10.0 * col; });
  made.tune = [](GDALDataset& d) { d.GetRasterBand(1)->SetNoDataValue(-9999.0); };
  makeRaster(folder.file("a.tif"), made);
  auto file = openOrDie(folder.file("a.tif"), Kind::elevation);
  // The void's middle is at 15.5 E, 44.5 N and it reaches half a degree around.
  EXPECT_TRUE(std::isnan(heightAt(file, 44.5, 15.5)));
  EXPECT_TRUE(std::isnan(heightAt(file, 44.9, 15.9)));
  EXPECT_TRUE(std::isnan(heightAt(file, 44.5, 15.01)));
  EXPECT_FLOAT_EQ(heightAt(file, 44.5, 14.99), 40.0f);
  // A quarter of the way in between: weights of the three that are known.
  const double w00 = 0.6 * 0.4;  // at (col 4, row 4): the place is 0.4 of the way to col 5 and 0.6 of the way to row 5
  const double w10 = 0.4 * 0.4;
  const double w01 = 0.6 * 0.6;
  const double expected = (w00 * 40 + w10 * 50 + w01 * 40) / (w00 + w10 + w01);
  EXPECT_NEAR(heightAt(file, 45.5 - 0.6, 14.5 + 0.4), expected, 1e-4);
}

TEST(RasterHeights, EveryKindOfNoDataValue) {
  const ScratchFolder folder;
  constexpr double kInf = std::numeric_limits<double>::infinity();
  const struct {
    GDALDataType type;
    double tag;
    double stored;
  } cases[] = {{GDT_Float32, std::nan(""), std::nan("")},
               {GDT_Float32, -kInf, -kInf},
               {GDT_Float32, 7.0, kInf},
               {GDT_Float32, -3.40282e+38, -3.4028234663852886e+38},
               {GDT_Float32, 0.1, 0.1},
               {GDT_Float64, 0.1, 0.1},
               {GDT_Int16, -32768, -32768},
               {GDT_Int16, -32678, -32768},
               {GDT_Int16, 1e30, -32767},
               {GDT_UInt16, 65535, 65535},
               {GDT_Byte, 0, 0},
               {GDT_Int32, -2147483648.0, -2147483648.0}};
  int number = 0;
  for (const auto& c : cases) {
    SCOPED_TRACE(c.tag);
    auto made = oneDegree([&c](int, int col, int) { return col < 10 ? 5.0 : c.stored; });
    made.type = c.type;
    made.tune = [&c](GDALDataset& d) { d.GetRasterBand(1)->SetNoDataValue(c.tag); };
    const std::string path = folder.file("n" + std::to_string(number++) + ".tif");
    makeRaster(path, made);
    auto file = openOrDie(path, Kind::elevation);
    EXPECT_EQ(heightAt(file, 45.0, 19.9), 5.0f);
    EXPECT_TRUE(std::isnan(heightAt(file, 45.0, 20.1)));
  }
}

TEST(RasterHeights, UnmarkedVoidsAreWarnedOfOnce) {
  const ScratchFolder folder;
  auto made = oneDegree([](int, int col, int) { return col < 10 ? 5.0 : -32767.0; });
  made.type = GDT_Int16;
  makeRaster(folder.file("a.tif"), made);
  auto file = openOrDie(folder.file("a.tif"), Kind::elevation);
  EXPECT_TRUE(file.info().warnings.empty());
  for (int i = 0; i < 3; ++i)
    EXPECT_TRUE(std::isnan(heightAt(file, 45.0, 25.0)));
  ASSERT_EQ(file.info().warnings.size(), 1u);
  auto told = openOrDie(folder.file("a.tif"), Kind::elevation, {.nodata = -32767.0});
  EXPECT_TRUE(std::isnan(heightAt(told, 45.0, 25.0)));
  EXPECT_TRUE(told.info().warnings.empty());
}

TEST(RasterHeights, TheGivenNoDataValueReplacesTheFilesOwn) {
  const ScratchFolder folder;
  auto made = oneDegree([](int, int col, int) { return col < 10 ? 1.0 : 2.0; });
  made.tune = [](GDALDataset& d) { d.GetRasterBand(1)->SetNoDataValue(1.0); };
  makeRaster(folder.file("a.tif"), made);
  auto file = openOrDie(folder.file("a.tif"), Kind::elevation, {.nodata = 2.0});
  EXPECT_EQ(heightAt(file, 45.0, 15.0), 1.0f);
  EXPECT_TRUE(std::isnan(heightAt(file, 45.0, 25.0)));
}

TEST(RasterHeights, MasksAndAlphaAreNoData) {
  const ScratchFolder folder;
  auto masked = oneDegree([](int, int, int) { return 5.0; });
  masked.tune = [](GDALDataset& d) {
    ASSERT_EQ(d.CreateMaskBand(GMF_PER_DATASET), CE_None);
    std::vector<std::uint8_t> mask(200, 255);
    for (std::size_t i = 0; i < mask.size(); ++i)
      mask[i] = i % 20 < 10 ? 255 : 0;
    ASSERT_EQ(d.GetRasterBand(1)->GetMaskBand()->RasterIO(GF_Write, 0, 0, 20, 10, mask.data(), 20, 10, GDT_Byte, 0, 0,
                                                          nullptr),
              CE_None);
  };
  makeRaster(folder.file("mask.tif"), masked);
  MadeRaster alpha = oneDegree([](int band, int col, int) { return band == 1 ? 5.0 : col < 10 ? 255.0 : 0.0; });
  alpha.bands = 2;
  alpha.type = GDT_Byte;
  alpha.options = {"ALPHA=YES"};
  makeRaster(folder.file("alpha.tif"), alpha);
  for (const char* name : {"mask.tif", "alpha.tif"}) {
    auto file = openOrDie(folder.file(name), Kind::elevation);
    EXPECT_EQ(heightAt(file, 45.0, 15.0), 5.0f) << name;
    EXPECT_TRUE(std::isnan(heightAt(file, 45.0, 25.0))) << name;
  }
}

TEST(RasterHeights, ScaleOffsetAndUnitAreApplied) {
  const ScratchFolder folder;
  auto made = oneDegree([](int, int, int) { return 100.0; });
  made.type = GDT_Int16;
  made.tune = [](GDALDataset& d) {
    d.GetRasterBand(1)->SetScale(0.5);
    d.GetRasterBand(1)->SetOffset(-20.0);
  };
  makeRaster(folder.file("m.tif"), made);
  auto metres = openOrDie(folder.file("m.tif"), Kind::elevation);
  EXPECT_EQ(heightAt(metres, 45.0, 20.0), 30.0f);
  EXPECT_EQ(metres.info().heightQuantum_m, 0.5);
  made.tune = [](GDALDataset& d) { d.GetRasterBand(1)->SetUnitType("ft"); };
  makeRaster(folder.file("ft.tif"), made);
  auto feet = openOrDie(folder.file("ft.tif"), Kind::elevation);
  EXPECT_FLOAT_EQ(heightAt(feet, 45.0, 20.0), 30.48f);
  EXPECT_DOUBLE_EQ(feet.info().heightQuantum_m, 0.3048);
  made.tune = [](GDALDataset& d) { d.GetRasterBand(1)->SetUnitType("cubits"); };
  makeRaster(folder.file("c.tif"), made);
  auto cubits = openOrDie(folder.file("c.tif"), Kind::elevation);
  EXPECT_EQ(heightAt(cubits, 45.0, 20.0), 100.0f);
  EXPECT_EQ(cubits.info().warnings.size(), 1u);
}

TEST(RasterHeights, TheSeamOfAWorldRasterIsNoEdge) {
  const ScratchFolder folder;
  for (const double west : {-180.0, 0.0, -90.0, 175.0 - 360.0}) {
    SCOPED_TRACE(west);
    makeRaster(folder.file("w.tif"), tenDegreeWorld(west, [west](int, int col, int) {
                 return 1000.0 * std::cos(Angle::degrees(west + 10 * col + 5).radians());
               }));
    auto file = openOrDie(folder.file("w.tif"), Kind::elevation);
    EXPECT_NEAR(file.info().bounds.width.degrees(), 360.0, 1e-9);
    for (int i = -720; i <= 720; ++i) {
      const double lon = 0.5 * i;
      const double left = std::floor((lon - west - 5.0) / 10.0) * 10.0 + west + 5.0;
      const double s = (lon - left) / 10.0;
      const double expected = 1000.0 * ((1 - s) * std::cos(Angle::degrees(left).radians()) +
                                        s * std::cos(Angle::degrees(left + 10).radians()));
      ASSERT_NEAR(heightAt(file, 12.0, lon), expected, 1e-3) << lon;
    }
  }
}

TEST(RasterHeights, BeyondAPoleTheOtherSideGoesOn) {
  const ScratchFolder folder;
  // x of the unit vector: smooth across both poles.
  const auto xOf = [](double lat, double lon) {
    return 1000.0 * std::cos(Angle::degrees(lat).radians()) * std::cos(Angle::degrees(lon).radians());
  };
  MadeRaster made{
      .width = 360, .height = 180, .transform = {-180, 1, 0, 90, 0, -1}, .value = [&](int, int col, int row) {
        return xOf(89.5 - row, -179.5 + col);
      }};
  makeRaster(folder.file("pixel.tif"), made);
  made.width = 360;
  made.height = 181;
  made.transform = {-180.5, 1, 0, 90.5, 0, -1};
  made.value = [&](int, int col, int row) { return xOf(90.0 - row, -180.0 + col); };
  makeRaster(folder.file("point.tif"), made);
  for (const char* name : {"pixel.tif", "point.tif"}) {
    SCOPED_TRACE(name);
    auto file = openOrDie(folder.file(name), Kind::elevation);
    for (const double pole : {90.0, -90.0}) {
      EXPECT_NEAR(heightAt(file, pole, 0.0), 0.0, 0.5);
      for (int lon = -180; lon <= 180; lon += 7) {
        for (const double away : {0.01, 0.2, 0.4, 0.6, 1.3}) {
          const double lat = pole > 0 ? pole - away : pole + away;
          ASSERT_NEAR(heightAt(file, lat, lon), xOf(lat, lon), 0.5) << lat << " " << lon;
          const Angle side = Angle::degrees(1.5);
          ASSERT_NEAR(heightAt(file, lat, lon, side), xOf(lat, lon), 8.0) << lat << " " << lon;
        }
      }
    }
  }
}

TEST(RasterHeights, ARasterAcrossTheDateLine) {
  const ScratchFolder folder;
  for (const double west : {170.0, -190.0}) {
    makeRaster(folder.file("d.tif"),
               {.width = 20, .height = 10, .transform = {west, 1, 0, 5, 0, -1}, .value = [](int, int col, int) {
                  return 10.0 * (col + 0.5);
                }});
    auto file = openOrDie(folder.file("d.tif"), Kind::elevation);
    EXPECT_NEAR(file.info().bounds.west.degrees(), 170.0, 1e-9);
    EXPECT_NEAR(file.info().bounds.width.degrees(), 20.0, 1e-9);
    EXPECT_NEAR(heightAt(file, 0.0, 179.999), 99.99, 1e-3);
    EXPECT_NEAR(heightAt(file, 0.0, 180.0), 100.0, 1e-3);
    EXPECT_NEAR(heightAt(file, 0.0, -179.999), 100.01, 1e-3);
    EXPECT_NEAR(heightAt(file, 0.0, -170.0), 195.0, 1e-3);
    EXPECT_TRUE(std::isnan(heightAt(file, 0.0, -169.99)));
    EXPECT_TRUE(std::isnan(heightAt(file, 0.0, 169.99)));
  }
}

TEST(RasterHeights, SouthUpAndTurnedRasters) {
  const ScratchFolder folder;
  // Value is 10 lon + lat, whatever way the pixels run.
  const std::array transforms{std::array<double, 6>{10, 1, 0, 40, 0, 1}, std::array<double, 6>{30, -1, 0, 50, 0, -1},
                              std::array<double, 6>{10, 0.8, 0.3, 45, -0.2, -0.7}};
  for (const auto& t : transforms) {
    makeRaster(folder.file("t.tif"), {.width = 20, .height = 10, .transform = t, .value = [&](int, int col, int row) {
                                        const double x = col + 0.5;
                                        const double y = row + 0.5;
                                        return 10.0 * (t[0] + x * t[1] + y * t[2]) + t[3] + x * t[4] + y * t[5];
                                      }});
    auto file = openOrDie(folder.file("t.tif"), Kind::elevation);
    const double lon = t[0] + 7.3 * t[1] + 4.1 * t[2];
    const double lat = t[3] + 7.3 * t[4] + 4.1 * t[5];
    EXPECT_NEAR(heightAt(file, lat, lon), 10.0 * lon + lat, 1e-3);
    EXPECT_NEAR(heightAt(file, lat, lon, Angle::degrees(2)), 10.0 * lon + lat, 0.3);
  }
}

TEST(RasterHeights, ASampleDoesNotDependOnItsCompany) {
  const ScratchFolder folder;
  // 100 MB of samples: more than the cache of blocks holds.
  makeRaster(folder.file("big.tif"),
             {.width = 6000,
              .height = 4300,
              .transform = {0, 0.01, 0, 43, 0, -0.01},
              .options = {"TILED=YES"},
              .value = [](int, int col, int row) { return (col * 7919 + row * 104729) % 1000; }});
  auto file = openOrDie(folder.file("big.tif"), Kind::elevation);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<geo::Direction> directions;
  for (int i = 0; i < 20000; ++i) {
    directions.push_back(geo::directionFromDegrees(43.0 * uniform(random), 60.0 * uniform(random)));
  }
  for (const Angle footprint : {Angle(), Angle::degrees(0.025)}) {
    std::vector<float> whole(directions.size(), kNoData);
    ASSERT_TRUE(file.sampleHeights(directions, footprint, whole));
    std::vector<std::size_t> order(directions.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::sort(order, {}, [&](std::size_t i) { return directions[i].n.z; });
    for (const std::size_t i : order) {
      float alone = kNoData;
      ASSERT_TRUE(file.sampleHeights({&directions[i], 1}, footprint, {&alone, 1}));
      ASSERT_EQ(alone, whole[i]);
    }
  }
}

TEST(RasterHeights, MeansAreAreaWeightedAndNeedHalfTheSquare) {
  const ScratchFolder folder;
  auto made = oneDegree([](int, int col, int row) { return col < 10 ? 100.0 * row + col : -9999.0; });
  made.transform = {10, 1, 0, 5, 0, -1};  // Around the equator, where a square is nearly square in degrees.
  made.tune = [](GDALDataset& d) { d.GetRasterBand(1)->SetNoDataValue(-9999.0); };
  makeRaster(folder.file("a.tif"), made);
  auto file = openOrDie(folder.file("a.tif"), Kind::elevation);
  // Three pixels and two halves in each direction: a plane's mean is its value in the middle.
  EXPECT_NEAR(heightAt(file, 0.0, 14.5, Angle::degrees(4)), 100.0 * 4.5 + 4.0, 0.1);
  // Less than half of the square has data, then more.
  EXPECT_TRUE(std::isnan(heightAt(file, 0.0, 20.1, Angle::degrees(4))));
  EXPECT_NEAR(heightAt(file, 0.0, 19.9, Angle::degrees(4)), 450.0 + (0.1 * 7.0 + 8.0 + 9.0) / 2.1, 0.1);
  EXPECT_TRUE(std::isnan(heightAt(file, 0.0, 10.0, Angle::degrees(60))));
  // A square smaller than a pixel asks for the bilinear value.
  EXPECT_NEAR(heightAt(file, 0.3, 14.2, Angle::degrees(0.01)), heightAt(file, 0.3, 14.2), 1e-3);
}

TEST(RasterHeights, WideMeansComeFromOverviews) {
  const ScratchFolder folder;
  makeRaster(folder.file("o.tif"), {.width = 1024,
                                    .height = 1024,
                                    .transform = {0, 0.01, 0, 5.12, 0, -0.01},
                                    .value = [](int, int col, int row) { return (col + row) % 2 == 0 ? 10.0 : 30.0; }});
  auto* dataset = GDALDataset::Open(folder.file("o.tif").c_str(), GDAL_OF_UPDATE | GDAL_OF_RASTER);
  std::array factors{4, 16};
  ASSERT_EQ(dataset->BuildOverviews("AVERAGE", 2, factors.data(), 0, nullptr, nullptr, nullptr, nullptr), CE_None);
  // Marks the coarse overview, so that its use shows.
  std::vector<float> marked(64 * 64, 77.0f);
  ASSERT_EQ(dataset->GetRasterBand(1)->GetOverview(1)->RasterIO(GF_Write, 0, 0, 64, 64, marked.data(), 64, 64,
                                                                GDT_Float32, 0, 0, nullptr),
            CE_None);
  GDALClose(dataset);
  auto file = openOrDie(folder.file("o.tif"), Kind::elevation);
  EXPECT_NEAR(heightAt(file, 0.0, 5.0, Angle::degrees(0.06)), 20.0, 4.0);  // six pixels: from the raster itself
  EXPECT_NEAR(heightAt(file, 0.0, 5.0, Angle::degrees(0.1)), 20.0, 1e-3);  // ten: from the overview of a quarter
  EXPECT_NEAR(heightAt(file, 0.0, 5.0, Angle::degrees(0.4)), 77.0, 1e-3);  // forty: from that of a sixteenth
}

TEST(RasterHeights, OtherBodiesTakeLatitudeAndLongitudeAsTheyAre) {
  const ScratchFolder folder;
  auto made = oneDegree([](int, int col, int row) { return col + 100.0 * row; });
  made.reference = "+proj=longlat +R=3396190 +no_defs";
  makeRaster(folder.file("mars.tif"), made);
  auto mars = openOrDie(folder.file("mars.tif"), Kind::elevation);
  EXPECT_EQ(mars.info().body, geo::mars());
  EXPECT_FLOAT_EQ(heightAt(mars, 48.5, 13.5), 103.0f);
  made.reference = "+proj=longlat +R=250000 +no_defs";
  makeRaster(folder.file("small.tif"), made);
  const auto small = openOrDie(folder.file("small.tif"), Kind::elevation);
  EXPECT_EQ(small.info().body.ellipsoid, geo::Ellipsoid(250000.0, 0.0));
  made.reference = "";
  makeRaster(folder.file("plain.tif"), made);
  EXPECT_EQ(openOrDie(folder.file("plain.tif"), Kind::elevation).info().body, geo::earth());
  EXPECT_EQ(openOrDie(folder.file("plain.tif"), Kind::elevation).info().warnings.size(), 1u);
  auto moon = openOrDie(folder.file("plain.tif"), Kind::elevation, {.body = geo::moon()});
  EXPECT_EQ(moon.info().body, geo::moon());
  EXPECT_FLOAT_EQ(heightAt(moon, 48.5, 13.5), 103.0f);
}

TEST(RasterHeights, ABodyThatContradictsTheReferenceIsRefusedUnlessItIsEarths) {
  const ScratchFolder folder;
  auto made = oneDegree([](int, int col, int row) { return col + 100.0 * row; });
  makeRaster(folder.file("earth.tif"), made);
  auto mislabelled = openOrDie(folder.file("earth.tif"), Kind::elevation, {.body = geo::mars()});
  EXPECT_EQ(mislabelled.info().body, geo::mars());
  EXPECT_FLOAT_EQ(heightAt(mislabelled, 48.5, 13.5), 103.0f);
  ASSERT_EQ(mislabelled.info().warnings.size(), 1u);
  EXPECT_NE(mislabelled.info().warnings[0].find("leave --body out"), std::string::npos);
  made.reference = "+proj=longlat +R=3396190 +no_defs";
  makeRaster(folder.file("mars.tif"), made);
  for (const geo::Body& other : {geo::earth(), geo::moon()}) {
    const auto refused = RasterFile::open(folder.file("mars.tif"), Kind::elevation, {.body = other});
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("lies on mars"), std::string::npos) << refused.error().message;
  }
  EXPECT_TRUE(openOrDie(folder.file("mars.tif"), Kind::elevation, {.body = geo::mars()}).info().warnings.empty());
}

TEST(RasterHeights, ANoDataValueThatTheFileCannotHoldIsRefused) {
  const ScratchFolder folder;
  struct TypeCase {
    GDALDataType type;
    std::vector<double> fine;
    std::vector<double> refused;
  };
  const double nan = std::nan("");
  const std::vector<TypeCase> cases = {{GDT_Byte, {0, 255}, {-1, 256, 0.5, nan}},
                                       {GDT_Int16, {-32768, 32767}, {-99999, 40000, 0.5, nan, HUGE_VAL}},
                                       {GDT_Int32, {-2147483648.0}, {3e9, nan}},
                                       {GDT_Float32, {nan, -9999, 0.1, -3.4028235e38, HUGE_VAL}, {1e39}},
                                       {GDT_Float64, {nan, 0.1, 1e300}, {}}};
  int number = 0;
  for (const TypeCase& c : cases) {
    auto made = oneDegree([](int, int, int) { return 5.0; });
    made.type = c.type;
    const std::string path = folder.file("n" + std::to_string(number++) + ".tif");
    makeRaster(path, made);
    for (const Kind kind : {Kind::elevation, Kind::imagery}) {
      if (kind == Kind::elevation && c.type == GDT_Byte) continue;  // a grey picture
      for (const double value : c.fine)
        EXPECT_TRUE(RasterFile::open(path, kind, {.nodata = value})) << GDALGetDataTypeName(c.type) << " " << value;
      for (const double value : c.refused) {
        const auto refused = RasterFile::open(path, kind, {.nodata = value});
        ASSERT_FALSE(refused) << GDALGetDataTypeName(c.type) << " " << value;
        EXPECT_NE(refused.error().message.find("--nodata"), std::string::npos) << refused.error().message;
      }
    }
  }
}

TEST(RasterHeights, RadiiBecomeHeights) {
  const ScratchFolder folder;
  auto made = oneDegree([](int, int, int) { return 200.0; });
  made.type = GDT_Int16;
  made.reference = "+proj=longlat +R=1737400 +no_defs";
  made.tune = [](GDALDataset& d) {
    d.GetRasterBand(1)->SetScale(0.5);
    d.GetRasterBand(1)->SetOffset(1737400.0);
  };
  makeRaster(folder.file("radius.tif"), made);
  auto file = openOrDie(folder.file("radius.tif"), Kind::elevation);
  EXPECT_EQ(heightAt(file, 45.0, 20.0), 100.0f);
  EXPECT_EQ(file.info().warnings.size(), 1u);
}

}  // namespace
}  // namespace tellurion::raster
