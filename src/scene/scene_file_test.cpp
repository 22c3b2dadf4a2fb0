#include "scene/scene_file.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace tellurion::scene {
namespace {

namespace fs = std::filesystem;

class SceneFile : public testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("tellurion_scene_file_" + std::to_string(::getpid()));
    fs::create_directories(folder);
    std::ofstream(folder / "a.tdb") << "x";
    std::ofstream(folder / "b.tif") << "x";
    path = (folder / "scene.toml").string();
  }
  void TearDown() override { fs::remove_all(folder); }

  Scene good(std::string_view text) {
    auto scene = parseScene(text, path);
    EXPECT_TRUE(scene) << (scene ? "" : io::describe(scene.error()));
    return scene.value_or(Scene{});
  }
  /// line:column and message of the failure.
  std::string bad(std::string_view text) {
    const auto scene = parseScene(text, path);
    if (scene) return "no failure";
    EXPECT_EQ(scene.error().where.rfind(path + ":", 0), 0u) << scene.error().where;
    return scene.error().where.substr(path.size() + 1) + " " + scene.error().message;
  }

  fs::path folder;
  std::string path;
};

TEST_F(SceneFile, everythingThatItMaySay) {
  const Scene scene = good(R"(
name = "All"
body = { semi_major_axis_m = 1000.0, inverse_flattening = 50, name = "Pebble" }
tiling = "healpix"
background = "8040FF"
[[elevation]]
source = "a.tdb"
[[imagery]]
source = "b.tif"
opacity = 0.5
[[imagery]]
source = "a.tdb"
role = "night_lights"
[light]
sun = [10, -20.5]
ambient = 0.25
)");
  EXPECT_EQ(scene.name, "All");
  EXPECT_EQ(scene.body.name, "Pebble");
  EXPECT_EQ(scene.body.ellipsoid, geo::Ellipsoid(1000.0, 1.0 / 50.0));
  EXPECT_EQ(scene.tiling, tiling::Scheme::healpix);
  EXPECT_FLOAT_EQ(scene.background[0], 128.0f / 255.0f);
  EXPECT_FLOAT_EQ(scene.background[2], 1.0f);
  ASSERT_EQ(scene.elevation.size(), 1u);
  EXPECT_EQ(scene.elevation[0].source, (folder / "a.tdb").string());
  ASSERT_EQ(scene.imagery.size(), 2u);
  EXPECT_EQ(scene.imagery[0].look.opacity, 0.5);
  EXPECT_EQ(scene.imagery[0].look.role, LayerRole::colour);
  EXPECT_EQ(scene.imagery[1].look.role, LayerRole::nightLights);
  EXPECT_EQ(scene.lighting.sun, Lighting::Sun::fixed);
  EXPECT_LT(geo::angleBetween(scene.lighting.subsolar, geo::directionFromDegrees(10, -20.5)).radians(), 1e-15);
  EXPECT_EQ(scene.lighting.ambient, 0.25);
}

TEST_F(SceneFile, howALayerLooks) {
  const Scene scene = good(R"([[imagery]]
source = ["a.tdb", "b.tif"]
name = "Two"
visible = false
blend = "screen"
brightness = 1.5
contrast = 0.5
saturation = 0
gamma = 2.2
[[imagery]]
source = "b.tif"
)");
  const ImageryLayer& layer = scene.imagery.at(0);
  EXPECT_EQ(layer.name, "Two");
  EXPECT_EQ(layer.source, (folder / "a.tdb").string());
  EXPECT_EQ(layer.alsoFrom, std::vector{(folder / "b.tif").string()});
  EXPECT_FALSE(layer.look.visible);
  EXPECT_EQ(layer.look.blend, BlendMode::screen);
  EXPECT_EQ(layer.look.brightness, 1.5);
  EXPECT_EQ(layer.look.contrast, 0.5);
  EXPECT_EQ(layer.look.saturation, 0.0);
  EXPECT_EQ(layer.look.gamma, 2.2);
  EXPECT_TRUE(layer.look.adjusts());
  const LayerLook& plain = scene.imagery.at(1).look;
  EXPECT_TRUE(plain.visible && !plain.adjusts() && plain.blend == BlendMode::normal);
  EXPECT_EQ(plain.opacity, 1.0);
}

TEST_F(SceneFile, leftOutMeansEarthOnTheCubeLitFromBehindTheEye) {
  const Scene scene = good("");
  EXPECT_EQ(scene.body, geo::earth());
  EXPECT_EQ(scene.tiling, tiling::Scheme::cube);
  EXPECT_EQ(scene.lighting.sun, Lighting::Sun::withCamera);
  EXPECT_TRUE(scene.lighting.enabled);
  EXPECT_EQ(good("[light]\nsun = \"camera\"\nenabled = false").lighting.enabled, false);
  EXPECT_EQ(good("[light]\nsun = \"clock\"").lighting.sun, Lighting::Sun::byClock);
}

TEST_F(SceneFile, whatIsWrongIsNamedWithItsPlaceAndWhatIsAllowed) {
  EXPECT_EQ(bad("bodi = \"earth\"").substr(0, 23), "1:1 unknown key 'bodi';");
  EXPECT_NE(bad("\nbody = \"pluto\"").find("2:8 no body 'pluto'; allowed: \"earth\""), std::string::npos);
  EXPECT_NE(bad("body = 3").find("wrong type"), std::string::npos);
  EXPECT_NE(bad("body = { inverse_flattening = 3 }").find("semi_major_axis_m"), std::string::npos);
  EXPECT_NE(bad("body = { semi_major_axis_m = -1 }").find("number from"), std::string::npos);
  EXPECT_NE(bad("body = { semi_major_axis_m = 1e6, inverse_flattening = 1.5 }").find("at least 2"), std::string::npos);
  EXPECT_NE(bad("tiling = \"hexagon\"").find("geographic, cube, healpix"), std::string::npos);
  EXPECT_NE(bad("elevation = 3").find("[[elevation]]"), std::string::npos);
  EXPECT_NE(bad("[elevation]\nsource = \"a.tdb\"").find("[[elevation]]"), std::string::npos);
  EXPECT_NE(bad("[[elevation]]").find("no source"), std::string::npos);
  EXPECT_NE(bad("[[elevation]]\nsource = \"c.tdb\"").find("2:10 there is no file"), std::string::npos);
  EXPECT_NE(bad("[[elevation]]\nsource = \"a.tdb\"\nopacity = 1").find("unknown key 'opacity'"), std::string::npos);
  EXPECT_NE(bad("[[imagery]]\nsource = 7").find("text in quotes"), std::string::npos);
  EXPECT_NE(bad("[[imagery]]\nsource = \"a.tdb\"\nopacity = 1.5").find("from 0 to 1"), std::string::npos);
  EXPECT_NE(bad("[[imagery]]\nsource = \"a.tdb\"\nopacity = nan").find("from 0 to 1"), std::string::npos);
  EXPECT_NE(bad("[[imagery]]\nsource = \"a.tdb\"\nrole = \"sun\"").find("night_lights"), std::string::npos);
  EXPECT_NE(bad("[[imagery]]\nsource = \"a.tdb\"\nblend = \"burn\"").find("normal, multiply, screen, add, overlay"),
            std::string::npos);
  EXPECT_NE(bad("[[imagery]]\nsource = \"a.tdb\"\ngamma = 0").find("from 0.1 to 10"), std::string::npos);
  EXPECT_NE(bad("[[imagery]]\nsource = \"a.tdb\"\nbrightness = -1").find("from 0 to 10"), std::string::npos);
  EXPECT_NE(bad("[[imagery]]\nsource = \"a.tdb\"\nvisible = 1").find("true or false"), std::string::npos);
  EXPECT_NE(bad("[[imagery]]\nsource = []").find("list of sources is empty"), std::string::npos);
  EXPECT_NE(bad("[[imagery]]\nsource = [\"a.tdb\", \"c.tdb\"]").find("there is no file"), std::string::npos);
  EXPECT_NE(bad("[[elevation]]\nsource = [\"a.tdb\"]").find("text in quotes"), std::string::npos);
  EXPECT_NE(bad("[light]\nsun = [91, 0]").find("from -90 to 90"), std::string::npos);
  EXPECT_NE(bad("[light]\nsun = \"moon\"").find("\"clock\" or"), std::string::npos);
  EXPECT_NE(bad("[light]\nsun = [1]").find("\"clock\" or"), std::string::npos);
  EXPECT_NE(bad("[light]\nenabled = 1").find("true or false"), std::string::npos);
  EXPECT_NE(bad("background = \"blue\"").find("RRGGBB"), std::string::npos);
  EXPECT_EQ(bad("body = ").substr(0, 2), "1:");
  EXPECT_EQ(bad("a = 1\na = 2").substr(0, 2), "2:");
}

TEST_F(SceneFile, openSceneSaysWhatIsMissing) {
  EXPECT_EQ(openScene(path).error().code, io::Failure::Code::notFound);
  EXPECT_EQ(openScene((folder / "none.tdb").string()).error().code, io::Failure::Code::notFound);
  EXPECT_FALSE(openScene((folder / "a.tdb").string()));
  EXPECT_FALSE(openScene((folder / "b.tif").string() + "," + (folder / "a.tdb").string()));
  EXPECT_FALSE(openScene(""));
  EXPECT_FALSE(openScene(","));
}

TEST_F(SceneFile, scenesOfTheProjectAreReadButForTheirDatabases) {
  for (const char* name : {"earth.toml", "earth_night.toml", "mars.toml"}) {
    const auto scene = openScene(std::string(TELLURION_SOURCE_DIR "/data/") + name);
    EXPECT_TRUE(scene || scene.error().code == io::Failure::Code::notFound) << io::describe(scene.error());
  }
}

TEST_F(SceneFile, layersOfServers) {
  const Scene scene = good(R"(
[[imagery]]
source = "http://127.0.0.1:8080/wms"
layer = "bluemarble"
style = "day"
crs = "EPSG:4326"
version = "1.1.1"
time = "2004-12"
format = "image/png"
attribution = "NASA"
bounds = [170, -10, -170, 10]
max_level = 9
opacity = 0.7
[[imagery]]
source = "tiles/{z}/{x}/{y}.png"
tile_pixels = 512
[[imagery]]
source = "http://127.0.0.1/wmts"
type = "wmts"
matrix_set = "GoogleMapsCompatible"
[[elevation]]
source = "https://127.0.0.1/{z}/{x}/{y}.webp"
encoding = "mapbox"
scale = 0.1
offset = -5
nodata = -32768
min_level = 2
[[elevation]]
source = "http://127.0.0.1/worldwind"
type = "worldwind"
level_zero_degrees = 20
)");
  ASSERT_EQ(scene.imagery.size(), 3u);
  const raster::ServiceLayer& wms = scene.imagery[0].service;
  EXPECT_EQ(scene.imagery[0].from, SourceKind::service);
  EXPECT_EQ(scene.imagery[0].look.opacity, 0.7);
  EXPECT_EQ(wms.source, "http://127.0.0.1:8080/wms");
  EXPECT_EQ(wms.type, "");
  EXPECT_EQ(wms.layer + wms.style + wms.crs + wms.version + wms.time + wms.format + wms.attribution,
            "bluemarbledayEPSG:43261.1.12004-12image/pngNASA");
  EXPECT_EQ(wms.bounds_degrees, (std::array<double, 4>{170, -10, -170, 10}));
  EXPECT_EQ(wms.maxLevel, 9);
  EXPECT_EQ(wms.minLevel, std::nullopt);
  EXPECT_EQ(scene.imagery[1].service.source, (folder / "tiles/{z}/{x}/{y}.png").string());
  EXPECT_EQ(scene.imagery[1].service.tilePixels, 512);
  EXPECT_EQ(scene.imagery[2].service.matrixSet, "GoogleMapsCompatible");
  const raster::ServiceLayer& heights = scene.elevation.at(0).service;
  EXPECT_EQ(heights.encoding, "mapbox");
  EXPECT_EQ(heights.scale, 0.1);
  EXPECT_EQ(heights.offset_m, -5.0);
  EXPECT_EQ(heights.nodata, -32768.0);
  EXPECT_EQ(heights.minLevel, 2);
  EXPECT_EQ(scene.elevation.at(1).service.type, "worldwind");
  EXPECT_EQ(scene.elevation.at(1).service.levelZero_degrees, 20.0);
}

TEST_F(SceneFile, whatASourceIsFollowsFromItUnlessItIsSaid) {
  fs::create_directories(folder / "images");
  fs::create_directories(folder / "tms");
  std::ofstream(folder / "tms" / "tilemapresource.xml") << "x";
  const auto kindOf = [&](const std::string& entry) { return good("[[imagery]]\n" + entry).imagery.at(0).from; };
  EXPECT_EQ(kindOf("source = 'a.tdb'"), SourceKind::file);
  EXPECT_EQ(kindOf("source = 'b.tif'"), SourceKind::file);
  EXPECT_EQ(kindOf("source = 'b.tif'\ntype = 'live'"), SourceKind::live);
  EXPECT_EQ(kindOf("source = 'images'"), SourceKind::catalogue);
  EXPECT_EQ(kindOf("source = 'b.tif'\ntype = 'catalogue'"), SourceKind::catalogue);
  EXPECT_EQ(kindOf("source = 'tms'"), SourceKind::service);
  EXPECT_EQ(kindOf("source = 'tms/tilemapresource.xml'"), SourceKind::service);
  EXPECT_EQ(kindOf("source = 'file:///somewhere/{z}/{x}/{y}.png'"), SourceKind::service);
}

TEST_F(SceneFile, wrongEntriesOfServersAreNamedWhereTheyStand) {
  EXPECT_EQ(bad("[[imagery]]\nsource = 'http://h/wms'\nlayers = 'a'").substr(0, 26), "3:1 unknown key 'layers'; ");
  EXPECT_EQ(bad("[[imagery]]\nsource = 'http://h/wms'\nlayer = 3"), "3:9 'layer' must be a text in quotes");
  EXPECT_EQ(bad("[[imagery]]\nsource = 'http://h/wms'\ntype = 'wcs'"),
            "3:8 no type 'wcs'; allowed: wms, wmts, tms, xyz, worldwind, live, catalogue; of imagery also "
            "hillshade, slope, palette");
  EXPECT_EQ(bad("[[imagery]]\nsource = 'http://h/wms'\nmax_level = 2.5"),
            "3:13 'max_level' must be a whole number from 0 to 30");
  EXPECT_EQ(bad("[[imagery]]\nsource = 'http://h/wms'\nbounds = [1, 2, 3]"),
            "3:10 'bounds' must be [west, south, east, north] in degrees");
  EXPECT_EQ(bad("[[imagery]]\nsource = 'http://h/wms'\nbounds = [1, 20, 3, 10]"),
            "3:10 'bounds' must have the south below the north");
  EXPECT_EQ(bad("[[imagery]]\nsource = 'b.tif'\nlayer = 'x'"),
            "3:1 'layer' is for layers of services; say which with type");
  EXPECT_EQ(bad("[[imagery]]\nsource = 'http://user:secret@h/wms'\ntype = 'live'").find("secret"), std::string::npos);
}

TEST(OpenScene, aUrlIsASceneWithOneLayer) {
  const Scene scene = openScene("http://127.0.0.1:8080/wms?map=a#bluemarble").value();
  ASSERT_EQ(scene.imagery.size(), 1u);
  EXPECT_EQ(scene.imagery[0].from, SourceKind::service);
  EXPECT_EQ(scene.imagery[0].service.source, "http://127.0.0.1:8080/wms?map=a");
  EXPECT_EQ(scene.imagery[0].service.layer, "bluemarble");
  EXPECT_EQ(scene.body.name, "earth");
  EXPECT_TRUE(scene.elevation.empty());
  EXPECT_EQ(openScene("https://127.0.0.1/{z}/{x}/{y}.jpg")->imagery.at(0).service.layer, "");
}

TEST_F(SceneFile, picturesOfHeights) {
  const Scene scene = good(R"(
body = "mars"
[[elevation]]
source = "a.tdb"
[[imagery]]
type = "palette"
[[imagery]]
type = "palette"
stops = [[-10, "#000000"], [20.5, "10FF20"]]
name = "two"
[[imagery]]
type = "hillshade"
sun_azimuth = 90
sun_altitude = 20
exaggeration = 3
blend = "multiply"
opacity = 0.5
[[imagery]]
type = "slope"
of = "b.tif"
[[imagery]]
type = "hillshade"
of = { source = "http://127.0.0.1:1/wms", layer = "dem", encoding = "terrarium" }
)");
  ASSERT_EQ(scene.imagery.size(), 5u);
  const auto stopsOf = [&](std::size_t i) {
    return std::get<raster::Palette>(scene.imagery[i].derived->colours).stops;
  };
  EXPECT_EQ(scene.imagery[0].name, "palette");
  EXPECT_EQ(stopsOf(0).front().value, raster::heightRamp("mars").front().value);
  ASSERT_EQ(stopsOf(1).size(), 2u);
  EXPECT_EQ(stopsOf(1)[1].value, 20.5);
  EXPECT_EQ(stopsOf(1)[1].colour, (raster::Rgba8{16, 255, 32, 255}));
  EXPECT_EQ(scene.imagery[1].name, "two");
  const auto shade = std::get<raster::Hillshade>(scene.imagery[2].derived->colours);
  EXPECT_NEAR(shade.sunAzimuth.degrees(), 90.0, 1e-12);
  EXPECT_NEAR(shade.sunAltitude.degrees(), 20.0, 1e-12);
  EXPECT_EQ(shade.exaggeration, 3.0);
  EXPECT_FALSE(scene.imagery[2].derived->of);
  EXPECT_EQ(scene.imagery[2].look.blend, BlendMode::multiply);
  EXPECT_EQ(scene.imagery[2].look.opacity, 0.5);
  EXPECT_EQ(scene.imagery[3].derived->of->source, (folder / "b.tif").string());
  EXPECT_EQ(scene.imagery[4].derived->of->from, SourceKind::service);
  EXPECT_EQ(scene.imagery[4].derived->of->service.layer, "dem");
}

TEST_F(SceneFile, picturesOfHeightsThatCannotBe) {
  EXPECT_EQ(bad("[[imagery]]\ntype = 'slope'"),
            "1:1 a slope is made of heights; give the scene an [[elevation]] layer, or the layer a source of them with "
            "of = \"FILE\"");
  EXPECT_EQ(bad("[[imagery]]\ntype = 'slope'\nof = 'b.tif'\nsun_azimuth = 3").substr(0, 30),
            "4:1 unknown key 'sun_azimuth';");
  EXPECT_EQ(bad("[[imagery]]\ntype = 'palette'\nof = 'b.tif'\nstops = [[3, '000000'], [2, '000000']]"),
            "4:25 'stops' must ascend");
  EXPECT_EQ(bad("[[imagery]]\ntype = 'palette'\nof = 'b.tif'\nstops = 'pluto'"),
            "4:9 no palette 'pluto'; 'stops' may be \"earth\", \"mars\", \"moon\" or [[height_m, \"RRGGBB\"], ...]");
  EXPECT_EQ(bad("body = { semi_major_axis_m = 9.0 }\n[[imagery]]\ntype = 'palette'\nof = 'b.tif'").substr(0, 24),
            "2:1 no palette 'own'; 's");
  EXPECT_EQ(bad("[[imagery]]\ntype = 'hillshade'\nof = 'none.tif'").substr(0, 23), "3:6 there is no file /t");
}

TEST_F(SceneFile, theClockAndWhatFollowsIt) {
  const Scene scene = good(R"(
[clock]
start = "2004-01-01T00:00:00Z"
end = "2004-12-31"
rate = -3600
step = 60.5
[[imagery]]
times = [["2004-01-01T00:00:00Z", "a.tdb"], ["2004-02", "b.tif"]]
opacity = 0.5
[[imagery]]
type = "live"
times = [["1970-01-02", "b.tif"]]
)");
  EXPECT_EQ(scene.clock.start_s, 1072915200.0);
  EXPECT_EQ(scene.clock.end_s, 1104451200.0);
  EXPECT_EQ(scene.clock.rate, -3600.0);
  EXPECT_EQ(scene.clock.step_s, 60.5);
  ASSERT_EQ(scene.imagery.size(), 2u);
  ASSERT_EQ(scene.imagery[0].times.size(), 2u);
  EXPECT_EQ(scene.imagery[0].times[1].time_s, 1075593600.0);
  EXPECT_EQ(scene.imagery[0].times[1].source, (folder / "b.tif").string());
  EXPECT_EQ(scene.imagery[0].look.opacity, 0.5);
  EXPECT_EQ(scene.imagery[1].times[0].time_s, 86400.0);
  EXPECT_EQ(scene.imagery[1].times[0].from, SourceKind::live);
  EXPECT_FALSE(good("").clock.start_s);

  EXPECT_EQ(bad("[clock]\nstart = 'noon'"), "2:9 'start' must be a time like \"2004-01-31T12:00:00Z\"");
  EXPECT_EQ(bad("[[imagery]]\nsource = 'a.tdb'\ntimes = [['2004', 'a.tdb']]").substr(4),
            "a layer has either 'source' or 'times'");
  EXPECT_EQ(bad("[[imagery]]\ntimes = [['2004', 'a.tdb'], ['2003', 'b.tif']]").substr(5), "'times' must ascend");
  EXPECT_EQ(bad("[[imagery]]\ntimes = [['2004', 'http://127.0.0.1/wms']]").substr(5),
            "'times' is a list of files of this machine");
}

}  // namespace
}  // namespace tellurion::scene
