#include "render/draw_plan.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "geo/seed_test.h"

namespace tellurion::render {
namespace {

/// Tiles on a line away from the eye, with a picture by day and night lights that lie in given blocks.
class DrawPlanTest : public testing::Test {
 protected:
  void add(std::uint32_t chunk, std::uint32_t colourBlock, std::uint32_t lampsBlock, double far_m) {
    auto mesh = std::make_shared<scene::TerrainMesh>();
    mesh->origin = {{far_m, 0.0, 0.0}};
    mesh->interior = {0, 3};
    scene::DrawnTile& tile = frame_.tiles.emplace_back();
    tile.mesh = mesh;
    tile.firstPicture = static_cast<std::uint32_t>(2 * count_);
    tile.pictureCount = 2;
    for (const bool isLamps : {false, true}) {
      auto image = std::make_shared<scene::TextureImage>();
      image->isOpaque = !isLamps;
      image->mips.emplace_back(1, 1, raster::Rgba8{9, 9, 9, 255});
      frame_.pictures.push_back({.image = image, .window = {}, .layer = isLamps ? 1u : 0u});
      places_.push_back({.block = isLamps ? lampsBlock : colourBlock, .layer = 3});
    }
    meshes_.push_back({.chunk = chunk});
    ++count_;
  }

  void plan() {
    frame_.looks.assign(2, {});
    frame_.looks[1].nightLights = true;
    std::vector<ResidentPicture> pictures;
    for (std::size_t i = 0; i < places_.size(); ++i)
      pictures.push_back({.picture = &frame_.pictures[i], .place = &places_[i]});
    tiles_.clear();
    for (std::size_t i = 0; i < count_; ++i)
      tiles_.push_back({.tile = &frame_.tiles[i], .mesh = &meshes_[i]});
    plan_.make(frame_, tiles_, pictures, {});
  }

  std::size_t groupsOf(TileColours::Kind kind) const {
    return static_cast<std::size_t>(
        std::ranges::count_if(plan_.groups(), [&](const DrawGroup& group) { return group.kind == kind; }));
  }

  scene::Frame frame_;
  std::size_t count_ = 0;
  std::vector<TexturePlace> places_;
  std::vector<MeshPlace> meshes_;
  std::vector<ResidentTile> tiles_;
  DrawPlan plan_;
};

using Kind = TileColours::Kind;

TEST_F(DrawPlanTest, NightLightsHaveAProgramOfTheirOwnWithinFourDrawCalls) {
  for (std::uint32_t i = 0; i < 4; ++i)
    add(0, i, 7, 1e6);
  plan();
  EXPECT_EQ(groupsOf(Kind::night), 4u);
  EXPECT_EQ(plan_.groups()[2].lampsBlock, 7u);
  for (const TileRecord& record : plan_.records())
    EXPECT_EQ(record.pictureCount, 3);  // the layer of the lamps
}

TEST_F(DrawPlanTest, BeyondThatTheyGoWithTheOthers) {
  for (std::uint32_t i = 0; i < 5; ++i)
    add(0, i, 7, 1e6);
  plan();
  ASSERT_EQ(plan_.groups().size(), 1u);
  EXPECT_EQ(groupsOf(Kind::layered), 1u);
  EXPECT_EQ(plan_.groups()[0].run.count, 5u);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(plan_.records()[i].pictureCount, 2);  // records
    EXPECT_EQ(plan_.records()[i].colourLayer, static_cast<std::int32_t>(2 * i));
  }
}

// Whatever the blocks: each tile in one group that reads its chunk and its blocks, groups and the tiles of a group from
// near to far.
TEST_F(DrawPlanTest, EachTileOnceFromNearToFar) {
  auto random = geo::seededGenerator();
  for (int i = 0; i < 300; ++i)
    add(static_cast<std::uint32_t>(random() % 2), static_cast<std::uint32_t>(random() % 2), 0,
        geo::uniform(random, 1e3, 1e7));
  plan();
  std::vector<int> seen(count_, 0);
  float nearestOfGroup = 0.0f;
  for (const DrawGroup& group : plan_.groups()) {
    EXPECT_GE(group.nearest, nearestOfGroup);
    nearestOfGroup = group.nearest;
    double before_m = 0.0;
    for (std::size_t c = group.run.first; c < group.run.first + group.run.count; ++c) {
      const std::size_t tile = plan_.commands()[c].baseInstance;
      ++seen[tile];
      EXPECT_EQ(meshes_[tile].chunk, group.run.chunk);
      EXPECT_EQ(places_[2 * tile].block, group.colourBlock);
      EXPECT_GE(frame_.tiles[tile].mesh->origin.m.x, before_m - 1.0);
      before_m = frame_.tiles[tile].mesh->origin.m.x;
    }
  }
  EXPECT_EQ(seen, std::vector<int>(count_, 1));
  EXPECT_EQ(plan_.triangles(), 300);
}

}  // namespace
}  // namespace tellurion::render
