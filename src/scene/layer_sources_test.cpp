#include "scene/layer_sources.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <thread>
#include <vector>

#include "geo/body.h"
#include "io/fault_server_test.h"
#include "pyramid/pyramid_builder.h"
#include "pyramid/remote_database.h"
#include "pyramid/tile_objects.h"

namespace tellurion::scene {
namespace {

namespace fs = std::filesystem;

const std::string kData = TELLURION_SOURCE_DIR "/data/";

/// A cache folder of its own, so that nothing of the user's is touched.
class LayerSources : public testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("tellurion_layer_sources_" + std::to_string(::getpid()));
    fs::create_directories(folder);
    ::setenv("XDG_CACHE_HOME", folder.c_str(), 1);
  }
  void TearDown() override {
    ::unsetenv("XDG_CACHE_HOME");
    fs::remove_all(folder);
  }
  int databases() const {
    if (!fs::exists(cacheFolder())) return 0;
    int count = 0;
    for (const auto& entry : fs::directory_iterator(cacheFolder()))
      count += entry.path().extension() == ".tdb" ? 1 : 0;
    return count;
  }
  fs::path folder;
};

TEST_F(LayerSources, aRasterIsBuiltOnceAndFoundAgain) {
  const std::string raster = (folder / "heights.tif").string();
  fs::copy_file(kData + "mars/mola_dem_4ppd.tif", raster);
  const Scene scene = openScene(raster).value();
  EXPECT_EQ(scene.body.ellipsoid, geo::mars().ellipsoid);
  ASSERT_EQ(scene.elevation.size(), 1u);
  int told = 0;
  const auto first = openLayers(scene, [&](std::string_view what, double share) {
    EXPECT_EQ(what, raster);
    EXPECT_GE(share, 0.0);
    EXPECT_LE(share, 1.0);
    ++told;
  });
  ASSERT_TRUE(first) << io::describe(first.error());
  EXPECT_EQ(first->elevation.at(0).open->info().scheme, scene.tiling);
  EXPECT_GT(told, 0);
  EXPECT_EQ(databases(), 1);
  const auto second = openLayers(scene, [](std::string_view, double) { FAIL() << "built again"; });
  EXPECT_TRUE(second);
  EXPECT_EQ(databases(), 1);
  // Another time of change is another raster.
  fs::last_write_time(raster, fs::last_write_time(raster) - std::chrono::hours(1));
  EXPECT_TRUE(openLayers(scene, {}));
  EXPECT_EQ(databases(), 2);
}

TEST_F(LayerSources, aPictureWithoutReferenceTakesTheBodyOfTheOthers) {
  const auto scene = openScene(kData + "mars/mola_dem_4ppd.tif," + kData + "mars/viking_mdim21_color_2880x1440.jpg");
  ASSERT_TRUE(scene) << io::describe(scene.error());
  EXPECT_EQ(scene->body.ellipsoid, geo::mars().ellipsoid);
  EXPECT_EQ(scene->elevation.size(), 1u);
  EXPECT_EQ(scene->imagery.size(), 1u);
  EXPECT_FALSE(openScene(kData + "mars/mola_dem_4ppd.tif," + kData + "earth/etopo5_dem_10min.tif"));
}

TEST_F(LayerSources, whatDoesNotOpenInTheCacheIsBuiltAgain) {
  const Scene scene = openScene(kData + "mars/mola_dem_4ppd.tif").value();
  ASSERT_TRUE(openLayers(scene, {}));
  for (const auto& entry : fs::directory_iterator(cacheFolder())) {
    if (entry.path().extension() == ".tdb") std::ofstream(entry.path(), std::ios::trunc) << "no database at all";
  }
  const auto again = openLayers(scene, {});
  EXPECT_TRUE(again) << io::describe(again.error());
  EXPECT_EQ(databases(), 1);
}

TEST_F(LayerSources, aStoppedBuildGoesOn) {
  const std::string raster = kData + "mars/mola_dem_4ppd.tif";
  const Scene scene = openScene(raster).value();
  std::stop_source stop;
  const auto stopSoon = [&](std::string_view, double) { stop.request_stop(); };
  const auto stopped = openLayers(scene, stopSoon, stop.get_token());
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, io::Failure::Code::cancelled);
  EXPECT_EQ(stopped.error().where, raster);
  EXPECT_NE(stopped.error().message.find("goes on"), std::string::npos) << stopped.error().message;
  EXPECT_EQ(databases(), 0);
  double least = 1.0;
  const auto finished = openLayers(scene, [&](std::string_view, double share) { least = std::min(least, share); });
  ASSERT_TRUE(finished) << io::describe(finished.error());
  EXPECT_GT(least, 0.0);  // not from the beginning
  EXPECT_EQ(databases(), 1);
}

TEST_F(LayerSources, whoWaitsForAnotherProgramStopsToo) {
  const Scene scene = openScene(kData + "mars/mola_dem_4ppd.tif").value();
  std::stop_source first;
  static_cast<void>(openLayers(
      scene, [&](std::string_view, double) { first.request_stop(); }, first.get_token()));
  int lock = -1;
  for (const auto& entry : fs::directory_iterator(cacheFolder())) {
    if (entry.path().extension() == ".lock") lock = ::open(entry.path().c_str(), O_RDWR | O_CLOEXEC);
  }
  ASSERT_GE(lock, 0);
  ASSERT_EQ(::flock(lock, LOCK_EX | LOCK_NB), 0);
  std::stop_source stop;
  const auto waited = openLayers(
      scene, [&](std::string_view, double) { stop.request_stop(); }, stop.get_token());
  ::close(lock);
  ASSERT_FALSE(waited);
  EXPECT_EQ(waited.error().code, io::Failure::Code::cancelled);
}

TEST_F(LayerSources, twoAtOnceBuildOnce) {
  const Scene scene = openScene(kData + "mars/mola_dem_4ppd.tif").value();
  std::array<bool, 3> opened{};
  {
    std::vector<std::jthread> threads;
    for (bool& done : opened)
      threads.emplace_back([&scene, &done] { done = openLayers(scene, {}).has_value(); });
  }
  for (const bool done : opened)
    EXPECT_TRUE(done);
  EXPECT_EQ(databases(), 1);
}

TEST_F(LayerSources, aRasterOfAnotherBodyIsAFailure) {
  Scene scene;
  scene.body = geo::moon();
  scene.elevation.push_back({.source = kData + "mars/mola_dem_4ppd.tif"});
  const auto layers = openLayers(scene, {});
  ASSERT_FALSE(layers);
  EXPECT_NE(layers.error().message.find("lies on mars"), std::string::npos) << layers.error().message;
  EXPECT_NE(layers.error().message.find("moon"), std::string::npos) << layers.error().message;
}

TEST_F(LayerSources, warningsOfABuildAreHandedOn) {
  // A picture that only a world file places: its reference is assumed, which is worth a warning.
  const Scene scene = openScene(kData + "mars/viking_mdim21_color_2880x1440.jpg").value();
  int warnings = 0;
  ASSERT_TRUE(openLayers(scene, [&](std::string_view, double share) { warnings += share == kWarningShare ? 1 : 0; }));
  EXPECT_GT(warnings, 0);
}

TEST_F(LayerSources, databasesAreKnownByTheirFirstBytesToo) {
  const Scene scene = openScene(kData + "mars/mola_dem_4ppd.tif").value();
  ASSERT_TRUE(openLayers(scene, {}));
  for (const auto& entry : fs::directory_iterator(cacheFolder())) {
    if (entry.path().extension() == ".tdb") fs::rename(entry.path(), folder / "named.otherwise");
  }
  const auto renamed = openScene((folder / "named.otherwise").string());
  ASSERT_TRUE(renamed) << io::describe(renamed.error());
  ASSERT_TRUE(openLayers(*renamed, [](std::string_view, double) { FAIL() << "built"; }));
}

TEST_F(LayerSources, whatIsNoRasterIsAFailureThatNamesIt) {
  const std::string path = (folder / "text.tif").string();
  std::ofstream(path) << "not a raster";
  const auto scene = openScene(path);
  ASSERT_FALSE(scene);
  EXPECT_NE(io::describe(scene.error()).find("text.tif"), std::string::npos);
  Scene handMade;
  handMade.elevation.push_back({.source = path});
  EXPECT_FALSE(openLayers(handMade, {}));
}

TEST_F(LayerSources, picturesOfHeightsAreOpenWhenTheHeightsAre) {
  Scene scene{.body = geo::mars()};
  const ElevationLayer mola{.source = kData + "mars/mola_dem_4ppd.tif", .from = SourceKind::live};
  scene.imagery.push_back({.derived = DerivedImagery{.colours = raster::Hillshade{}, .of = mola}});
  auto layers = openLayers(scene, {});
  ASSERT_TRUE(layers) << io::describe(layers.error());
  ASSERT_TRUE(layers->imagery[0].source.open);
  EXPECT_EQ(layers->imagery[0].source.open->info().kind, raster::Kind::imagery);
  EXPECT_EQ(layers->imagery[0].source.open->info().maxLevel, 1);

  // One of two heights lies on a server that is not there: the pictures of both wait as that does.
  scene.elevation = {mola,
                     {.source = "http://127.0.0.1:9/",
                      .from = SourceKind::service,
                      .service = {.source = "http://127.0.0.1:9/", .type = "nonsense"}}};
  scene.imagery[0].derived->of.reset();
  layers = openLayers(scene, {});
  ASSERT_TRUE(layers) << io::describe(layers.error());
  ASSERT_FALSE(layers->imagery[0].source.open);
  // It never will be there: those of the other come.
  const auto rest = layers->imagery[0].source.opening();
  ASSERT_TRUE(rest) << io::describe(rest.error());
  EXPECT_EQ((*rest)->info().maxLevel, 1);
}

/// A WMS of heights whose small map of everything the server does not make: heights come out of finer maps.
TEST_F(LayerSources, heightsComeThoughTheServerRefusesTheMapOfEverything) {
  const io::FaultServer server(folder);
  std::ofstream(folder / "wms")
      << R"(<WMS_Capabilities version="1.3.0"><Capability><Request><GetMap><Format>image/tiff</Format></GetMap></Request>
            <Layer><Name>dem</Name><CRS>CRS:84</CRS><EX_GeographicBoundingBox><westBoundLongitude>-180</westBoundLongitude>
            <eastBoundLongitude>180</eastBoundLongitude><southBoundLatitude>-90</southBoundLatitude>
            <northBoundLatitude>90</northBoundLatitude></EX_GeographicBoundingBox></Layer></Capability></WMS_Capabilities>)";
  const std::string maps = "/wms?SERVICE=WMS&VERSION=1.3.0&REQUEST=GetMap&LAYERS=dem&STYLES=&CRS=CRS:84&WIDTH=";
  Scene scene;
  scene.elevation.push_back({.source = server.url("/wms"),
                             .from = SourceKind::service,
                             .service = {.source = server.url("/wms"), .type = "wms", .layer = "dem"}});
  for (const bool refuses : {false, true}) {
    server.tell("clear");
    server.tell("reset");
    server.tell("set?prefix=/wms%3FSERVICE=WMS%26VERSION=1.3.0%26REQUEST=GetMap&fault=status&code=404");
    if (refuses) {
      server.tell(
          "set?prefix=/wms%3FSERVICE=WMS%26VERSION=1.3.0%26REQUEST=GetMap%26LAYERS=dem%26STYLES=%26CRS=CRS:84%26"
          "WIDTH=256&fault=status&code=400");
    }
    const auto layers = openLayers(scene, {}, {}, {.cacheBytes = 0});
    ASSERT_TRUE(layers) << io::describe(layers.error());
    const auto source = layers->elevation[0].opening();
    ASSERT_TRUE(source) << io::describe(source.error());
    EXPECT_TRUE((*source)->load({.level = 0, .root = 0})) << "no server's image is there, which is no failure";
    const auto small = [&](const std::string& url) { return url.starts_with(maps + "256&"); };
    const auto state = server.state();
    int finer = 0;
    for (const auto& [url, count] : state["counts"].items())
      finer += url.starts_with(maps) && !small(url) ? 1 : 0;
    EXPECT_EQ(finer > 0, refuses) << state["counts"];
  }
}

/// What a database on a server says of itself is asked for, and read, once, though first the scene has to know it and
/// then the layers; also where nothing is kept on disk.
TEST_F(LayerSources, aDatabaseOnAServerIsAskedForItsContentsOnce) {
  pyramid::BuildOptions options{.output = folder / "mars.tdb",
                                .inputs = {kData + "mars/mola_dem_4ppd.tif"},
                                .kind = raster::Kind::elevation,
                                .scheme = tiling::Scheme::cube,
                                .body = geo::mars()};
  ASSERT_TRUE(pyramid::buildPyramid(options));
  ASSERT_TRUE(pyramid::exportObjects(folder / "mars.tdb", folder / "www/mars.tdb", {}));
  const io::FaultServer server(folder / "www");
  for (const std::uint64_t cacheBytes : {std::uint64_t{0}, std::uint64_t{16} << 20}) {
    server.tell("reset");
    const io::ResourceOptions online{.cacheBytes = cacheBytes};
    const Scene scene =
        openScene(server.url("/mars.tdb"), std::vector<std::string>{"light.enabled=false"}, online).value();
    EXPECT_EQ(scene.body.ellipsoid, geo::mars().ellipsoid);
    const auto layers = openLayers(scene, {}, {}, online);
    ASSERT_TRUE(layers) << io::describe(layers.error());
    const auto source = layers->elevation.at(0).opening();
    ASSERT_TRUE(source) << io::describe(source.error());
    EXPECT_TRUE((*source)->load({.level = 0, .root = 0})->has_value());
    EXPECT_EQ(server.count("/mars.tdb/contents"), 1) << server.state()["counts"];
  }
}

}  // namespace
}  // namespace tellurion::scene
