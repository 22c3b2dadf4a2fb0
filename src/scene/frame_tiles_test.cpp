// A frame's tiles are the same whether they were moved over from the last frame or made anew.

#include "scene/frame_tiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>

#include "geo/body.h"
#include "geo/seed_test.h"

namespace tellurion::scene {
namespace {

constexpr int kLayers = 3;

ContentMaker makerOf(const tiling::Tiling& tiling) {
  return {.tiling = tiling,
          .ellipsoid = geo::earth().ellipsoid,
          .ground = GroundLayers(tiling, {}, 64),
          .colours = ColourLayers(std::vector<ColourLayers::Layer>(kLayers))};
}

std::shared_ptr<const TileContent> someContent(const tiling::TileId& id, std::mt19937_64& random) {
  auto content = std::make_shared<TileContent>();
  content->mesh = std::make_shared<TerrainMesh>();
  const auto picture = [&] { return random() % 4 == 0 ? nullptr : std::make_shared<const TextureImage>(); };
  const auto level = [&] { return static_cast<int>(random() % (id.level + 1u)); };
  content->relief = picture();
  content->reliefLevel = level();
  content->pictures.resize(kLayers);
  for (LayerPicture& each : content->pictures) {
    each.image = picture();
    each.level = level();
  }
  return content;
}

void expectSame(const Frame& a, std::span<const DrawnTile> ofA, const Frame& b, std::span<const DrawnTile> ofB) {
  ASSERT_EQ(ofA.size(), ofB.size());
  for (std::size_t i = 0; i < ofA.size(); ++i) {
    ASSERT_EQ(ofA[i].id, ofB[i].id);
    ASSERT_EQ(ofA[i].mesh, ofB[i].mesh);
    ASSERT_EQ(ofA[i].relief, ofB[i].relief);
    ASSERT_EQ(ofA[i].reliefWindow.offset, ofB[i].reliefWindow.offset);
    ASSERT_EQ(ofA[i].coarseEdges, ofB[i].coarseEdges);
    ASSERT_EQ(ofA[i].morph, ofB[i].morph);
    ASSERT_EQ(ofA[i].pictureCount, ofB[i].pictureCount);
    for (std::uint32_t k = 0; k < ofA[i].pictureCount; ++k) {
      const DrawnPicture& p = a.pictures[ofA[i].firstPicture + k];
      const DrawnPicture& q = b.pictures[ofB[i].firstPicture + k];
      ASSERT_EQ(p.image, q.image);
      ASSERT_EQ(p.layer, q.layer);
      ASSERT_EQ(p.window.offset, q.window.offset);
      ASSERT_EQ(p.window.scale, q.window.scale);
    }
  }
}

TEST(FrameTiles, movedOverAreAsMadeAnew) {
  std::mt19937_64 random = geo::seededGenerator();
  const ContentMaker maker = makerOf(tiling::Tiling(tiling::Scheme::cube));
  std::deque<TileRecord> records(40);
  for (std::size_t i = 0; i < records.size(); ++i) {
    records[i].id = {.level = 6, .root = static_cast<std::uint8_t>(i % 6), .x = static_cast<std::uint32_t>(i), .y = 3};
    records[i].content = someContent(records[i].id, random);
  }
  std::vector<std::uint32_t> order{0, 1, 2};
  std::vector<TileRecord*> shuffled;
  for (TileRecord& r : records)
    shuffled.push_back(&r);
  FrameTiles kept;
  Frame frame;
  for (int i = 0; i < 200; ++i) {
    TileRecord& changes = records[random() % records.size()];
    changes.content = someContent(changes.id, random);
    if (i % 10 == 0) std::ranges::shuffle(order, random);
    std::ranges::shuffle(shuffled, random);
    const std::size_t drawn = random() % shuffled.size();
    const std::size_t soon = drawn + random() % (shuffled.size() - drawn);
    FrameTiles fresh;
    Frame expected;
    const auto fill = [&](FrameTiles& tiles, Frame& into) {
      tiles.begin(into, order);
      for (std::size_t k = 0; k < soon; ++k) {
        if (k == drawn) tiles.beginSoon();
        TileRecord& r = *shuffled[k];
        tiles.add({.id = r.id, .facts = &r, .coarseEdges = static_cast<std::uint8_t>(k % 16), .error_px = 0.5}, maker);
      }
      tiles.finish();
    };
    std::vector<std::uint32_t> places;
    for (const TileRecord& r : records)
      places.push_back(r.drawnAt);
    fill(fresh, expected);
    for (std::size_t k = 0; k < records.size(); ++k)
      records[k].drawnAt = places[k];
    fill(kept, frame);
    expectSame(frame, frame.tiles, expected, expected.tiles);
    expectSame(frame, frame.soon, expected, expected.soon);
  }
  // The frame and the contents are the owners: nothing of earlier frames is held.
  const std::shared_ptr<const TileContent> last = std::exchange(records[0].content, someContent(records[0].id, random));
  kept.begin(frame, order);
  kept.finish();
  EXPECT_EQ(last.use_count(), 1);
  EXPECT_EQ(last->mesh.use_count(), 1);
}

}  // namespace
}  // namespace tellurion::scene
