#pragma once

#include "render/face_windows.h"
#include "render/render_target.h"

namespace tellurion::render {

/// Bends faces of a cube around the eye into a picture, filtered in linear light. Move-only; GL thread only.
class WarpPass {
 public:
  static io::Result<WarpPass> create();

  /// Draws the pixels of the piece that lie on the face, which was drawn as viewOf(window) says; leaves the others as
  /// they are. `piece`: the target's rectangle of the whole picture.
  void draw(const scene::Warp& warp, const FaceWindow& window, const RenderTarget& face, const scene::PixelRect& piece,
            const RenderTarget& target) const;

 private:
  WarpPass() = default;
  Program program_;
  VertexArray nothing_;
};

}  // namespace tellurion::render
