#pragma once

#include <memory>

#include "io/failure.h"
#include "scene/frame.h"

namespace tellurion::render {

/// Draws what stands behind the air: stars, and the discs of sun and Moon. GL thread only; allocates nothing while the
/// catalogue and its brightness stay.
class HeavensPass {
 public:
  /// Compiles the shaders.
  static io::Result<HeavensPass> create();
  ~HeavensPass();
  HeavensPass(HeavensPass&&) noexcept;
  HeavensPass& operator=(HeavensPass&&) noexcept;

  /// Adds its light where nothing was drawn before into what is bound, as renderer.cpp sets the state, but for depth,
  /// which it does not write. A GroundPass has bound the frame's block and, for a frame in air, AirPass::setFrame() the
  /// air's; the air's own pass draws the sun's disc then. The number of draw calls.
  int draw(const scene::Frame& frame, bool inAir);

 private:
  struct Parts;
  explicit HeavensPass(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace tellurion::render
