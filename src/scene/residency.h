#pragma once

#include <cstdint>

#include "scene/frame.h"

namespace tellurion::scene {

/// What is on the GPU, as far as a Globe must know it to spread copies over frames. Asked on the thread that updates
/// the Globe, between draws.
class Residency {
 public:
  struct MissingBytes {
    std::uint64_t mesh = 0;
    std::uint64_t colour = 0;
    std::uint64_t relief = 0;
  };

  virtual ~Residency() = default;
  /// What drawing these would copy. Pictures may be null. 0 too for what found no room in the last frame: it is drawn
  /// without.
  virtual MissingBytes missing(const TerrainMesh& mesh, const TextureImage* colour,
                               const TextureImage* relief) const = 0;
  /// Another number once something that was not missing may be.
  virtual std::uint64_t departures() const = 0;
};

}  // namespace tellurion::scene
