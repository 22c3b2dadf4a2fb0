#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/debug_legend.h"
#include "render/gl_objects.h"
#include "render/render_target.h"
#include "render/terrain_pass.h"

namespace tellurion::render {

/// What the terrain's own pass has left on the GPU for this frame: the debug views draw the same triangles again.
struct DrawnTerrain {
  const GeometryArena* geometry = nullptr;  ///< not null
  unsigned int recordBinding = 0;           ///< of its vertex array; holds recordBuffer, and does so again afterwards
  unsigned int recordBuffer = 0;
  unsigned int commandBuffer = 0;
  unsigned int frameBlock = 0;
  std::span<const CommandRun> runs;  ///< all of the commands, a run a chunk
  std::span<const ResidentTile> tiles;
  std::span<const TileRecord> records;  ///< of the tiles
};

/// Draws what Frame::debug asks for over a picture: wireframe and tints in one draw call for each chunk of meshes,
/// lines in one, and the legend in none. Depth stays as it is. Move-only; GL thread only.
class DebugPass {
 public:
  /// Compiles its shaders.
  static io::Result<DebugPass> create();

  /// The target holds the frame's picture. Returns the number of draw calls. In a steady state nothing is allocated.
  int draw(const scene::Frame& frame, const DrawnTerrain& terrain, const RenderTarget& target);

 private:
  struct LineEnd {
    geo::Vec3f position_rte;
    std::uint32_t colour = 0;  ///< linear light and strength, 8 bits each
  };

  DebugPass(Program tiles, Program lines);
  int drawTiles(const DrawnTerrain& terrain);
  void fillTints(const scene::Frame& frame, const DrawnTerrain& terrain);
  void fillWires(const DrawnTerrain& terrain, bool overTints);
  void collectLines(const scene::Frame& frame);
  int drawLines();
  void drawLegend(const scene::Frame& frame, const RenderTarget& target);
  void renewLegend(const LegendContent& content, int pixel);

  Program tileProgram_;
  Program lineProgram_;
  Buffer recordBuffer_;
  Buffer lineBuffer_;
  VertexArray lineArray_;
  // The legend of the last frame that had one.
  LegendContent legendContent_;
  int legendPixel_ = 0;
  scene::Viewport legendSize_{0, 0};
  Texture legendTexture_;
  Framebuffer legendFramebuffer_;
  // Kept from frame to frame only for their memory:
  std::vector<TileRecord> records_;
  std::vector<LineEnd> lineEnds_;
};

}  // namespace tellurion::render
