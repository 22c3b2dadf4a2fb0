#include "render/terrain_pass.h"

#include <gtest/gtest.h>

#include <algorithm>

#include <cmath>

#include "geo/body.h"
#include "geo/seed_test.h"

namespace tellurion::render {
namespace {

/// Interior of 6 indices, fine edges of 3 each, coarse edges of 3 each, all in a row.
scene::TerrainMesh meshInARow() {
  scene::TerrainMesh mesh;
  mesh.interior = {0, 6};
  for (std::uint32_t e = 0; e < 4; ++e) {
    mesh.fineEdge[e] = {6 + 3 * e, 3};
    mesh.coarseEdge[e] = {18 + 3 * e, 3};
  }
  return mesh;
}

struct Commands {
  std::vector<DrawCommand> list;
  std::vector<std::uint32_t> indices;  // what is drawn, expanded
};

Commands commandsOf(std::uint8_t coarseEdges) {
  scene::DrawnTile tile;
  tile.mesh = std::make_shared<scene::TerrainMesh>(meshInARow());
  tile.coarseEdges = coarseEdges;
  const MeshPlace place{.firstVertex = 1000, .vertexCount = 9, .firstIndex = 5000, .indexCount = 30};
  Commands commands;
  appendCommands({.tile = &tile, .mesh = &place}, 17, commands.list);
  for (const DrawCommand& command : commands.list) {
    EXPECT_EQ(command.baseVertex, 1000);
    EXPECT_EQ(command.baseInstance, 17u);
    EXPECT_EQ(command.instanceCount, 1u);
    for (std::uint32_t i = 0; i < command.count; ++i)
      commands.indices.push_back(command.firstIndex - 5000 + i);
  }
  return commands;
}

TEST(TerrainPass, TileWithoutCoarserNeighboursIsOneCommand) {
  const Commands commands = commandsOf(0);
  ASSERT_EQ(commands.list.size(), 1u);
  EXPECT_EQ(commands.list[0].count, 18u);
}

TEST(TerrainPass, EachEdgeIsDrawnOnceFineOrCoarse) {
  for (unsigned int edges = 0; edges < 16; ++edges) {
    const Commands commands = commandsOf(static_cast<std::uint8_t>(edges));
    EXPECT_EQ(commands.indices.size(), 18u);
    for (std::uint32_t e = 0; e < 4; ++e) {
      const bool coarse = (edges >> e & 1u) != 0;
      EXPECT_EQ(std::ranges::count(commands.indices, 6 + 3 * e), coarse ? 0 : 1) << edges;
      EXPECT_EQ(std::ranges::count(commands.indices, 18 + 3 * e), coarse ? 1 : 0) << edges;
    }
  }
}

TEST(TerrainPass, RangesOfTwoTilesAreNeverJoined) {
  scene::DrawnTile tile;
  tile.mesh = std::make_shared<scene::TerrainMesh>(meshInARow());
  const MeshPlace first{.firstVertex = 0, .vertexCount = 9, .firstIndex = 0, .indexCount = 18};
  const MeshPlace second{.firstVertex = 9, .vertexCount = 9, .firstIndex = 18, .indexCount = 18};
  std::vector<DrawCommand> commands;
  appendCommands({.tile = &tile, .mesh = &first}, 0, commands);
  appendCommands({.tile = &tile, .mesh = &second}, 1, commands);
  EXPECT_EQ(commands.size(), 2u);
}

TEST(TerrainPass, OriginMinusEyeIsExactInTwoFloats) {
  auto random = geo::seededGenerator();
  for (const double far : {1.0, 1e4, 7e6, 4e8, 1e11}) {
    for (int i = 0; i < 1000; ++i) {
      const auto coordinate = [&] { return geo::uniform(random, -far, far); };
      const geo::BodyPosition eye{{coordinate(), coordinate(), coordinate()}};
      scene::DrawnTile tile;
      auto mesh = std::make_shared<scene::TerrainMesh>();
      mesh->origin = {glm::round(geo::Vec3(coordinate(), coordinate(), coordinate()) * 1024.0) / 1024.0};
      tile.mesh = mesh;
      const SnappedEye snapped = snappedEye(eye);
      const TileRecord record = recordOf({.tile = &tile}, snapped, geo::Vec3f(0.5f));
      const geo::Vec3 sum = geo::Vec3(record.originCoarse_rte) + geo::Vec3(record.originFine_rte);
      EXPECT_EQ(sum, mesh->origin.m - snapped.eye_body);
      const geo::Vec3 eyeAgain = snapped.eye_body + geo::Vec3(snapped.remainder);
      EXPECT_LE(geo::length(eyeAgain - eye.m), 1e-10 + 4e-16 * far);
    }
  }
}

TEST(TerrainPass, TileWithoutRoomForItsTextureShowsTheMiddleOfItsSmallestLevel) {
  scene::DrawnTile tile;
  tile.mesh = std::make_shared<scene::TerrainMesh>();
  auto image = std::make_shared<scene::TextureImage>();
  image->mips.emplace_back(2, 2, raster::Rgba8{1, 2, 3, 255});
  image->mips.emplace_back(1, 1, raster::Rgba8{255, 0, 188, 255});
  const scene::DrawnPicture picture{.image = image, .window = {}, .layer = 0};
  const TileRecord record = recordOf({.tile = &tile, .colours = {.one = {.picture = &picture}}}, {}, geo::Vec3f(0.5f));
  EXPECT_EQ(record.colourLayer, -1);
  EXPECT_FLOAT_EQ(record.plain.x, 1.0f);
  EXPECT_FLOAT_EQ(record.plain.y, 0.0f);
  EXPECT_NEAR(record.plain.z, 0.5028865, 1e-4);  // ((188 / 255 + 0.055) / 1.055)^2.4
  EXPECT_FLOAT_EQ(record.plain.w, 0.0f);
}

}  // namespace
}  // namespace tellurion::render
