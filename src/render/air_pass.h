#pragma once

#include <memory>
#include <optional>

#include "io/failure.h"
#include "render/gl_objects.h"
#include "scene/frame.h"

namespace tellurion::render {

/// Keeps what shaders read of a frame's air, and draws the sky. The tables of an atmosphere are made when it changes
/// (about 0.2 s), what the eye sees of it for each frame. GL thread only; allocates nothing while the atmosphere stays.
class AirPass {
 public:
  /// Compiles the shaders. Fails where a program may read too few textures for ground in air (19).
  static io::Result<AirPass> create();
  ~AirPass();
  AirPass(AirPass&&) noexcept;
  AirPass& operator=(AirPass&&) noexcept;

  /// Binds, and draws with, what has been compiled: drivers finish that when something is drawn, and no frame shall
  /// wait.
  void warmUp();
  /// Makes the frame's air ready, and binds it for all that is drawn after it until the next call.
  void setFrame(const scene::Frame& frame);
  /// Draws the sky where nothing was drawn before into what is bound, as renderer.cpp sets the state, but for depth,
  /// which it does not write. setFrame() was called, and a GroundPass has bound the frame's block. The number of draw
  /// calls.
  int drawSky(const scene::Frame& frame) const;

 private:
  struct Parts;
  explicit AirPass(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace tellurion::render
