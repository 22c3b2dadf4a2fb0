#pragma once

#include <cstdint>
#include <vector>

#include "render/geometry_arena.h"
#include "render/gl_objects.h"
#include "render/layer_records.h"
#include "render/texture_pool.h"
#include "scene/frame.h"

namespace tellurion::render {

/// What a tile's vertices read, one record an instance: the attributes 3 to 8 and 13 to 15 of terrain.vert.glsl.
struct TileRecord {
  geo::Vec3f originCoarse_rte;
  geo::Vec3f originFine_rte;
  float parentStep_m = 0.0f;  ///< in one attribute with that
  geo::Vec4f colourWindow;
  geo::Vec4f reliefWindow;
  geo::Vec4f plain;
  geo::Vec4f morph;               ///< scene::DrawnTile::morph
  std::int32_t colourLayer = -1;  ///< of a tile with several pictures: the first of their records
  std::int32_t reliefLayer = -1;  ///< of a tile with several pictures: TexturePlace::number()
  std::int32_t pictureCount = 0;  ///< records of pictures; else the layers of the second and, << 16, of the third
  std::uint32_t strengths = 0;    ///< of those, halves
  geo::Vec4f secondWindow;
  geo::Vec4f thirdWindow;
};
static_assert(sizeof(TileRecord) == 140);

/// As glMultiDrawElementsIndirect reads it.
struct DrawCommand {
  std::uint32_t count = 0;
  std::uint32_t instanceCount = 1;
  std::uint32_t firstIndex = 0;
  std::int32_t baseVertex = 0;
  std::uint32_t baseInstance = 0;
};
static_assert(sizeof(DrawCommand) == 20);

/// Commands that follow each other and whose meshes lie in one chunk of the GeometryArena.
struct CommandRun {
  std::uint32_t chunk = 0;
  std::size_t first = 0;
  std::size_t count = 0;

  /// For glMultiDrawElementsIndirect, with the buffer of the commands bound.
  const void* offset() const { return reinterpret_cast<const void*>(first * sizeof(DrawCommand)); }
};

/// Where a drawn tile's parts lie; a null texture place draws smooth ground.
struct ResidentTile {
  const scene::DrawnTile* tile = nullptr;
  const MeshPlace* mesh = nullptr;
  const TexturePlace* relief = nullptr;
  TileColours colours;
};

/// The eye rounded to the grid of 2^-10 m on which mesh origins lie, so that origin minus eye is exact in two floats
/// (up to 2e11 m; further out the error is 2^-48 of the distance), and what the rounding took away.
struct SnappedEye {
  geo::Vec3 eye_body{0.0};
  geo::Vec3f remainder{0.0f};  ///< metres from the snapped eye to the eye
};
SnappedEye snappedEye(const geo::BodyPosition& eye);

/// The commands that draw a tile: its interior and for each edge the fine or the coarse strip, adjoining ranges joined.
void appendCommands(const ResidentTile& tile, std::uint32_t baseInstance, std::vector<DrawCommand>& commands);

/// ground: linear, where nothing covers it.
TileRecord recordOf(const ResidentTile& tile, const SnappedEye& eye, const geo::Vec3f& ground);

/// Of ground that no picture covers, linear.
geo::Vec3f bareGround(const scene::Frame& frame);

}  // namespace tellurion::render
