#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "scene/picture_projection.h"

namespace tellurion::render {

/// A rectangle of a face of the cube around the eye, to be drawn as a perspective picture. Texels are told in the
/// face's own, so that all windows of a face share them; it may reach beyond the face by some, which filters read.
struct FaceWindow {
  std::size_t face = 0;  ///< of scene::kCubeFaces
  int side = 0;          ///< texels of the whole face
  scene::PixelRect texels;
};

/// Texels along a face's side: in the middle of a face, where they are largest, a texel is no larger than a pixel
/// (scene::pixelAngle).
int faceSideOf(const scene::Warp& warp);

/// What a piece of the picture shows of which faces: those that it needs, and no more of them than that and some texels
/// around it.
std::vector<FaceWindow> windowsOf(const scene::Warp& warp, const scene::PixelRect& piece);

/// The picture that fills the window.
scene::View viewOf(const FaceWindow& window, const scene::EyePicture& eye);

/// The texel (column, row) of the window that the middle of a pixel of the whole picture falls in; nothing where it
/// lies on another face, or is not part of a fisheye's circle. In single precision, as the GPU has it.
std::optional<scene::PixelRect> texelUnder(const scene::Warp& warp, const FaceWindow& window, int col, int row);

}  // namespace tellurion::render
