#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "render/renderer.h"
#include "render/warp_pass.h"

namespace tellurion::render {

/// To what was drawn for other parts of a picture: counts summed, and the most that was held.
void add(const RenderStatistics& drawn, RenderStatistics& sum);

/// A rectangle of a picture, row 0 the top.
struct PicturePiece {
  scene::PixelRect place;
  raster::Raster<raster::Rgba8> colours;
  raster::Raster<float> distances_m;  ///< along each pixel's ray, NaN for sky; empty where not asked for
  RenderStatistics drawn;             ///< of all that was drawn for it, summed; the most that was held
};

/// Black, and sky.
PicturePiece blankPiece(const scene::PixelRect& place, bool withDistances);

/// Draws pictures of any projection and size out of frames, a piece at a time. Move-only; GL thread only.
class PictureMaker {
 public:
  /// Compiles its shader.
  static io::Result<PictureMaker> create();

  /// Draws what the eye sees of a part of the piece into it, and leaves the rest as it is (another eye's half of a
  /// stereo pair). `part`: within piece.place. `frame`: made for eye.cut. Memory: some 60 bytes a pixel of the part at
  /// most for a warp, 16 else. Fails where the graphics driver cannot draw a picture of that size.
  io::Result<void> draw(Renderer& renderer, const scene::Frame& frame, const scene::EyePicture& eye,
                        const scene::PixelRect& part, PicturePiece& piece);

 private:
  explicit PictureMaker(WarpPass warp) : warp_(std::move(warp)) {}
  io::Result<void> drawPanes(Renderer& renderer, const scene::Frame& frame, const scene::EyePicture& eye,
                             const scene::PixelRect& part, PicturePiece& piece);
  io::Result<void> drawWarp(Renderer& renderer, const scene::Frame& frame, const scene::EyePicture& eye,
                            const scene::PixelRect& part, PicturePiece& piece);
  /// Of this size; the last one where that fits.
  io::Result<const RenderTarget*> targetOf(scene::Viewport size);

  WarpPass warp_;
  std::optional<RenderTarget> target_;
};

/// Pieces that cover a picture, row by row from its top, each row of pieces as wide as the picture; none larger than
/// `side`, none so high that a row of them takes more than 64 MiB.
std::vector<scene::PixelRect> piecesOf(scene::Viewport picture, int side);

}  // namespace tellurion::render
