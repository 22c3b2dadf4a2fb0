#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "pyramid/pyramid_builder.h"
#include "pyramid/pyramid_reader.h"

namespace tellurion {

/// The project's own elevation, the world at 10' and Everest at 3", as a database: built by the first test of this
/// process that asks, since to build it takes longer than most of them, and deleted when the process ends. Null after a
/// failure that the test is told of.
inline std::shared_ptr<const raster::TileSource> earthOn(tiling::Scheme scheme) {
  struct Made {
    Made() = default;
    Made(const Made&) = delete;
    Made& operator=(const Made&) = delete;
    ~Made() {
      source.reset();
      if (!folder.empty()) std::filesystem::remove_all(folder);
    }
    std::filesystem::path folder;
    std::shared_ptr<const raster::TileSource> source;
  };
  static std::map<tiling::Scheme, Made> made;
  Made& of = made[scheme];
  if (of.source) return of.source;
  of.folder =
      std::filesystem::path(testing::TempDir()) / ("earth_" + std::string(nameOf(scheme)) + std::to_string(getpid()));
  std::filesystem::create_directories(of.folder);
  const std::string data = TELLURION_SOURCE_DIR "/data/earth/";
  const pyramid::BuildOptions build{
      .output = of.folder / "earth.tdb",
      .inputs = {data + "etopo5_dem_10min.tif", data + "srtm3_everest_N27E086_filled.tif"},
      .scheme = scheme,
      .body = geo::earth()};
  const auto built = pyramid::buildPyramid(build);
  EXPECT_TRUE(built) << (built ? "" : describe(built.error()));
  const auto source = pyramid::PyramidReader::open(build.output);
  EXPECT_TRUE(source) << (source ? "" : describe(source.error()));
  if (source) of.source = *source;
  return of.source;
}

}  // namespace tellurion
