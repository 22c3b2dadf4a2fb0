#include "render/draw_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <optional>

#include "geo/seed_test.h"
#include "render/geometry_arena.h"

namespace tellurion::render {
namespace {

namespace shading {
#include "render/shaders/constants.glsl"
}  // namespace shading

using Kind = TileColours::Kind;

/// Tiles on a line away from the eye, with a picture by day and night lights that lie in given blocks.
class DrawPlanTest : public testing::Test {
 protected:
  void add(std::uint32_t chunk, std::uint32_t colourBlock, std::uint32_t secondBlock, double far_m,
           bool isOpaque = true) {
    auto mesh = std::make_shared<scene::TerrainMesh>();
    mesh->origin = {{far_m, 0.0, 0.0}};
    mesh->interior = {0, 3};
    scene::DrawnTile& tile = frame_.tiles.emplace_back();
    tile.mesh = mesh;
    tile.firstPicture = static_cast<std::uint32_t>(2 * count_);
    tile.pictureCount = 2;
    for (const bool isLamps : {false, true}) {
      auto image = std::make_shared<scene::TextureImage>();
      image->isOpaque = !isLamps && isOpaque;
      image->mips.emplace_back(1, 1, raster::Rgba8{9, 9, 9, 255});
      frame_.pictures.push_back({.image = image, .window = {}, .layer = isLamps ? 1u : 0u});
      places_.push_back({.block = isLamps ? secondBlock : colourBlock, .layer = 3});
    }
    meshes_.push_back({.chunk = chunk});
    ++count_;
  }

  void plan() {
    frame_.looks.assign(2, {});
    frame_.looks[1].role = scene::LayerRole::nightLights;
    std::vector<ResidentPicture> pictures;
    for (std::size_t i = 0; i < places_.size(); ++i)
      pictures.push_back({.picture = &frame_.pictures[i], .place = &places_[i]});
    tiles_.clear();
    for (std::size_t i = 0; i < count_; ++i)
      tiles_.push_back({.tile = &frame_.tiles[i],
                        .mesh = &meshes_[i],
                        .relief = i < reliefs_.size() && reliefs_[i] ? &*reliefs_[i] : nullptr});
    plan_.make(frame_, tiles_, pictures, {});
  }

  /// Of random blocks, with or without night lights, pictures that cover all and reliefs.
  void addRandom(std::mt19937_64& random, std::uint32_t chunks, std::uint32_t colourBlocks,
                 std::uint32_t reliefBlocks) {
    const auto below = [&](std::uint32_t end) { return static_cast<std::uint32_t>(random() % end); };
    add(below(chunks), below(colourBlocks), below(colourBlocks), geo::uniform(random, 1e3, 1e7), random() % 3 != 0);
    frame_.tiles.back().pictureCount = below(3);
    places_.back().layer = below(2000);
    std::prev(places_.end(), 2)->layer = below(2000);
    reliefs_.emplace_back();
    if (random() % 4 != 0) reliefs_.back() = TexturePlace{.block = below(reliefBlocks), .layer = below(2000)};
  }

  /// That the group's program reads this tile's mesh, relief and pictures, and no others.
  void expectRead(const DrawGroup& group, std::size_t tile) const {
    const TileRecord& record = plan_.records()[tile];
    const std::uint32_t pictureCount = frame_.tiles[tile].pictureCount;
    const auto& relief = reliefs_[tile];
    ASSERT_EQ(group.run.chunk, meshes_[tile].chunk);
    if (group.kind == Kind::layered) {
      ASSERT_EQ(record.reliefLayer, relief ? relief->number() : -1);
      ASSERT_EQ(record.pictureCount, pictureCount);
      for (std::uint32_t i = 0; i < pictureCount; ++i) {
        const float place = plan_.pictureRecords()[static_cast<std::size_t>(record.colourLayer) + i].place;
        ASSERT_EQ(place, static_cast<float>(places_[2 * tile + i].number()));
      }
      return;
    }
    ASSERT_EQ(record.reliefLayer, relief ? static_cast<int>(relief->layer) : -1);
    if (relief) {
      ASSERT_EQ(group.reliefBlock, relief->block);
    }
    ASSERT_EQ(record.colourLayer, pictureCount > 0 ? static_cast<int>(places_[2 * tile].layer) : -1);
    if (pictureCount > 0) {
      ASSERT_EQ(group.colourBlock, places_[2 * tile].block);
    }
    ASSERT_EQ(group.kind, pictureCount == 2 ? Kind::lamps : Kind::one);
    if (pictureCount == 2) {
      ASSERT_EQ(group.secondBlock, places_[2 * tile + 1].block);
      ASSERT_EQ(record.pictureCount, static_cast<int>(places_[2 * tile + 1].layer));
    }
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
  std::vector<std::optional<TexturePlace>> reliefs_;
  DrawPlan plan_;
};

TEST_F(DrawPlanTest, NightLightsHaveAProgramOfTheirOwnWithinFourDrawCalls) {
  for (std::uint32_t i = 0; i < 4; ++i)
    add(0, i, 7, 1e6);
  plan();
  EXPECT_EQ(groupsOf(Kind::lamps), 4u);
  EXPECT_EQ(plan_.groups()[2].secondBlock, 7u);
  for (const TileRecord& record : plan_.records())
    EXPECT_EQ(record.pictureCount, 3);  // the layer of the lamps
}

TEST_F(DrawPlanTest, BeyondThatAsManyAsMustGoWithTilesOfSeveralPictures) {
  for (std::uint32_t i = 0; i < 5; ++i)
    add(0, i, 7, 1e6);
  plan();
  ASSERT_EQ(plan_.groups().size(), 4u);
  EXPECT_EQ(groupsOf(Kind::lamps), 3u);
  for (const DrawGroup& group : plan_.groups()) {
    EXPECT_EQ(group.run.count, group.kind == Kind::layered ? 2u : 1u);
    for (std::size_t c = group.run.first; c < group.run.first + group.run.count; ++c) {
      const std::uint32_t tile = plan_.commands()[c].baseInstance;
      const TileRecord& record = plan_.records()[tile];
      EXPECT_EQ(record.pictureCount, group.kind == Kind::layered ? 2 : 3);  // records, or the layer of the lamps
      EXPECT_EQ(record.colourLayer, group.kind == Kind::layered ? static_cast<std::int32_t>(2 * tile) : 3);
    }
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

// However tiles are spread over as many chunks and blocks as there may be.
TEST_F(DrawPlanTest, NeverMoreThanFourDrawCallsAndEachTileOnceFromItsOwnBlocks) {
  auto random = geo::seededGenerator();
  std::array<int, kMostDrawCalls + 1> plansOf{};
  bool someStayAsTheyAre = false;
  for (int round = 0; round < 2000; ++round) {
    frame_ = {};
    count_ = 0;
    places_.clear();
    meshes_.clear();
    reliefs_.clear();
    const auto upTo = [&](std::size_t most) { return static_cast<std::uint32_t>(1 + random() % most); };
    const std::uint32_t chunks = upTo(GeometryArena::kMostChunks);
    const std::uint32_t colourBlocks = upTo(shading::kMostBlocks);
    const std::uint32_t reliefBlocks = upTo(shading::kMostReliefBlocks);
    for (std::uint32_t left = upTo(60); left > 0; --left)
      addRandom(random, chunks, colourBlocks, reliefBlocks);
    plan();
    ASSERT_LE(plan_.groups().size(), kMostDrawCalls);
    ++plansOf.at(plan_.groups().size());
    std::vector<int> seen(count_, 0);
    for (const DrawGroup& group : plan_.groups()) {
      someStayAsTheyAre = someStayAsTheyAre || group.kind != Kind::layered;
      for (std::size_t c = group.run.first; c < group.run.first + group.run.count; ++c) {
        const std::size_t tile = plan_.commands()[c].baseInstance;
        ++seen[tile];
        expectRead(group, tile);
        if (HasFatalFailure()) FAIL() << "round " << round << ", tile " << tile;
      }
    }
    ASSERT_EQ(seen, std::vector<int>(count_, 1));
  }
  for (std::size_t calls = 1; calls <= kMostDrawCalls; ++calls)
    EXPECT_GT(plansOf.at(calls), 20) << calls;
  EXPECT_TRUE(someStayAsTheyAre);
}

// It costs more a pixel to read all blocks, so no more tiles do than must.
TEST_F(DrawPlanTest, TheManyOfABlockKeepTheirProgram) {
  for (std::uint32_t block = 0; block < 8; ++block) {
    for (std::uint32_t i = 0; i <= block; ++i) {
      add(0, block, 0, 1e6);
      frame_.tiles.back().pictureCount = 1;
    }
  }
  plan();
  EXPECT_EQ(plan_.groups().size(), 4u);
  EXPECT_EQ(groupsOf(Kind::one), 3u);
  for (const DrawGroup& group : plan_.groups()) {
    EXPECT_EQ(group.run.count, group.kind == Kind::one ? group.colourBlock + 1 : 1u + 2 + 3 + 4 + 5);
    EXPECT_TRUE(group.kind == Kind::layered || group.colourBlock >= 5);
  }
}

}  // namespace
}  // namespace tellurion::render
