#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pyramid/pyramid_builder.h"
#include "pyramid/pyramid_reader.h"

namespace tellurion::pyramid::testing {

/// A folder that is gone with its content at the end of the test.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

enum class SampleType { int16, float32, byte };

struct GridSpec {
  int width = 0;
  int height = 0;
  std::array<double, 6> geotransform{};  ///< as GDAL has it
  std::string reference = "EPSG:4326";
  SampleType type = SampleType::int16;
  std::optional<double> nodata;
};

/// A grid of latitude and longitude whose outer border is given in degrees.
GridSpec degreesGrid(double west, double south, double east, double north, int width, int height);

/// GeoTIFFs; the functions get (column, row).
void writeElevation(const std::filesystem::path& path, const GridSpec& spec,
                    const std::function<double(int, int)>& value);
void writeColour(const std::filesystem::path& path, const GridSpec& spec,
                 const std::function<raster::Rgba8(int, int)>& colour);

/// A raster's first band, whole.
struct Grid {
  int width = 0;
  int height = 0;
  std::array<double, 6> geotransform{};
  std::vector<double> values;
  double at(int column, int row) const;           ///< columns around the globe, rows clamped
  double bilinear(double lat, double lon) const;  ///< a global grid of latitude and longitude, all with data
};
Grid readGrid(const std::filesystem::path& path);

/// Hills all over the globe: a smooth function of place, about +-4000 m.
double hills(double lat, double lon);

/// Half a degree, the whole globe: hills to the metre. Returns the path.
std::string writeHillyGlobe(const std::filesystem::path& path);

/// Every stored tile, coarsest first.
std::vector<tiling::TileId> storedTiles(const PyramidReader& reader);
raster::SourceTile loaded(const PyramidReader& reader, const tiling::TileId& id);
const raster::Raster<float>& heightsOf(const raster::SourceTile& tile);
const raster::Raster<raster::Rgba8>& pixelsOf(const raster::SourceTile& tile);

/// Builds and opens; a failure fails the test and returns null.
std::shared_ptr<const PyramidReader> builtPyramid(const BuildOptions& options);

std::string bytesOf(const std::filesystem::path& path);

}  // namespace tellurion::pyramid::testing
