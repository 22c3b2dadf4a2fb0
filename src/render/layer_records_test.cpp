#include "render/layer_records.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "geo/geodetic.h"

namespace tellurion::render {
namespace {

using scene::LayerLook;

class LayerRecords : public testing::Test {
 protected:
  LayerRecords() {
    for (const bool isOpaque : {true, false}) {
      auto image = std::make_shared<scene::TextureImage>();
      image->isOpaque = isOpaque;
      image->mips.emplace_back(1, 1, raster::Rgba8{255, 0, 0, 255});
      (isOpaque ? opaque : patchy) = image;
    }
  }

  /// The slices of the records in their order, or "as it is N" of one picture.
  std::string shown(const std::vector<std::shared_ptr<const scene::TextureImage>>& images,
                    const std::vector<LayerLook>& looks, bool lampsBurn = false) {
    std::vector<scene::DrawnPicture> pictures;
    std::vector<TexturePlace> places;
    for (std::uint32_t i = 0; i < images.size(); ++i) {
      pictures.push_back({.image = images[i], .window = {}, .layer = i});
      places.push_back({.block = 0, .layer = i});
    }
    std::vector<ResidentPicture> resident;
    for (std::size_t i = 0; i < images.size(); ++i)
      resident.push_back({.picture = &pictures[i], .place = &places[i]});
    std::vector<PictureRecord> records(5);  // of other tiles
    const TileColours colours = coloursOf(resident, looks, {.lamps = lampsBurn, .mirror = true}, records);
    EXPECT_EQ(records.size(), 5 + colours.count);
    const std::string one =
        colours.one.picture != nullptr ? "as it is " + std::to_string(colours.one.place->layer) : "nothing";
    if (colours.kind == TileColours::Kind::one) return one;
    EXPECT_EQ(colours.first, 5u);
    std::string out;
    for (std::size_t i = 5; i < records.size(); ++i)
      out += std::to_string(static_cast<int>(records[i].place));
    if (colours.kind == TileColours::Kind::layered) return out;
    out += ", or " + one + (colours.kind == TileColours::Kind::water ? " and water " : " and lamps ") +
           std::to_string(colours.second.place->layer);
    if (colours.kind == TileColours::Kind::both) out += ", water " + std::to_string(colours.third.place->layer);
    return out;
  }

  std::shared_ptr<const scene::TextureImage> opaque;
  std::shared_ptr<const scene::TextureImage> patchy;
};

TEST_F(LayerRecords, OnePictureThatCoversAllIsDrawnAsItIs) {
  EXPECT_EQ(shown({}, {}), "nothing");
  EXPECT_EQ(shown({opaque}, {{}}), "as it is 0");
  EXPECT_EQ(shown({opaque, opaque, opaque}, {{}, {}, {}}), "as it is 2");
  EXPECT_EQ(shown({patchy, opaque}, {{}, {}}), "as it is 1");
  EXPECT_EQ(shown({opaque, opaque}, {{}, {.visible = false}}), "as it is 0");
  EXPECT_EQ(shown({opaque, opaque}, {{}, {.opacity = 0.0}}), "as it is 0");
  EXPECT_EQ(shown({opaque}, {{.visible = false}}), "nothing");
}

TEST_F(LayerRecords, WhatShowsThroughIsLayered) {
  EXPECT_EQ(shown({patchy}, {{}}), "0");
  EXPECT_EQ(shown({opaque, patchy}, {{}, {}}), "01");
  EXPECT_EQ(shown({opaque, opaque}, {{}, {.opacity = 0.5}}), "01");
  EXPECT_EQ(shown({opaque, opaque}, {{}, {.blend = scene::BlendMode::multiply}}), "01");
  EXPECT_EQ(shown({opaque}, {{.gamma = 2.0}}), "0");
}

TEST_F(LayerRecords, BelowAPictureThatCoversAllNothingShows) {
  EXPECT_EQ(shown({opaque, patchy, opaque, patchy}, {{}, {}, {}, {}}), "23");
  EXPECT_EQ(shown({opaque, patchy, opaque, patchy}, {{}, {}, {.contrast = 0.5}, {.visible = false}}), "2");
  EXPECT_EQ(shown({opaque, patchy, opaque, patchy}, {{}, {}, {.opacity = 0.9}, {}}), "0123");
}

TEST_F(LayerRecords, LampsBurnWhateverLiesOverThemButNotByDay) {
  const LayerLook lamps{.role = scene::LayerRole::nightLights};
  EXPECT_EQ(shown({opaque, patchy}, {{}, lamps}, true), "01, or as it is 0 and lamps 1");
  EXPECT_EQ(shown({patchy, opaque}, {lamps, {}}, true), "01, or as it is 1 and lamps 0");
  EXPECT_EQ(shown({opaque, opaque, patchy}, {{}, {}, lamps}, true), "12, or as it is 1 and lamps 2");
  EXPECT_EQ(shown({patchy}, {lamps}, true), "0, or nothing and lamps 0");
  EXPECT_EQ(shown({opaque, patchy, patchy}, {{}, lamps, lamps}, true), "012");
  EXPECT_EQ(shown({patchy, patchy}, {{}, lamps}, true), "01");
  EXPECT_EQ(shown({opaque, patchy}, {{.saturation = 0.5}, lamps}, true), "01");
  EXPECT_EQ(shown({patchy, opaque}, {lamps, {}}, false), "as it is 1");
  EXPECT_EQ(shown({opaque, opaque}, {{}, lamps}, false), "as it is 0");
}

TEST_F(LayerRecords, WaterMirrorsWhateverLiesOverIt) {
  const LayerLook water{.role = scene::LayerRole::water}, lamps{.role = scene::LayerRole::nightLights};
  EXPECT_EQ(shown({opaque, patchy}, {{}, water}), "01, or as it is 0 and water 1");
  EXPECT_EQ(shown({patchy, opaque}, {water, {}}), "01, or as it is 1 and water 0");
  EXPECT_EQ(shown({opaque, patchy, patchy}, {{}, water, lamps}, true), "012, or as it is 0 and lamps 2, water 1");
  EXPECT_EQ(shown({patchy, patchy, opaque}, {lamps, water, {}}, true), "012, or as it is 2 and lamps 0, water 1");
  EXPECT_EQ(shown({opaque, patchy, patchy}, {{}, water, water}, true), "012");
  EXPECT_EQ(shown({opaque, patchy, patchy, patchy}, {{}, water, lamps, water}, true), "0123");
  scene::TerrainMesh mesh{.upReach = 0.1f};
  for (const double lon : {0.0, 80.0, 92.0, 100.0, 180.0}) {
    mesh.middleUp_body = geo::Vec3f(geo::directionFromDegrees(0, lon).n);
    const scene::Light light{.toSun_body = geo::directionFromDegrees(0, 0).n};
    EXPECT_EQ(effectsOn(mesh, light).mirror, std::cos(lon * geo::kPi / 180.0) + 0.1 > -0.05) << lon;
  }
}

TEST_F(LayerRecords, LampsMayBurnWhereTheSunIsLow) {
  scene::TerrainMesh mesh;
  scene::Light light{.toSun_body = geo::directionFromDegrees(0, 0).n};
  EXPECT_TRUE(effectsOn(mesh, light).lamps);  // nothing is known of its normals
  mesh.upReach = 0.1f;
  for (const double lon : {0.0, 60.0, 80.0, 100.0, 180.0}) {
    mesh.middleUp_body = geo::Vec3f(geo::directionFromDegrees(0, lon).n);
    EXPECT_EQ(effectsOn(mesh, light).lamps, std::cos(lon * geo::kPi / 180.0) - 0.1 < 0.02);
  }
  light.enabled = false;
  EXPECT_FALSE(effectsOn(mesh, light).lamps);
}

TEST_F(LayerRecords, NumbersThatAreNoneStayInTheirRange) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const scene::DrawnPicture picture{.image = opaque, .window = {}, .layer = 0};
  const ResidentPicture resident{.picture = &picture, .place = nullptr};
  std::vector<PictureRecord> records;
  coloursOf({&resident, 1}, std::vector<LayerLook>{{.opacity = 7.0, .brightness = nan, .contrast = -3.0, .gamma = 0.0}},
            {}, records);
  ASSERT_EQ(records.size(), 1u);
  EXPECT_EQ(records[0].place, -1.0f);
  EXPECT_EQ(records[0].window, geo::Vec4f(1.0f, 0.0f, 0.0f, 1.0f));  // its mean
  EXPECT_EQ(records[0].opacity, 1.0f);
  EXPECT_EQ(records[0].adjustment.x, 0.0f);
  EXPECT_EQ(records[0].adjustment.y, 0.0f);
  EXPECT_EQ(records[0].adjustment.w, 10.0f);
}

}  // namespace
}  // namespace tellurion::render
