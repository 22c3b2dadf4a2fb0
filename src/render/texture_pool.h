#pragma once

#include <cstdint>
#include <vector>

#include "render/gl_objects.h"
#include "render/resident_set.h"
#include "scene/frame.h"

namespace tellurion::render {

/// What a copy of a picture takes, mip levels included.
std::uint64_t bytesOf(const scene::TextureImage& image);

/// Linear light, multiplied with coverage, and coverage, 0..1, of the middle of its smallest level: what is drawn of a
/// picture that found no room.
geo::Vec4f meanLight(const scene::TextureImage& image);

/// Where a picture lies: a layer of a block.
struct TexturePlace {
  std::uint32_t block = 0;
  std::uint32_t layer = 0;
};

/// Pictures on the GPU as layers of 2D array textures. A block is one array of one shape; each is
/// larger than the one before, so that few of them (and few draw calls) hold many pictures, and none is made before it
/// is needed. At the budget the
/// pictures used longest ago leave. Never over the budget, but for one layer of each shape. There are at most
/// kMostBlocks of them (shaders/constants.glsl), so a draw call can read them all: the last ones are as large as they
/// must be, and pictures of a shape that comes too late find no room. GL thread only.
class TexturePool {
 public:
  TexturePool(std::uint64_t budgetBytes, bool srgb);

  const TexturePlace* touch(std::uint64_t serial, std::uint64_t frame) { return resident_.touch(serial, frame); }
  /// Copies a picture that is not here yet. Null when all there is room for is in use in this very frame. The picture
  /// may be dropped after.
  const TexturePlace* upload(const scene::TextureImage& image, std::uint64_t frame);

  unsigned int texture(std::uint32_t block) const { return blocks_[block].texture.name(); }
  std::size_t blockCount() const { return blocks_.size(); }
  std::uint64_t bytes() const { return bytes_; }
  const ResidentSet<TexturePlace>& resident() const { return resident_; }

 private:
  struct Block {
    TextureArrayShape shape;
    Texture texture;
    int layers = 0;
    std::vector<std::uint32_t> freeLayers;
  };
  Block* blockWithRoom(const TextureArrayShape& shape, std::uint64_t frame);
  Block* freeLayerOf(const TextureArrayShape& shape);
  Block* addBlock(const TextureArrayShape& shape);
  int layersForNewBlock(const TextureArrayShape& shape) const;

  std::uint64_t budget_;
  bool srgb_;
  int mostLayers_;
  std::uint64_t bytes_ = 0;
  std::vector<Block> blocks_;
  ResidentSet<TexturePlace> resident_;
};

}  // namespace tellurion::render
