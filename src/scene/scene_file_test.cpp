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
  EXPECT_FALSE(scene.imagery[0].look.nightLights);
  EXPECT_TRUE(scene.imagery[1].look.nightLights);
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
  EXPECT_NE(bad("[[imagery]]\nsource = \"a.tdb\"\nblend = \"burn\"").find("normal, multiply, screen, add"),
            std::string::npos);
  EXPECT_NE(bad("[[imagery]]\nsource = \"a.tdb\"\ngamma = 0").find("from 0.1 to 10"), std::string::npos);
  EXPECT_NE(bad("[[imagery]]\nsource = \"a.tdb\"\nbrightness = -1").find("from 0 to 10"), std::string::npos);
  EXPECT_NE(bad("[[imagery]]\nsource = \"a.tdb\"\nvisible = 1").find("true or false"), std::string::npos);
  EXPECT_NE(bad("[[imagery]]\nsource = []").find("list of sources is empty"), std::string::npos);
  EXPECT_NE(bad("[[imagery]]\nsource = [\"a.tdb\", \"c.tdb\"]").find("there is no file"), std::string::npos);
  EXPECT_NE(bad("[[elevation]]\nsource = [\"a.tdb\"]").find("text in quotes"), std::string::npos);
  EXPECT_NE(bad("[light]\nsun = [91, 0]").find("from -90 to 90"), std::string::npos);
  EXPECT_NE(bad("[light]\nsun = \"moon\"").find("\"camera\" or"), std::string::npos);
  EXPECT_NE(bad("[light]\nsun = [1]").find("\"camera\" or"), std::string::npos);
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

}  // namespace
}  // namespace tellurion::scene
