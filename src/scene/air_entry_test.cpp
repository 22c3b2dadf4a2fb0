// The table [atmosphere] of scene files: what it means, and what is said when it is wrong.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/scene_file.h"

namespace tellurion::scene {
namespace {

using testing::HasSubstr;

io::Result<Scene> parsed(const std::string& text, const std::vector<std::string>& settings = {}) {
  return parseScene(text, "s.toml", settings);
}

std::string complaint(const std::string& text, const std::vector<std::string>& settings = {}) {
  const auto scene = parsed(text, settings);
  return scene ? "" : io::describe(scene.error());
}

TEST(AirEntry, leftOutMeansNoAir) {
  EXPECT_FALSE(parsed("")->air.enabled);
  EXPECT_FALSE(parsed("body = \"mars\"\n")->air.enabled);
}

TEST(AirEntry, isTheBodysOwn) {
  EXPECT_EQ(parsed("[atmosphere]")->air.atmosphere, atmosphereByName("earth"));
  EXPECT_TRUE(parsed("[atmosphere]")->air.enabled);
  const auto mars = parsed("body = \"mars\"\n[atmosphere]\nenabled = false");
  EXPECT_EQ(mars->air.atmosphere, atmosphereByName("mars"));
  EXPECT_FALSE(mars->air.enabled);
}

TEST(AirEntry, changesWhatItNames) {
  const auto scene = parsed(
      "[atmosphere]\naerosol_depth = 0.3\naerosol_albedo = [0.9, 0.8, 0.7]\nsun_radius = 1\nexposure = -1.5\n"
      "bottom_m = -430");
  ASSERT_TRUE(scene) << io::describe(scene.error());
  const Atmosphere& air = scene->air.atmosphere;
  EXPECT_EQ(air.aerosolDepth, (ThreeBands{0.3, 0.3, 0.3}));
  EXPECT_EQ(air.aerosolAlbedo, (ThreeBands{0.9, 0.8, 0.7}));
  EXPECT_EQ(air.sunRadius_degrees, 1.0);
  EXPECT_EQ(air.bottom_m, -430.0);
  EXPECT_EQ(air.gasDepth, atmosphereByName("earth")->gasDepth);
  EXPECT_EQ(scene->air.exposure_stops, -1.5);
  EXPECT_EQ(parsed("[atmosphere]\nexposure = \"auto\"")->air.exposure_stops, std::nullopt);
}

TEST(AirEntry, mayBeSet) {
  EXPECT_TRUE(parsed("", {"atmosphere.enabled=true"})->air.enabled);
  EXPECT_EQ(parsed("", {"atmosphere.exposure=2"})->air.exposure_stops, 2.0);
  EXPECT_THAT(complaint("", {"atmosphere.exposure=99"}), HasSubstr("--set atmosphere.exposure=99"));
}

TEST(AirEntry, ofAnUnknownBodySaysWhatIsMissing) {
  const std::string body = "body = { semi_major_axis_m = 1e6, name = \"own\" }\n";
  EXPECT_THAT(complaint("body = \"moon\"\n[atmosphere]"), HasSubstr("the air of 'moon' is not known"));
  EXPECT_THAT(complaint(body + "[atmosphere]\ntop_m = 50000"), HasSubstr("missing: gas_depth, gas_height_m"));
  const auto own = parsed(body + "[atmosphere]\ntop_m = 50000\ngas_depth = [0.1, 0.2, 0.3]\ngas_height_m = 5000");
  ASSERT_TRUE(own) << io::describe(own.error());
  EXPECT_EQ(own->air.atmosphere.top_m, 50000.0);
  EXPECT_EQ(parsed(body + "[atmosphere]\nmodel = \"mars\"")->air.atmosphere, atmosphereByName("mars"));
}

TEST(AirEntry, wrongOnesAreNamedWithTheirPlace) {
  EXPECT_THAT(complaint("[atmosphere]\nhaze = 1"), HasSubstr("unknown key 'haze'"));
  EXPECT_THAT(complaint("[atmosphere]\nhaze = 1"), HasSubstr("s.toml:2"));
  for (const char* wrong :
       {"enabled = 1", "model = \"venus\"", "exposure = \"bright\"", "exposure = 21", "top_m = nan", "top_m = 7e6",
        "gas_depth = -1", "gas_depth = [1, 2]", "gas_depth = [1, 2, \"x\"]", "aerosol_albedo = 1.5",
        "aerosol_forward = 1", "bottom_m = 5", "gas_height_m = 0", "sun_radius = inf", "ozone_reach_m = \"1\""})
    EXPECT_THAT(complaint(std::string("[atmosphere]\n") + wrong), HasSubstr("s.toml:")) << wrong;
  const std::string deep = "[atmosphere]\nbottom_m = -8000\naerosol_height_m = ";
  EXPECT_THAT(complaint(deep + "199"), HasSubstr("200 m or more"));
  EXPECT_EQ(complaint(deep + "200"), "");
}

}  // namespace
}  // namespace tellurion::scene
