#pragma once

#include <cstdint>
#include <optional>

#include "io/failure.h"
#include "raster/raster.h"
#include "render/gl_objects.h"
#include "scene/picking.h"

namespace tellurion::render {

/// Metres from the eye to the near plane. Fixed: with reverse z and floats the precision of depth does not depend on
/// it.
inline constexpr float kNearPlane_m = 0.01f;

/// A picture being drawn: sRGB colour (8 bits a channel) and 32-bit float depth, both in textures. Move-only; GL thread
/// only. A window draws into one too and shows it with copyToWindow(), since a window's own depth has neither floats
/// nor reverse z.
class RenderTarget {
 public:
  /// The largest width and height that the current context can draw.
  static scene::Viewport largest();
  /// Sizes outside 1..largest(), or more than memory holds, are failures.
  static io::Result<RenderTarget> create(scene::Viewport size);

  scene::Viewport size() const { return size_; }
  std::uint64_t bytes() const;
  unsigned int framebuffer() const { return framebuffer_.name(); }
  unsigned int colour() const { return colour_.name(); }  ///< the texture

 private:
  RenderTarget() = default;
  scene::Viewport size_;
  Texture colour_;
  Texture depth_;
  Framebuffer framebuffer_;
};

/// The colours, sRGB, opaque; row 0 is the top.
raster::Raster<raster::Rgba8> readColour(const RenderTarget& target);

/// Metres from the eye to the surface along each pixel's ray, through its centre; NaN for sky. `view` is what was
/// drawn. The relative error of the transformation and of depth together is about 3e-7; where the ground is seen at a
/// grazing angle an error of 1e-4 pixels comes to it. Row 0 is the top.
raster::Raster<float> readDistance(const RenderTarget& target, const scene::View& view);

/// The distance at one place of the picture, as readDistance() gives for the pixel it falls in; nothing for sky and
/// outside.
std::optional<double> readDistanceAt(const RenderTarget& target, const scene::View& view, scene::PixelPosition pixel);

/// Shows the picture in the current context's window, whose framebuffer has this size in pixels. Colours go over as
/// they are (sRGB): the window's own framebuffer must not be an sRGB one. Leaves the window's framebuffer bound.
void copyToWindow(const RenderTarget& target, scene::Viewport window);

}  // namespace tellurion::render
