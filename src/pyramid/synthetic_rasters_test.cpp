#include "pyramid/synthetic_rasters_test.h"

#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogr_spatialref.h>

#include <atomic>
#include <cmath>
#include <fstream>
#include <sstream>

namespace tellurion::pyramid::testing {
namespace {

struct DatasetCloser {
  void operator()(GDALDataset* dataset) const { GDALClose(dataset); }
};
using DatasetPointer = std::unique_ptr<GDALDataset, DatasetCloser>;

GDALDataType gdalType(SampleType type) {
  switch (type) {
    case SampleType::int16:
      return GDT_Int16;
    case SampleType::float32:
      return GDT_Float32;
    case SampleType::byte:
      return GDT_Byte;
  }
  return GDT_Unknown;
}

DatasetPointer created(const std::filesystem::path& path, const GridSpec& spec, int bands) {
  GDALAllRegister();
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  DatasetPointer dataset(driver->Create(path.c_str(), spec.width, spec.height, bands, gdalType(spec.type), nullptr));
  std::array<double, 6> transform = spec.geotransform;
  dataset->SetGeoTransform(transform.data());
  if (spec.reference.empty()) return dataset;
  OGRSpatialReference reference;
  reference.SetFromUserInput(spec.reference.c_str());
  dataset->SetSpatialRef(&reference);
  return dataset;
}

void writeBand(GDALDataset& dataset, int band, const GridSpec& spec, const std::function<double(int, int)>& value) {
  std::vector<double> row(static_cast<std::size_t>(spec.width));
  for (int r = 0; r < spec.height; ++r) {
    for (int c = 0; c < spec.width; ++c)
      row[static_cast<std::size_t>(c)] = value(c, r);
    const CPLErr result = dataset.GetRasterBand(band)->RasterIO(GF_Write, 0, r, spec.width, 1, row.data(), spec.width,
                                                                1, GDT_Float64, 0, 0, nullptr);
    ASSERT_EQ(result, CE_None);
  }
}

}  // namespace

TemporaryFolder::TemporaryFolder() {
  static std::atomic<int> count{0};
  const auto stamp = std::chrono::steady_clock::now().time_since_epoch().count();
  path_ = std::filesystem::temp_directory_path() /
          ("tellurion_pyramid_" + std::to_string(stamp) + "_" + std::to_string(++count));
  std::filesystem::create_directories(path_);
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code error;
  std::filesystem::remove_all(path_, error);
}

GridSpec degreesGrid(double west, double south, double east, double north, int width, int height) {
  GridSpec spec;
  spec.width = width;
  spec.height = height;
  spec.geotransform = {west, (east - west) / width, 0.0, north, 0.0, (south - north) / height};
  return spec;
}

void writeElevation(const std::filesystem::path& path, const GridSpec& spec,
                    const std::function<double(int, int)>& value) {
  const DatasetPointer dataset = created(path, spec, 1);
  if (spec.nodata) dataset->GetRasterBand(1)->SetNoDataValue(*spec.nodata);
  writeBand(*dataset, 1, spec, value);
}

void writeColour(const std::filesystem::path& path, const GridSpec& spec,
                 const std::function<raster::Rgba8(int, int)>& colour) {
  GridSpec bytes = spec;
  bytes.type = SampleType::byte;
  const DatasetPointer dataset = created(path, bytes, 4);
  const std::array<GDALColorInterp, 4> meanings = {GCI_RedBand, GCI_GreenBand, GCI_BlueBand, GCI_AlphaBand};
  for (int band = 1; band <= 4; ++band) {
    dataset->GetRasterBand(band)->SetColorInterpretation(meanings[static_cast<std::size_t>(band - 1)]);
    writeBand(*dataset, band, bytes, [&](int column, int row) {
      const raster::Rgba8 c = colour(column, row);
      return static_cast<double>(std::array{c.r, c.g, c.b, c.a}[static_cast<std::size_t>(band - 1)]);
    });
  }
}

double Grid::at(int column, int row) const {
  const int wrapped = ((column % width) + width) % width;
  const int clamped = std::clamp(row, 0, height - 1);
  return values[static_cast<std::size_t>(clamped) * static_cast<std::size_t>(width) +
                static_cast<std::size_t>(wrapped)];
}

double Grid::bilinear(double lat, double lon) const {
  const double x = (lon - geotransform[0]) / geotransform[1] - 0.5;
  const double y = (lat - geotransform[3]) / geotransform[5] - 0.5;
  const int column = static_cast<int>(std::floor(x));
  const int row = static_cast<int>(std::floor(y));
  const double s = x - column;
  const double t = y - row;
  return (at(column, row) * (1 - s) + at(column + 1, row) * s) * (1 - t) +
         (at(column, row + 1) * (1 - s) + at(column + 1, row + 1) * s) * t;
}

Grid readGrid(const std::filesystem::path& path) {
  GDALAllRegister();
  const DatasetPointer dataset(GDALDataset::FromHandle(GDALOpen(path.c_str(), GA_ReadOnly)));
  Grid grid;
  if (!dataset) return grid;
  grid.width = dataset->GetRasterXSize();
  grid.height = dataset->GetRasterYSize();
  dataset->GetGeoTransform(grid.geotransform.data());
  grid.values.resize(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height));
  const CPLErr result = dataset->GetRasterBand(1)->RasterIO(GF_Read, 0, 0, grid.width, grid.height, grid.values.data(),
                                                            grid.width, grid.height, GDT_Float64, 0, 0, nullptr);
  EXPECT_EQ(result, CE_None);
  return grid;
}

double hills(double lat, double lon) {
  const geo::Vec3 n = geo::directionFromDegrees(lat, lon).n;
  return 2500.0 * std::sin(9.0 * n.x + 2.0) * std::cos(7.0 * n.y) + 1500.0 * std::sin(31.0 * n.z + 17.0 * n.x * n.y);
}

std::string writeHillyGlobe(const std::filesystem::path& path) {
  writeElevation(path, degreesGrid(-180, -90, 180, 90, 720, 360),
                 [](int c, int r) { return std::round(hills(89.75 - 0.5 * r, -179.75 + 0.5 * c)); });
  return path.string();
}

std::vector<tiling::TileId> storedTiles(const PyramidReader& reader) {
  std::vector<tiling::TileId> tiles;
  for (int root = 0; root < tiling::Tiling(reader.info().scheme).rootCount(); ++root) {
    const tiling::TileId id{.level = 0, .root = static_cast<std::uint8_t>(root), .x = 0, .y = 0};
    const auto tile = reader.load(id);
    EXPECT_TRUE(tile.has_value());
    if (tile && *tile) tiles.push_back(id);
  }
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const tiling::TileId id = tiles[i];
    const std::uint8_t mask = loaded(reader, id).childMask;
    for (int q = 0; q < 4; ++q) {
      if ((mask & (1 << q)) != 0) tiles.push_back(id.child(q));
    }
  }
  return tiles;
}

raster::SourceTile loaded(const PyramidReader& reader, const tiling::TileId& id) {
  const auto tile = reader.load(id);
  EXPECT_TRUE(tile.has_value() && tile->has_value())
      << "no tile " << int{id.level} << "/" << int{id.root} << "/" << id.x << "/" << id.y;
  return tile && *tile ? **tile : raster::SourceTile{};
}

const raster::Raster<float>& heightsOf(const raster::SourceTile& tile) {
  return std::get<raster::ElevationTile>(tile.payload).samples;
}

const raster::Raster<raster::Rgba8>& pixelsOf(const raster::SourceTile& tile) {
  return std::get<raster::ImageryTile>(tile.payload).pixels;
}

std::shared_ptr<const PyramidReader> builtPyramid(const BuildOptions& options) {
  const auto built = buildPyramid(options);
  EXPECT_TRUE(built.has_value()) << io::describe(built.error());
  if (!built) return nullptr;
  auto reader = PyramidReader::open(options.output);
  EXPECT_TRUE(reader.has_value()) << io::describe(reader.error());
  return reader ? *reader : nullptr;
}

std::string bytesOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace tellurion::pyramid::testing
