#include "scene/scene_setting.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "scene/scene_file.h"

namespace tellurion::scene {
namespace {

namespace fs = std::filesystem;

class SceneSetting : public testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("tellurion_scene_setting_" + std::to_string(::getpid()));
    fs::create_directories(folder);
    for (const char* name : {"a.tdb", "b.v2.tif", "c.tif"})
      std::ofstream(folder / name) << "x";
    path = (folder / "scene.toml").string();
  }
  void TearDown() override { fs::remove_all(folder); }

  Scene with(const std::vector<std::string>& settings, std::string_view text = kText) {
    auto scene = parseScene(text, path, settings);
    EXPECT_TRUE(scene) << (scene ? "" : io::describe(scene.error()));
    return scene.value_or(Scene{});
  }
  std::string bad(const std::string& setting, std::string_view text = kText) {
    const auto scene = parseScene(text, path, std::vector{setting});
    return scene ? "no failure" : scene.error().where + ": " + scene.error().message;
  }

  static constexpr std::string_view kText = R"(
[[elevation]]
source = "a.tdb"
[[imagery]]
source = "b.v2.tif"
opacity = 0.5
[[imagery]]
source = "http://127.0.0.1/wms"
layer = "clouds"
time = "clock"
[[imagery]]
type = "hillshade"
[[imagery]]
source = "c.tif"
name = "Own"
)";
  fs::path folder;
  std::string path;
};

// What is set counts as what is written.
TEST_F(SceneSetting, isAsIfTheFileSaidSo) {
  struct Case {
    std::vector<std::string> settings;
    std::string_view text;
  };
  const std::vector<Case> cases{
      {{"background=101820"}, "background = \"101820\""},
      {{"background=0a0b0c", "name=2004"}, "background = \"0a0b0c\"\nname = \"2004\""},
      {{"light.ambient=0.25", "light.sun=[10, -20.5]"}, "[light]\nambient = 0.25\nsun = [10, -20.5]"},
      {{"light.enabled=false", "body=mars"}, "body = \"mars\"\n[light]\nenabled = false"},
      {{"clock.start=2004-07-01", "clock.rate=-60"}, "[clock]\nstart = \"2004-07-01\"\nrate = -60"},
      {{"clock.start=2004"}, "[clock]\nstart = \"2004\""},
      {{"body={semi_major_axis_m = 1000.0}", "tiling=\"healpix\""},
       "body = {semi_major_axis_m = 1000.0}\ntiling = \"healpix\""},
      {{"light.ambient=0.1", "light.ambient=0.2"}, "[light]\nambient = 0.2"},
  };
  for (const auto& [settings, text] : cases) {
    const Scene a = with(settings, ""), b = with({}, text);
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.body, b.body) << text;
    EXPECT_EQ(a.tiling, b.tiling) << text;
    EXPECT_EQ(a.background, b.background) << text;
    EXPECT_EQ(a.lighting.ambient, b.lighting.ambient) << text;
    EXPECT_EQ(a.lighting.enabled, b.lighting.enabled) << text;
    EXPECT_EQ(a.lighting.sun, b.lighting.sun) << text;
    EXPECT_EQ(a.lighting.subsolar.n, b.lighting.subsolar.n) << text;
    EXPECT_EQ(a.clock.start_s, b.clock.start_s) << text;
    EXPECT_EQ(a.clock.rate, b.clock.rate) << text;
  }
}

TEST_F(SceneSetting, meansALayerByItsNumberOrAnyOfItsNames) {
  for (const char* which : {"0", "b.v2.tif", "b.v2"}) {
    const Scene scene = with({std::string("imagery.") + which + ".opacity=0.25"});
    EXPECT_EQ(scene.imagery.at(0).look.opacity, 0.25) << which;
    EXPECT_EQ(scene.imagery.at(3).look.opacity, 1.0) << which;
  }
  const Scene scene =
      with({"imagery.clouds.blend=screen", "imagery.clouds.time=2004-07-01", "imagery.Own.visible=false",
            "imagery.hillshade.sun_altitude=60", "elevation.a.seam_m=7", "imagery.3.gamma=2"});
  EXPECT_EQ(scene.imagery.at(1).look.blend, BlendMode::screen);
  EXPECT_EQ(scene.imagery.at(1).service.time, "2004-07-01");
  EXPECT_DOUBLE_EQ(std::get<raster::Hillshade>(scene.imagery.at(2).derived->colours).sunAltitude.degrees(), 60.0);
  EXPECT_FALSE(scene.imagery.at(3).look.visible);
  EXPECT_EQ(scene.imagery.at(3).look.gamma, 2.0);
  EXPECT_EQ(scene.elevation.at(0).seam_m, 7.0);
}

TEST_F(SceneSetting, thatIsWrongIsNamedItself) {
  const auto has = [this](const std::string& setting, const std::string& part) {
    const std::string told = bad(setting);
    EXPECT_EQ(told.rfind("--set " + setting + ": ", 0), 0u) << told;
    EXPECT_NE(told.find(part), std::string::npos) << told;
  };
  has("imagery.0.opacity=2", "from 0 to 1");
  has("imagery.0.opacity=much", "from 0 to 1");
  has("imagery.0.blend=burn", "allowed: normal");
  has("imagery.0.colour=1", "unknown key 'colour'");
  has("ligth.ambient=1", "unknown key 'ligth'");
  has("light.sun=[1, \"x\"]", "number");
  has("imagery.9.opacity=1", "0 (b.v2.tif), 1 (clouds), 2 (hillshade), 3 (Own)");
  has("imagery.moon.opacity=1", "is no layer's name");
  has("name.first=x", "'name' must be a text");
  has("imagery.0.opacity.x=1", "is no layer's name");
  EXPECT_NE(
      bad("imagery.a.opacity=1", "[[imagery]]\nsource = \"a.tdb\"\n[[imagery]]\nsource = \"a.tdb\"").find("several"),
      std::string::npos);
  for (const char* text : {"", "=", "a", "=1", ".a=1", "a.=1", "imagery.opacity=1", "imagery=1", "elevation..seam_m=2"})
    EXPECT_FALSE(parseSetting(text)) << text;
}

// A value cannot bring other keys with it.
TEST_F(SceneSetting, ofSeveralLinesIsAText) {
  EXPECT_EQ(with({"name=1\ntiling = \"healpix\""}, "").tiling, tiling::Scheme::cube);
}

TEST_F(SceneSetting, changesScenesWithoutAFile) {
  const auto scene = openScene("http://127.0.0.1/wms#blue\"marble", std::vector<std::string>{"imagery.0.opacity=0.5"});
  ASSERT_TRUE(scene) << io::describe(scene.error());
  EXPECT_EQ(scene->imagery.at(0).service.layer, "blue\"marble");
  EXPECT_EQ(scene->imagery.at(0).look.opacity, 0.5);
  const auto plain = openScene("http://127.0.0.1/wms#blue\"marble");
  ASSERT_TRUE(plain);
  EXPECT_EQ(scene->name, plain->name);
  EXPECT_EQ(scene->imagery.at(0).source, plain->imagery.at(0).source);
}

}  // namespace
}  // namespace tellurion::scene
