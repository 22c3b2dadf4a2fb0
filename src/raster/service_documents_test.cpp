#include <cpl_error.h>
#include <fmt/format.h>
#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include "geo/seed_test.h"
#include "raster/map_reference.h"
#include "raster/parse_number.h"
#include "raster/service_fixture_test.h"
#include "raster/service_url.h"
#include "raster/wms_capabilities.h"
#include "raster/wmts_capabilities.h"
#include "raster/wmts_service.h"
#include "raster/xml_document.h"

// What is read in real documents of servers, beside what GDAL's drivers of WMS and WMTS read in them.
namespace tellurion::raster {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> documents(const char* folder) {
  std::vector<fs::path> paths;
  for (const auto& entry : fs::directory_iterator(sharedDocument(folder)))
    if (entry.path().extension() == ".xml") paths.push_back(entry.path());
  std::ranges::sort(paths);
  return paths;
}

XmlElement rootOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  return parseXml(std::as_bytes(std::span(text)), path.filename().string()).value();
}

using Dataset = std::unique_ptr<GDALDataset>;

Dataset openedByGdal(const std::string& name) {
  GDALAllRegister();
  CPLPushErrorHandler(CPLQuietErrorHandler);
  Dataset dataset(GDALDataset::Open(name.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  CPLPopErrorHandler();
  return dataset;
}

/// The names of what GDAL finds in a document.
std::vector<std::string> subdatasets(GDALDataset& dataset) {
  std::vector<std::string> names;
  for (char** item = dataset.GetMetadata("SUBDATASETS"); item != nullptr && *item != nullptr; ++item) {
    const std::string_view pair = *item;
    const std::size_t value = pair.find("_NAME=");
    if (value != pair.npos) names.emplace_back(pair.substr(value + 6));
  }
  return names;
}

/// By OGR, of the code itself, not of one that took its place; nothing where it knows no plane of that name.
std::optional<bool> northFirstByOgr(const std::string& name) {
  CPLSetThreadLocalConfigOption("OSR_USE_NON_DEPRECATED", "NO");
  OGRSpatialReference reference;
  CPLPushErrorHandler(CPLQuietErrorHandler);
  const bool isKnown = reference.SetFromUserInput(name == "CRS:84" ? "OGC:CRS84" : name.c_str()) == OGRERR_NONE;
  CPLSetThreadLocalConfigOption("OSR_USE_NON_DEPRECATED", nullptr);
  OGRAxisOrientation first = OAO_Other, second = OAO_Other;
  reference.GetAxis(nullptr, 0, &first);
  reference.GetAxis(nullptr, 1, &second);
  CPLPopErrorHandler();
  const bool isPlane = (reference.IsProjected() != 0 || reference.IsGeographic() != 0) && reference.GetAxesCount() == 2;
  if (!isKnown || !isPlane) return std::nullopt;
  return reference.EPSGTreatsAsLatLong() != 0 || reference.EPSGTreatsAsNorthingEasting() != 0 ||
         (first == OAO_North && second == OAO_West);
}

class ServiceDocuments : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!haveSharedDocuments()) GTEST_SKIP() << "no shared data";
  }
};

/// Of each layer that GDAL finds: in one of its references, the box.
TEST_F(ServiceDocuments, boxesOfMapsAreThoseThatGdalFinds) {
  int compared = 0;
  for (const fs::path& path : documents("wms")) {
    const Dataset document = openedByGdal(path.string());
    if (!document) continue;  // it does not read 1.0.0, UTF-16, a namespace's prefix
    const auto capabilities = parseWmsCapabilities(rootOf(path), path.string());
    ASSERT_TRUE(capabilities);
    for (const std::string& name : subdatasets(*document)) {
      const std::string url = name.substr(4);
      const std::string layerName = queryValue(url, "LAYERS").value();
      const std::string crs = queryValue(url, capabilities->version == "1.3.0" ? "CRS" : "SRS").value();
      SCOPED_TRACE(path.filename().string() + ": " + layerName + ", " + crs);
      const WmsLayer* layer = capabilities->layer(layerName);
      ASSERT_NE(layer, nullptr);
      const WmsLayer whole = capabilities->withInherited(*layer);
      EXPECT_NE(std::ranges::find(whole.crs, crs), whole.crs.end());
      const auto box = std::ranges::find(whole.boxes, crs, &WmsBox::crs);
      const auto expected = parseNumbers(queryValue(url, "BBOX").value());
      ASSERT_EQ(expected.size(), 4u);
      if (box == whole.boxes.end()) {
        ASSERT_TRUE(whole.lonLatBox_degrees) << "GDAL takes it from somewhere";
      }
      const auto& values = box == whole.boxes.end() ? *whole.lonLatBox_degrees : box->values;
      for (std::size_t i = 0; i < 4; ++i)
        EXPECT_DOUBLE_EQ(values[i], expected[i]);
      ++compared;
    }
  }
  EXPECT_GT(compared, 1000);
}

TEST_F(ServiceDocuments, axesOfAllReferencesAreThoseOfOgr) {
  constexpr int kSample = 400;  // of 6,000, which take 15 s
  std::set<std::string> names;
  for (const fs::path& path : documents("wms")) {
    const auto capabilities = parseWmsCapabilities(rootOf(path), path.string());
    ASSERT_TRUE(capabilities);
    for (const WmsLayer& layer : capabilities->layers)
      for (const std::string& crs : layer.crs)
        names.insert(referenceName(crs));
  }
  for (const fs::path& path : documents("wmts")) {
    const auto capabilities = parseWmtsCapabilities(rootOf(path), path.string());
    ASSERT_TRUE(capabilities);
    for (const WmtsMatrixSet& set : capabilities->matrixSets)
      names.insert(referenceName(set.crs));
  }
  std::vector<std::string> some;
  auto random = geo::seededGenerator();
  std::ranges::sample(names, std::back_inserter(some), kSample, random);
  int compared = 0;
  for (const std::string& name : some) {
    const auto theirs = northFirstByOgr(name);
    if (!theirs) continue;
    const auto ours = mapReference(name, geo::earth());
    ASSERT_TRUE(ours) << io::describe(ours.error());
    EXPECT_EQ(ours->northFirst, *theirs) << name;
    ++compared;
  }
  EXPECT_GT(compared, kSample / 2);
}

/// And one that does not come from a table of references: where a server of 1.3.0 writes the box of a layer, its middle
/// is where the layer's box in degrees lies with the axes in one order, and not in the other.
TEST_F(ServiceDocuments, boxesLieInTheOrderOfTheirReferences) {
  int compared = 0;
  for (const fs::path& path : documents("wms")) {
    const auto capabilities = parseWmsCapabilities(rootOf(path), path.string());
    ASSERT_TRUE(capabilities);
    if (capabilities->version != "1.3.0") continue;
    for (const WmsLayer& layer : capabilities->layers) {
      if (!layer.lonLatBox_degrees) continue;
      const auto& [west, south, east, north] = *layer.lonLatBox_degrees;
      for (const WmsBox& box : layer.boxes) {
        const auto reference = mapReference(box.crs, geo::earth());
        OGRSpatialReference degrees, plane;
        if (!reference || reference->plane.kind != MapPlane::Kind::lonLat) continue;
        const auto& [a, b, c, d] = box.values;
        const auto isNear = [&](double w, double s, double e, double n) {
          return std::abs(w - west) + std::abs(s - south) + std::abs(e - east) + std::abs(n - north) < 1.0;
        };
        const bool xFirst = isNear(a, b, c, d);
        const bool yFirst = isNear(b, a, d, c);
        if (xFirst == yFirst) continue;
        EXPECT_EQ(reference->northFirst, yFirst) << path.filename() << ", " << layer.name << ", " << box.crs;
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 20);
}

/// Of each layer in each of its matrix sets: a level has GDAL's pixels (its finest is that with the layer's limits),
/// and the corner of GDAL's raster, which goes by the layer's box, lies a whole number of them from that level's.
TEST_F(ServiceDocuments, gridsOfTilesAreThoseThatGdalFinds) {
  constexpr double kOff_pixels = 0.1;
  int compared = 0;
  for (const fs::path& path : documents("wmts")) {
    const Dataset document = openedByGdal("WMTS:" + path.string());
    ASSERT_TRUE(document) << path;
    const auto capabilities = parseWmtsCapabilities(rootOf(path), path.string());
    ASSERT_TRUE(capabilities);
    for (const WmtsLayer& layer : capabilities->layers) {
      for (const WmtsLink& link : layer.links) {
        SCOPED_TRACE(path.filename().string() + ": " + layer.name + ", " + link.matrixSet);
        const Dataset theirs = openedByGdal(fmt::format("WMTS:{},layer={},tilematrixset={},extendbeyonddateline=no",
                                                        path.string(), layer.name, link.matrixSet));
        if (!theirs) continue;
        ServiceLayer entry;
        entry.layer = layer.name;
        entry.matrixSet = link.matrixSet;
        const auto ours = wmtsService(*capabilities, entry, Kind::imagery, geo::earth(), "http://h/caps");
        ASSERT_TRUE(ours) << refusalOf(ours);
        std::array<double, 6> grid{};
        ASSERT_EQ(theirs->GetGeoTransform(grid.data()), CE_None);
        const auto level = std::ranges::find_if(
            ours->levels, [&](const GridLevel& each) { return std::abs(each.pixelWidth - grid[1]) < 1e-9 * grid[1]; });
        ASSERT_NE(level, ours->levels.end()) << grid[1];
        EXPECT_NEAR(-grid[5], level->pixelHeight, 1e-9 * level->pixelHeight);
        const double columns = (grid[0] - level->left) / level->pixelWidth;
        const double rows = (level->top - grid[3]) / level->pixelHeight;
        EXPECT_NEAR(columns, std::round(columns), kOff_pixels);
        EXPECT_NEAR(rows, std::round(rows), kOff_pixels);
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 50);
}

}  // namespace
}  // namespace tellurion::raster
