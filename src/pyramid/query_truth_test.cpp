// Heights that are asked of a tile database, against GDAL's own bilinear sampling of the raster that it was built from.
//
// A leaf's sample is the source at the sample's place, bilinear between pixel centres, rounded to the stored step; a
// height inside a leaf's cell is bilinear between the cell's four samples. So the exact expectation is: GDAL's value at
// each of the four corners, bilinear between them, within half a step. How far that is from GDAL's value at the place
// itself is what resampling explains: both are means of the pixels that the cell touches, so it can be their relief.
#include <gdal_priv.h>
#include <gdalwarper.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <span>

#include "geo/seed_test.h"
#include "pyramid/height_query.h"
#include "pyramid/synthetic_rasters_test.h"

namespace tellurion::pyramid::testing {
namespace {

using tiling::Scheme;

constexpr int kCells = raster::kElevationCells;
constexpr int kMargin = 1;         ///< pixels around the copy of the source
constexpr double kFloat_m = 3e-4;  ///< rounding of a height to float32, below 9,000 m

struct PixelPlace {
  double col = 0.0;
  double row = 0.0;
};

/// GDAL's warper asks where its destination's pixels come from: pixel i from the i-th place.
int fromPlaces(void* places, int toSource, int count, double* x, double* y, double*, int* success) {
  const auto& list = *static_cast<const std::vector<PixelPlace>*>(places);
  for (int i = 0; i < count; ++i) {
    const auto index = static_cast<std::size_t>(std::clamp(x[i], 0.0, static_cast<double>(list.size() - 1)));
    success[i] = toSource;
    x[i] = list[index].col;
    y[i] = list[index].row;
  }
  return toSource;
}

/// A raster of latitude and longitude, sampled by GDAL's warper with its bilinear kernel.
class GdalSampler {
 public:
  explicit GdalSampler(const std::string& path) : grid_(readGrid(path)) {
    EXPECT_EQ(GDALInvGeoTransform(grid_.geotransform.data(), inverse_.data()), 1);
    isGlobal_ = std::abs(grid_.width * grid_.geotransform[1] - 360.0) < 1e-6;
    GDALDataset* source = GDALDataset::Open(path.c_str(), GDAL_OF_RASTER);
    int hasNoData = 0;
    const double noData = source->GetRasterBand(1)->GetNoDataValue(&hasNoData);
    if (hasNoData != 0) noData_ = noData;
    GDALClose(source);
    copy();
  }
  ~GdalSampler() { GDALClose(copy_); }
  GdalSampler(const GdalSampler&) = delete;
  GdalSampler& operator=(const GdalSampler&) = delete;

  const Grid& grid() const { return grid_; }

  PixelPlace pixelOf(const geo::Direction& place) const {
    const geo::Geodetic g = geo::geodeticFromDirection(place);
    PixelPlace p;
    std::array<double, 6> inverse = inverse_;
    GDALApplyGeoTransform(inverse.data(), g.lon.degrees(), g.lat.degrees(), &p.col, &p.row);
    return p;
  }
  /// Whether all four pixels whose centres are around the place have data.
  bool hasDataAround(const PixelPlace& place) const {
    const int col = static_cast<int>(std::floor(place.col - 0.5));
    const int row = static_cast<int>(std::floor(place.row - 0.5));
    return valueAt(col, row) && valueAt(col + 1, row) && valueAt(col, row + 1) && valueAt(col + 1, row + 1);
  }

  /// One value a place; undefined where there is no data around.
  std::vector<double> at(std::vector<PixelPlace> places) const {
    for (PixelPlace& p : places)
      p = {p.col + kMargin, p.row + kMargin};
    const auto count = static_cast<int>(places.size());
    GDALDataset* result = memory(count, 1);
    GDALWarpOptions* options = GDALCreateWarpOptions();
    options->hSrcDS = copy_;
    options->hDstDS = result;
    options->eResampleAlg = GRA_Bilinear;
    options->eWorkingDataType = GDT_Float64;
    GDALWarpInitDefaultBandMapping(options, 1);
    options->pfnTransformer = fromPlaces;
    options->pTransformerArg = &places;
    // One chunk, the whole source, and the plain kernel of four pixels: the destination is no picture of the source.
    options->papszWarpOptions = CSLSetNameValue(options->papszWarpOptions, "SOURCE_EXTRA", "100000");
    options->papszWarpOptions = CSLSetNameValue(options->papszWarpOptions, "XSCALE", "1");
    options->papszWarpOptions = CSLSetNameValue(options->papszWarpOptions, "YSCALE", "1");
    GDALWarpOperation operation;
    EXPECT_EQ(operation.Initialize(options), CE_None);
    EXPECT_EQ(operation.WarpRegion(0, 0, count, 1), CE_None);
    std::vector<double> values(places.size());
    EXPECT_EQ(result->GetRasterBand(1)->RasterIO(GF_Read, 0, 0, count, 1, values.data(), count, 1, GDT_Float64, 0, 0,
                                                 nullptr),
              CE_None);
    GDALDestroyWarpOptions(options);
    GDALClose(result);
    return values;
  }

 private:
  static GDALDataset* memory(int width, int height) {
    auto* driver = GetGDALDriverManager()->GetDriverByName("MEM");
    return driver->Create("", width, height, 1, GDT_Float64, nullptr);
  }
  /// A global raster goes on across the date line and, half a turn away, across the poles.
  std::optional<double> valueAt(int col, int row) const {
    const bool isAcross = row < 0 || row >= grid_.height;
    const bool isBeside = col < 0 || col >= grid_.width;
    if (!isGlobal_ && (isAcross || isBeside)) return std::nullopt;
    if (isAcross) col += grid_.width / 2;
    const int inside = row < 0 ? -1 - row : row >= grid_.height ? 2 * grid_.height - 1 - row : row;
    const double value = grid_.at(col, inside);
    return value == noData_ ? std::nullopt : std::optional(value);
  }
  void copy() {
    const int width = grid_.width + 2 * kMargin;
    const int height = grid_.height + 2 * kMargin;
    std::vector<double> values;
    for (int row = -kMargin; row < height - kMargin; ++row) {
      for (int col = -kMargin; col < width - kMargin; ++col)
        values.push_back(valueAt(col, row).value_or(0.0));  // places beside gaps are not asked
    }
    copy_ = memory(width, height);
    EXPECT_EQ(copy_->GetRasterBand(1)->RasterIO(GF_Write, 0, 0, width, height, values.data(), width, height,
                                                GDT_Float64, 0, 0, nullptr),
              CE_None);
  }

  Grid grid_;
  std::array<double, 6> inverse_{};
  bool isGlobal_ = false;
  std::optional<double> noData_;
  GDALDataset* copy_ = nullptr;
};

/// A place, and the four corners of the leaf's cell around it as the source's pixels.
struct Asked {
  geo::Direction place;
  double height_m = 0.0;
  std::array<PixelPlace, 4> corners{};
  double s = 0.0;
  double t = 0.0;
};

Asked cellAround(const tiling::Tiling& tiling, const GdalSampler& source, const geo::Direction& place, int level) {
  const tiling::RootPoint p = tiling.rootPoint(place);
  const double perRoot = std::exp2(level) * kCells;
  const double column = std::clamp(std::floor(p.u * perRoot), 0.0, perRoot - 1.0);
  const double row = std::clamp(std::floor(p.v * perRoot), 0.0, perRoot - 1.0);
  Asked asked{.place = place, .s = p.u * perRoot - column, .t = p.v * perRoot - row};
  for (std::size_t i = 0; i < 4; ++i) {
    const double u = (column + static_cast<double>(i & 1u)) / perRoot;
    const double v = (row + static_cast<double>(i >> 1u)) / perRoot;
    asked.corners[i] = source.pixelOf(tiling.direction({p.root, u, v}));
  }
  return asked;
}

double between(const Asked& asked, std::span<const double> corners) {
  const double top = corners[0] * (1 - asked.s) + corners[1] * asked.s;
  const double bottom = corners[2] * (1 - asked.s) + corners[3] * asked.s;
  return top * (1 - asked.t) + bottom * asked.t;
}

/// Uniform over the raster's part of the sphere, and the poles and the date line where it has them.
std::vector<geo::Direction> placesOn(const Grid& grid, int count) {
  const auto& t = grid.geotransform;
  auto random = geo::seededGenerator();
  const auto sine = [](double degrees) { return geo::sinCosDegrees(degrees).sin; };
  std::vector<geo::Direction> places;
  for (int i = 0; i < count; ++i) {
    const double z = geo::uniform(random, sine(t[3] + t[5] * grid.height), sine(t[3]));
    const double lon = geo::uniform(random, t[0], t[0] + t[1] * grid.width);
    places.push_back(geo::directionFromDegrees(std::asin(z) * 180.0 / geo::kPi, lon));
  }
  if (t[3] < 90.0) return places;
  for (int i = 0; i < 100; ++i) {
    const double lon = geo::uniform(random, -180.0, 180.0);
    places.push_back(geo::directionFromDegrees(90.0 - std::pow(10.0, geo::uniform(random, -6.0, 0.0)), lon));
    places.push_back(geo::directionFromDegrees(-90.0 + std::pow(10.0, geo::uniform(random, -6.0, 0.0)), lon));
    places.push_back(geo::directionFromDegrees(0.5 * lon, 180.0));
  }
  places.push_back(geo::directionFromDegrees(90.0, 0.0));
  places.push_back(geo::directionFromDegrees(-90.0, 0.0));
  return places;
}

struct Source {
  const char* file;
  int places;  ///< tried; at least 3000 must be away from gaps and from the raster's own edge
};

class QueryTruth : public ::testing::TestWithParam<std::tuple<Source, Scheme>> {};

TEST_P(QueryTruth, IsGdalsBilinearBetweenTheCornersOfALeafsCell) {
  const auto& [data, scheme] = GetParam();
  const std::string path = std::string(TELLURION_SOURCE_DIR "/data/") + data.file;
  const TemporaryFolder folder;
  BuildOptions options{.output = folder / "t.tdb", .inputs = {path}, .kind = raster::Kind::elevation, .scheme = scheme};
  const auto reader = builtPyramid(options);
  ASSERT_NE(reader, nullptr);
  const auto summary = reader->summary();
  ASSERT_TRUE(summary.has_value());
  auto query = HeightQuery::create(reader);
  ASSERT_TRUE(query.has_value());
  const GdalSampler source(path);
  const tiling::Tiling tiling(scheme);

  std::vector<Asked> asked;
  std::vector<PixelPlace> pixels;
  for (const geo::Direction& place : placesOn(source.grid(), data.places)) {
    const auto answer = query->at(place);
    ASSERT_TRUE(answer.has_value());
    if (!*answer) continue;
    Asked one = cellAround(tiling, source, place, (*answer)->level);
    one.height_m = (*answer)->height_m;
    if (!std::ranges::all_of(one.corners, [&](const PixelPlace& p) { return source.hasDataAround(p); })) continue;
    asked.push_back(one);
    pixels.insert(pixels.end(), one.corners.begin(), one.corners.end());
    pixels.push_back(source.pixelOf(place));
  }
  const std::vector<double> values = source.at(pixels);
  const double bound_m = 0.5 * summary->heightStep_m + kFloat_m;
  EXPECT_LE(bound_m, 0.032);  // a 30th of what the source's whole metres can tell
  double worst = 0.0;
  double worstOfAll = 0.0;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    const std::span<const double> corners(&values[5 * i], 4);
    const double difference = std::abs(asked[i].height_m - between(asked[i], corners));
    worst = std::max(worst, difference);
    worstOfAll = std::max(worstOfAll, std::abs(asked[i].height_m - values[5 * i + 4]));
    const geo::Geodetic g = geo::geodeticFromDirection(asked[i].place);
    ASSERT_LE(difference, bound_m) << "latitude " << g.lat.degrees() << " longitude " << g.lon.degrees();
  }
  EXPECT_GE(asked.size(), 3000U);
  std::printf("%zu places: %.4f m from GDAL between a cell's corners at most (bound %.4f), %.1f m from GDAL there\n",
              asked.size(), worst, bound_m, worstOfAll);
}

INSTANTIATE_TEST_SUITE_P(RealRasters, QueryTruth,
                         ::testing::Combine(::testing::Values(Source{"earth/etopo5_dem_10min.tif", 4000},
                                                              Source{"earth/srtm3_everest_N27E086_filled.tif", 4000},
                                                              Source{"mars/mola_dem_4ppd.tif", 4000}),
                                            ::testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix)),
                         [](const auto& param) {
                           const std::string file = std::get<0>(param.param).file;
                           const std::string stem = file.substr(file.find('/') + 1);
                           return stem.substr(0, stem.find('_')) + "_" +
                                  std::string(tiling::nameOf(std::get<1>(param.param)));
                         });

}  // namespace
}  // namespace tellurion::pyramid::testing
