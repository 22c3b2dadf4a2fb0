#pragma once

#include <cstdint>

#include "scene/frame.h"

namespace tellurion::scene {

/// What is on the GPU, as far as a Globe must know it to spread copies over frames. Asked on the thread that updates
/// the Globe, between draws.
class Residency {
 public:
  virtual ~Residency() = default;
  // Bytes that drawing these would copy. 0 too for a picture that found no room in the last frame: it is drawn without.
  virtual std::uint64_t missingBytes(const TerrainMesh& mesh) const = 0;
  virtual std::uint64_t missingColourBytes(const TextureImage& image) const = 0;
  virtual std::uint64_t missingReliefBytes(const TextureImage& image) const = 0;
  /// Another number once something that was not missing may be.
  virtual std::uint64_t departures() const = 0;
  /// Another number once something that was missing may not be any more.
  virtual std::uint64_t arrivals() const = 0;
};

}  // namespace tellurion::scene
