#pragma once

#include <cstdint>
#include <vector>

#include "render/gl_objects.h"
#include "render/resident_set.h"
#include "scene/frame.h"

namespace tellurion::render {

/// What a copy of a picture takes, mip levels included.
std::uint64_t bytesOf(const scene::TextureImage& image);

/// Linear light, multiplied with coverage, and coverage, 0..1, of all of it together: what is drawn of a picture that
/// found no room.
geo::Vec4f meanLight(const scene::TextureImage& image);

/// Where a picture lies: a layer of a block.
struct TexturePlace {
  std::uint32_t block = 0;
  std::uint32_t layer = 0;

  /// As shaders know it that read all blocks: layer + kPlacesABlock * block.
  std::int32_t number() const;
};

/// What a pool is for. Pictures of other formats than it expects get in too, but drivers may compile shaders again for
/// them.
enum class PoolKind : std::uint8_t { relief, colour, compressedColour };

/// Pictures on the GPU as layers of 2D array textures. A block is one array of one shape. The first of a shape is small
/// and grows once, into one that is enough for most scenes; each further one is larger than the one before, so that few
/// of them (and few draw calls) hold many pictures, and none is made before it is needed. At the budget the pictures
/// used longest ago leave. Never over the budget, but for one layer of each shape. There are kMostBlocks of them,
/// of reliefs kMostReliefBlocks (shaders/constants.glsl), so a draw call can read them all: the last ones are as large
/// as they must be, and pictures of a shape that comes too late find no room. All reliefs of a scene are of one shape.
/// GL thread only.
class TexturePool {
 public:
  TexturePool(std::uint64_t budgetBytes, PoolKind kind);

  const TexturePlace* touch(std::uint64_t serial, std::uint64_t frame) { return resident_.touch(serial, frame); }
  /// Copies a picture that is not here yet. Null when all there is room for is in use in this very frame, or the GPU
  /// does not read its format. The picture may be dropped after.
  const TexturePlace* upload(const scene::TextureImage& image, std::uint64_t frame);

  /// An array for each block that there may be: of the format that it will have, where there is none yet. Changes with
  /// upload().
  unsigned int texture(std::uint32_t block) const;
  /// A block for pictures with coverage, where those have their own.
  std::uint32_t blockOfCoverage() const;
  std::uint64_t bytes() const { return bytes_; }
  const ResidentSet<TexturePlace>& resident() const { return resident_; }

 private:
  struct Block {
    TextureArrayShape shape;
    Texture texture;  // none yet: the slot is free
    int layers = 0;
    std::vector<std::uint32_t> freeLayers;
  };
  struct Slots {
    std::size_t first = 0;
    std::size_t end = 0;
  };
  Slots slotsFor(TexelFormat format) const;
  std::size_t freeSlots(TexelFormat format) const;
  std::uint64_t countOf(const TextureArrayShape& shape) const;
  Block* blockWithRoom(const TextureArrayShape& shape, std::uint64_t frame);
  Block* freeLayerOf(const TextureArrayShape& shape);
  Block* grownBlock(const TextureArrayShape& shape);
  Block* addBlock(const TextureArrayShape& shape);
  int layersForNewBlock(const TextureArrayShape& shape) const;

  std::uint64_t budget_;
  PoolKind kind_;
  std::uint64_t mostLayers_;
  std::uint64_t bytes_ = 0;
  // Bound where no block is yet: of its kind, or a driver may compile its shaders again once there is one.
  Texture placeholder_;
  Texture coveragePlaceholder_;
  std::vector<Block> blocks_;  // all slots that there are
  ResidentSet<TexturePlace> resident_;
};

}  // namespace tellurion::render
