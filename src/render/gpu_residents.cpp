#include "render/gpu_residents.h"

#include <algorithm>
#include <limits>

namespace tellurion::render {
namespace {

constexpr std::uint64_t kSixteenth = 16;
constexpr std::uint64_t kMeshShare = 6;
constexpr std::uint64_t kColourShare = 9;
constexpr std::uint64_t kReliefShare = 1;

std::span<const scene::DrawnPicture> picturesOf(const scene::Frame& frame, const scene::DrawnTile& tile) {
  return {frame.pictures.data() + tile.firstPicture, tile.pictureCount};
}

const MeshPlace* copied(GeometryArena& arena, const scene::TerrainMesh& mesh, std::uint64_t frame, bool mayExceed) {
  return arena.upload(mesh, frame, mayExceed);
}
const TexturePlace* copied(TexturePool& pool, const scene::TextureImage& image, std::uint64_t frame, bool /*never*/) {
  return pool.upload(image, frame);
}

}  // namespace

GpuResidents::GpuResidents(std::uint64_t budgetBytes, bool compressedColours)
    : geometry_(budgetBytes / kSixteenth * kMeshShare),
      colours_(budgetBytes / kSixteenth * kColourShare,
               compressedColours ? PoolKind::compressedColour : PoolKind::colour),
      reliefs_(budgetBytes / kSixteenth * kReliefShare, PoolKind::relief) {}

std::uint64_t GpuResidents::missingBytes(const scene::TerrainMesh& mesh) const {
  return geometry_.resident().holds(mesh.serial) ? 0 : bytesOf(mesh);
}
std::uint64_t GpuResidents::missingColourBytes(const scene::TextureImage& image) const {
  return missingBytes(colours_, image);
}
std::uint64_t GpuResidents::missingReliefBytes(const scene::TextureImage& image) const {
  return missingBytes(reliefs_, image);
}
std::uint64_t GpuResidents::missingBytes(const TexturePool& pool, const scene::TextureImage& image) const {
  const bool fine = pool.resident().holds(image.serial) || std::ranges::binary_search(refused_, image.serial);
  return fine ? 0 : bytesOf(image);
}

std::uint64_t GpuResidents::departures() const {
  return 1 + geometry_.resident().evictions() + colours_.resident().evictions() + reliefs_.resident().evictions() +
         framesWithRefused_;
}

/// The place of a payload, copied if it is not here and the allowance suffices; else null.
template <class Pool, class Payload>
auto GpuResidents::brought(Pool& pool, const Payload& payload, Allowance& allowance) -> decltype(pool.touch(0, 0)) {
  if (const auto* place = pool.touch(payload.serial, frameNumber_)) return place;
  const std::uint64_t bytes = bytesOf(payload);
  if (bytes > allowance.bytes) return nullptr;
  const auto* place = copied(pool, payload, frameNumber_, allowance.mayExceedBudget);
  if (place == nullptr) return nullptr;
  allowance.bytes -= bytes;
  ++counts_.copies;
  ++arrivals_;
  counts_.bytes += bytes;
  return place;
}

template <class Pool, class Payload, class Place>
void GpuResidents::bringNeeded(Pool& pool, const Payload& payload, Place& place) {
  if (place != nullptr || payload == nullptr) return;
  Allowance all{.bytes = std::numeric_limits<std::uint64_t>::max(), .mayExceedBudget = true};
  place = brought(pool, *payload, all);
  if (place != nullptr) return;
  ++counts_.withoutRoom;
  ++arrivals_;
  refused_.push_back(payload->serial);
}

CopyCounts GpuResidents::bring(const scene::Frame& frame) {
  ++frameNumber_;
  counts_ = {};
  if (!refused_.empty()) ++framesWithRefused_;
  refused_.clear();
  findTiles(frame);
  bringTiles(frame);
  bringSoon(frame);
  std::ranges::sort(refused_);
  return counts_;
}

/// What is here already is touched before anything is copied, so that no copy drives out what this frame needs.
void GpuResidents::findTiles(const scene::Frame& frame) {
  tiles_.clear();
  pictures_.clear();
  for (const scene::DrawnPicture& picture : frame.pictures)
    pictures_.push_back({.picture = &picture});
  for (const scene::DrawnTile& tile : frame.tiles) {
    if (tile.mesh == nullptr) continue;
    tiles_.push_back({.tile = &tile,
                      .mesh = geometry_.touch(tile.mesh->serial, frameNumber_),
                      .relief = tile.relief ? reliefs_.touch(tile.relief->serial, frameNumber_) : nullptr});
    for (std::size_t i = tile.firstPicture; i < tile.firstPicture + tile.pictureCount; ++i) {
      const scene::DrawnPicture& picture = frame.pictures[i];
      if (frame.looks[picture.layer].visible) pictures_[i].place = colours_.touch(picture.image->serial, frameNumber_);
    }
  }
}

void GpuResidents::bringTiles(const scene::Frame& frame) {
  for (ResidentTile& resident : tiles_) {
    const scene::DrawnTile& tile = *resident.tile;
    bringNeeded(geometry_, tile.mesh, resident.mesh);
    bringNeeded(reliefs_, tile.relief, resident.relief);
    for (std::size_t i = tile.firstPicture; i < tile.firstPicture + tile.pictureCount; ++i) {
      const scene::DrawnPicture& picture = frame.pictures[i];
      if (frame.looks[picture.layer].visible) bringNeeded(colours_, picture.image, pictures_[i].place);
    }
  }
  std::erase_if(tiles_, [](const ResidentTile& tile) { return tile.mesh == nullptr; });
}

/// Only what there is room and time for: it is not missed yet.
void GpuResidents::bringSoon(const scene::Frame& frame) {
  Allowance left{.bytes = frame.soonCopies_bytes, .mayExceedBudget = false};
  const auto bringPictures = [&](const scene::DrawnTile& tile, bool visible) {
    for (const scene::DrawnPicture& picture : picturesOf(frame, tile)) {
      if (frame.looks[picture.layer].visible == visible) brought(colours_, *picture.image, left);
    }
  };
  for (const scene::DrawnTile& tile : frame.soon) {
    if (tile.mesh != nullptr) brought(geometry_, *tile.mesh, left);
    if (tile.relief != nullptr) brought(reliefs_, *tile.relief, left);
    bringPictures(tile, true);
  }
  // Layers that are not visible now may be in the next frame.
  for (const scene::DrawnTile& tile : frame.tiles)
    bringPictures(tile, false);
}

}  // namespace tellurion::render
