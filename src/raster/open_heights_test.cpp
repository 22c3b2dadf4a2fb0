#include <gtest/gtest.h>

#include <chrono>
#include <fstream>

#include "raster/raster_fixture_test.h"
#include "raster/service_fixture_test.h"

namespace tellurion::raster {
namespace {

using testing::ScratchFolder;

/// Capabilities of a wide layer, whose maps are at a port where nobody answers: what is asked for there never comes,
/// and never fails for good.
ServiceLayer deafServer(const ScratchFolder& folder) {
  const std::string path = folder.file("capabilities.xml");
  std::ofstream(path) << R"(<?xml version="1.0"?>
<WMS_Capabilities version="1.3.0" xmlns:xlink="http://www.w3.org/1999/xlink">
  <Service><Name>WMS</Name><Title>Deaf</Title></Service>
  <Capability>
    <Request><GetMap><Format>image/tiff</Format>
      <DCPType><HTTP><Get><OnlineResource xlink:href="http://127.0.0.1:1/map?"/></Get></HTTP></DCPType></GetMap></Request>
    <Layer><Title>All</Title><CRS>CRS:84</CRS>
      <EX_GeographicBoundingBox><westBoundLongitude>-180</westBoundLongitude><eastBoundLongitude>180</eastBoundLongitude>
        <southBoundLatitude>-90</southBoundLatitude><northBoundLatitude>90</northBoundLatitude></EX_GeographicBoundingBox>
      <Layer><Name>heights</Name><Title>Heights</Title></Layer>
    </Layer>
  </Capability>
</WMS_Capabilities>)";
  ServiceLayer entry;
  entry.source = path;
  entry.type = "wms";
  entry.layer = "heights";
  return entry;
}

TEST(OpenHeights, DoWithoutAMapOfEverythingThatDoesNotComeInTime) {
  const ScratchFolder folder;
  const ServiceLayer entry = deafServer(folder);
  io::Resources resources{io::ResourceOptions{}};
  const auto offered = openService(entry, Kind::elevation, geo::earth(), resources);
  ASSERT_TRUE(offered) << refusalOf(offered);
  ASSERT_GT(offered->overviews, 0u);
  const auto start = std::chrono::steady_clock::now();
  const auto heights = openHeights(entry, geo::earth(), resources, 0.3);
  const auto took = std::chrono::steady_clock::now() - start;
  ASSERT_TRUE(heights) << refusalOf(heights);
  EXPECT_GE(took, std::chrono::milliseconds(300)) << "it may still have come";
  EXPECT_LT(took, std::chrono::seconds(15)) << "the limit that was given counts, not the usual one";
  EXPECT_EQ(heights->overviews, 0u);
  ASSERT_EQ(heights->levels.size(), offered->levels.size() - offered->overviews);
  for (std::size_t i = 0; i < heights->levels.size(); ++i)
    EXPECT_EQ(heights->levels[i].pixelWidth, offered->levels[i + offered->overviews].pixelWidth);
}

}  // namespace
}  // namespace tellurion::raster
