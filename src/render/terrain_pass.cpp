#include "render/terrain_pass.h"

#include <cmath>

#include "raster/colour.h"
#include "tiling/tiling.h"

namespace tellurion::render {
namespace {

constexpr double kGridPerMetre = 1024.0;  // steps of 2^-10 m
constexpr float kGroundGrey = 0.35f;      // linear, where a scene has no imagery at all

double snapped(double metres) {
  return std::round(metres * kGridPerMetre) / kGridPerMetre;
}

float linear(std::uint8_t srgb) {
  return static_cast<float>(raster::linearFromSrgb(srgb)) / 65535.0f;
}

geo::Vec4f packed(const scene::TextureWindow& w) {
  return {w.offset.x, w.offset.y, w.scale.x, w.scale.y};
}

struct TwoFloats {
  geo::Vec3f coarse;
  geo::Vec3f fine;
};

/// volatile: g++ 12 at -O3 takes a vector's way to float and back for no change at all, and the fine parts for zero.
TwoFloats inTwoFloats(const geo::Vec3& v) {
  TwoFloats out;
  for (int i = 0; i < 3; ++i) {
    const volatile float coarse = static_cast<float>(v[i]);
    out.coarse[i] = coarse;
    out.fine[i] = static_cast<float>(v[i] - static_cast<double>(coarse));
  }
  return out;
}

bool isLayered(const TileColours& colours) {
  return colours.kind == TileColours::Kind::layered;
}

/// And how much of the picture is added to it.
geo::Vec4f plainColour(const TileColours& colours, const geo::Vec3f& ground) {
  if (isLayered(colours) || colours.one.picture == nullptr) return geo::Vec4f(ground, 0.0f);
  if (colours.one.place != nullptr) return geo::Vec4f(0.0f, 0.0f, 0.0f, 1.0f);
  return geo::Vec4f(geo::Vec3f(meanLight(*colours.one.picture->image)), 0.0f);
}

geo::Vec4f colourWindow(const TileColours& colours) {
  const bool hasOne = !isLayered(colours) && colours.one.picture != nullptr;
  return hasOne ? packed(colours.one.picture->window) : packed(scene::TextureWindow{});
}

std::int32_t layerOf(const TexturePlace* place) {
  return place == nullptr ? -1 : static_cast<std::int32_t>(place->layer);
}

}  // namespace

SnappedEye snappedEye(const geo::BodyPosition& eye) {
  const geo::Vec3 grid{snapped(eye.m.x), snapped(eye.m.y), snapped(eye.m.z)};
  return {.eye_body = grid, .remainder = geo::Vec3f(eye.m - grid)};
}

void appendCommands(const ResidentTile& tile, std::uint32_t baseInstance, std::vector<DrawCommand>& commands) {
  const scene::TerrainMesh& mesh = *tile.tile->mesh;
  const std::size_t firstOfTile = commands.size();
  const auto append = [&](const scene::IndexRange& range) {
    if (range.count == 0) return;
    const std::uint32_t first = tile.mesh->firstIndex + range.first;
    if (commands.size() > firstOfTile && commands.back().firstIndex + commands.back().count == first) {
      commands.back().count += range.count;
    } else {
      commands.push_back({.count = range.count,
                          .firstIndex = first,
                          .baseVertex = static_cast<std::int32_t>(tile.mesh->firstVertex),
                          .baseInstance = baseInstance});
    }
  };
  append(mesh.interior);
  for (const tiling::Edge edge : tiling::kEdges) {
    const auto e = static_cast<std::size_t>(edge);
    append((tile.tile->coarseEdges >> e & 1) != 0 ? mesh.coarseEdge[e] : mesh.fineEdge[e]);
  }
}

geo::Vec3f bareGround(const scene::Frame& frame) {
  if (frame.looks.empty()) return geo::Vec3f(kGroundGrey);
  return {linear(scene::kPlainGround.r), linear(scene::kPlainGround.g), linear(scene::kPlainGround.b)};
}

TileRecord recordOf(const ResidentTile& tile, const SnappedEye& eye, const geo::Vec3f& ground) {
  const geo::Vec3 origin_rte = tile.tile->mesh->origin.m - eye.eye_body;
  const auto [coarse, fine] = inTwoFloats(origin_rte);
  const TileColours& colours = tile.colours;
  TileRecord record{.originCoarse_rte = coarse,
                    .originFine_rte = fine,
                    .parentStep_m = tile.tile->mesh->parentStep_m,
                    .colourWindow = colourWindow(colours),
                    .reliefWindow = packed(tile.tile->reliefWindow),
                    .plain = plainColour(colours, ground),
                    .morph = {tile.tile->morph[0], tile.tile->morph[1], tile.tile->morph[2], tile.tile->morph[3]},
                    .colourLayer = layerOf(colours.one.place),
                    .reliefLayer = layerOf(tile.relief)};
  switch (colours.kind) {
    case TileColours::Kind::one:
      break;
    case TileColours::Kind::both:
      record.pictureCount = layerOf(colours.third.place) << 16;
      record.thirdWindow = packed(colours.third.picture->window);
      [[fallthrough]];
    case TileColours::Kind::lamps:
    case TileColours::Kind::water:
      record.pictureCount |= layerOf(colours.second.place);
      record.strengths = glm::packHalf2x16({colours.secondStrength, colours.thirdStrength});
      record.secondWindow = packed(colours.second.picture->window);
      break;
    case TileColours::Kind::layered:
      record.colourLayer = static_cast<std::int32_t>(colours.first);
      record.pictureCount = static_cast<std::int32_t>(colours.count);
      if (tile.relief != nullptr) record.reliefLayer = tile.relief->number();
      break;
  }
  return record;
}

}  // namespace tellurion::render
