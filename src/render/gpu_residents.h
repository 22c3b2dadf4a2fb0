#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/geometry_arena.h"
#include "render/layer_records.h"
#include "render/terrain_pass.h"
#include "render/texture_pool.h"
#include "scene/frame.h"
#include "scene/residency.h"

namespace tellurion::render {

/// What was copied for a frame, and what could not be.
struct CopyCounts {
  int copies = 0;
  std::uint64_t bytes = 0;
  int withoutRoom = 0;  ///< meshes and pictures
};

/// Keeps on the GPU what frames draw: meshes, colours and reliefs. What is used longest ago leaves when a budget is
/// reached. GL thread only; allocates nothing once frames repeat.
class GpuResidents final : public scene::Residency {
 public:
  GpuResidents(std::uint64_t budgetBytes, bool compressedColours);

  std::uint64_t missingBytes(const scene::TerrainMesh& mesh) const override;
  std::uint64_t missingColourBytes(const scene::TextureImage& image) const override;
  std::uint64_t missingReliefBytes(const scene::TextureImage& image) const override;
  std::uint64_t departures() const override;
  std::uint64_t arrivals() const override { return arrivals_; }

  /// Copies what the frame draws and is not here yet, and of what it draws soon as much as it allows.
  CopyCounts bring(const scene::Frame& frame);
  /// Of the last frame: the tiles whose meshes are here.
  std::span<ResidentTile> tiles() { return tiles_; }
  std::span<const ResidentTile> tiles() const { return tiles_; }
  /// Frame::pictures, and where they lie.
  std::span<const ResidentPicture> pictures() const { return pictures_; }

  GeometryArena& geometry() { return geometry_; }
  const GeometryArena& geometry() const { return geometry_; }
  const TexturePool& colours() const { return colours_; }
  const TexturePool& reliefs() const { return reliefs_; }
  std::uint64_t bytes() const { return geometry_.bytes() + colours_.bytes() + reliefs_.bytes(); }

 private:
  /// What may still be copied, and whether more room may be taken for it than the budget has.
  struct Allowance {
    std::uint64_t bytes = 0;
    bool mayExceedBudget = false;
  };
  template <class Pool, class Payload>
  auto brought(Pool& pool, const Payload& payload, Allowance& allowance) -> decltype(pool.touch(0, 0));
  template <class Pool, class Payload, class Place>
  void bringNeeded(Pool& pool, const Payload& payload, Place& place);
  void findTiles(const scene::Frame& frame);
  void bringTiles(const scene::Frame& frame);
  void bringSoon(const scene::Frame& frame);
  std::uint64_t missingBytes(const TexturePool& pool, const scene::TextureImage& image) const;

  GeometryArena geometry_;
  TexturePool colours_;
  TexturePool reliefs_;
  std::uint64_t frameNumber_ = 0;
  CopyCounts counts_;
  // Serials of the last frame's meshes and pictures without room, in order. They count as there for one frame.
  std::vector<std::uint64_t> refused_;
  std::uint64_t framesWithRefused_ = 0;
  std::uint64_t arrivals_ = 0;  ///< copies and refusals so far
  std::vector<ResidentTile> tiles_;
  std::vector<ResidentPicture> pictures_;
};

}  // namespace tellurion::render
