#pragma once

#include <cstdint>
#include <memory>

#include "io/failure.h"
#include "render/render_target.h"
#include "scene/frame.h"
#include "scene/residency.h"

namespace tellurion::render {

struct RendererOptions {
  /// Bytes of GPU memory for meshes and textures. Three eighths go to meshes, nine sixteenths to colour, a sixteenth to
  /// relief. Textures stay within their share: a tile that finds no room is drawn in its mean colour. Meshes exceed
  /// theirs rather than leave a hole.
  std::uint64_t gpuBudgetBytes = 512u << 20u;
  /// The pictures of the frames are compressed (scene::GlobeOptions::compressTextures): nothing else about them need be
  /// said, but shaders are compiled for it before the first frame. Fails where not readsCompressedPictures().
  bool compressedPictures = false;
  bool asOnAnyGpu = false;  ///< no shader made for software renderers, even on one: for tests
};

struct RenderStatistics {
  int tilesDrawn = 0;
  std::int64_t triangles = 0;
  int drawCalls = 0;
  int tilesWithoutRoom = 0;       ///< drawn without their texture, or not at all, since memory did not suffice
  int uploads = 0;                ///< meshes and textures copied to the GPU for this frame
  std::uint64_t uploadBytes = 0;  ///< and their bytes
  std::uint64_t gpuBytes = 0;     ///< held for meshes and textures, used or not
  double upload_ms = 0.0;         ///< time of the calling thread
  double submit_ms = 0.0;         ///< the rest of draw(), likewise
};

/// Draws frames. Keeps on the GPU what the last frames used and copies only what is new; in a steady state draw()
/// allocates nothing. Move-only; GL thread only: the context that was current in create() is current in every call and
/// at the end.
///
/// A mesh is told apart by its serial, a texture likewise. All terrain goes out in one indirect multi-draw for each
/// combination of program and blocks of memory in use: 1 to 4 in most views, more where chunks of meshes or blocks of
/// pictures are many (docs/rendering.md). Ranges of a mesh that follow each other
/// in its index array are one indirect command: interior, then fine edges in order, then coarse edges in order costs
/// one command for a tile without coarser neighbours.
class Renderer {
 public:
  /// Compiles the shaders. A failure names what the driver lacks, compressed textures too where they are asked for.
  static io::Result<Renderer> create(const RendererOptions& options = {});
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  /// Clears the target with the frame's background and draws its tiles, the air around them and what stands behind
  /// that. The target's size should be the view's viewport; when it is not, the picture is stretched. Sets all the
  /// OpenGL state that it needs and leaves it so.
  RenderStatistics draw(const scene::Frame& frame, const RenderTarget& target);

  /// What is on the GPU, for scene::Globe::update: a Globe that is given it spreads copies over frames. Lives as long
  /// as the renderer, wherever that moves.
  const scene::Residency& residency() const;

  /// Compiles the shaders of the debug views, once. Until then draw() does not look at Frame::debug.
  io::Result<void> prepareDebugViews();

  /// Compiles the shaders of what stands behind the air, once. Until then draw() does not look at Frame::sky.
  io::Result<void> prepareSky();

  /// Compiles the shaders of the air, once. Until then draw() does not look at Frame::air.
  io::Result<void> prepareAir();

 private:
  struct Parts;
  explicit Renderer(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

/// Whether compressed pictures can be drawn in the context that is current. All GPUs of desktop computers and Mesa's
/// software renderers can; without, they are drawn in their mean colours.
bool readsCompressedPictures();

/// Waits until the GPU has done all that was asked of it: for timings.
void finish();

}  // namespace tellurion::render
