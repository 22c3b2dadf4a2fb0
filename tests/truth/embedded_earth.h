#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>

#include "pyramid/pyramid_builder.h"
#include "pyramid/pyramid_reader.h"

namespace tellurion {

/// The project's own elevation, the world at 10' and Everest at 3", built into a folder and opened; null after a
/// failure that the test is told of.
inline std::shared_ptr<const raster::TileSource> earthOn(tiling::Scheme scheme, const std::filesystem::path& folder) {
  const std::string data = TELLURION_SOURCE_DIR "/data/earth/";
  std::filesystem::create_directories(folder);
  const pyramid::BuildOptions build{
      .output = folder / "earth.tdb",
      .inputs = {data + "etopo5_dem_10min.tif", data + "srtm3_everest_N27E086_filled.tif"},
      .scheme = scheme,
      .body = geo::earth()};
  const auto built = pyramid::buildPyramid(build);
  EXPECT_TRUE(built) << (built ? "" : describe(built.error()));
  const auto source = pyramid::PyramidReader::open(build.output);
  EXPECT_TRUE(source) << (source ? "" : describe(source.error()));
  return source ? *source : nullptr;
}

}  // namespace tellurion
