#include "render/texture_pool.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cassert>

#include "raster/colour.h"
#include "scene/texture_image.h"

namespace tellurion::render {
namespace {

namespace shading {
#include "render/shaders/constants.glsl"
}  // namespace shading

// 23 of 256-pixel tiles with their mips. Most scenes outgrow it once; its successor, for 70, does for a whole globe.
constexpr std::uint64_t kFirstBlockBytes = 8u << 20u;
constexpr std::uint64_t kGrowth = 3;
constexpr std::uint64_t kNextBlockBytes = 24u << 20u;  // times the number of blocks there are and one
constexpr std::uint64_t kMostFirstLayers = 1024;       // of small pictures
constexpr std::size_t kBlocksOfCoverage = 4;           // of the compressed ones

int largestArray() {
  GLint layers = 0;
  glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &layers);
  return std::max(1, layers);
}

TexelFormat formatOf(const scene::TextureImage& image, PoolKind kind) {
  if (image.blocks.empty()) return kind == PoolKind::relief ? TexelFormat::linear : TexelFormat::srgb;
  return image.blocks.front().format == raster::BlockFormat::bc1 ? TexelFormat::bc1 : TexelFormat::bc3;
}

TextureArrayShape shapeOf(const scene::TextureImage& image, PoolKind kind) {
  const auto shape = [&](const auto& levels) -> TextureArrayShape {
    return {.width = levels.front().width,
            .height = levels.front().height,
            .mips = static_cast<int>(levels.size()),
            .format = formatOf(image, kind)};
  };
  return image.blocks.empty() ? shape(image.mips) : shape(image.blocks);
}

/// Each level is half the one before, and the last may be a pixel.
template <class Levels>
bool isChain(const Levels& levels) {
  if (levels.empty() || levels.front().width < 1 || levels.front().height < 1) return false;
  const auto& top = levels.front();
  for (std::size_t i = 0; i < levels.size(); ++i) {
    if (levels[i].width != std::max(1, top.width >> i) || levels[i].height != std::max(1, top.height >> i))
      return false;
    if (i > 0 && levels[i - 1].width == 1 && levels[i - 1].height == 1) return false;
  }
  return true;
}

bool isWellFormed(const scene::TextureImage& image) {
  if (image.blocks.empty()) return isChain(image.mips);
  return image.mips.empty() && isChain(image.blocks) && std::ranges::all_of(image.blocks, [&](const auto& level) {
           return level.format == image.blocks.front().format &&
                  level.bytes.size() == raster::blockBytes(level.format, level.width, level.height);
         });
}

void copyLayer(const Texture& texture, std::uint32_t layer, const scene::TextureImage& image) {
  const auto z = static_cast<GLint>(layer);
  for (std::size_t i = 0; i < image.mips.size(); ++i) {
    const auto& mip = image.mips[i];
    glTextureSubImage3D(texture.name(), static_cast<GLint>(i), 0, 0, z, mip.width, mip.height, 1, GL_RGBA,
                        GL_UNSIGNED_BYTE, mip.samples.data());
  }
  for (std::size_t i = 0; i < image.blocks.size(); ++i) {
    const auto& level = image.blocks[i];
    const GLenum format = level.format == raster::BlockFormat::bc1 ? GL_COMPRESSED_SRGB_S3TC_DXT1_EXT
                                                                   : GL_COMPRESSED_SRGB_ALPHA_S3TC_DXT5_EXT;
    glCompressedTextureSubImage3D(texture.name(), static_cast<GLint>(i), 0, 0, z, level.width, level.height, 1, format,
                                  static_cast<GLsizei>(level.bytes.size()), level.bytes.data());
  }
}

Texture makePlaceholder(TexelFormat format) {
  return makeTextureArray({.width = 3, .height = 3, .mips = format == TexelFormat::linear ? 1 : 2, .format = format},
                          1);
}

bool isBlockFormat(TexelFormat format) {
  return format == TexelFormat::bc1 || format == TexelFormat::bc3;
}

}  // namespace

std::uint64_t bytesOf(const scene::TextureImage& image) {
  return scene::pixelBytes(image);
}

geo::Vec4f meanLight(const scene::TextureImage& image) {
  const raster::Rgba8 mean = scene::meanOf(image);
  const auto light = [](std::uint8_t srgb) { return static_cast<float>(raster::linearFromSrgb(srgb)) / 65535.0f; };
  return {light(mean.r), light(mean.g), light(mean.b), static_cast<float>(mean.a) / 255.0f};
}

std::int32_t TexturePlace::number() const {
  return static_cast<std::int32_t>(layer) + shading::kPlacesABlock * static_cast<std::int32_t>(block);
}

TexturePool::TexturePool(std::uint64_t budgetBytes, PoolKind kind)
    : budget_(budgetBytes),
      kind_(kind),
      mostLayers_(static_cast<std::uint64_t>(largestArray())),
      blocks_(kind == PoolKind::relief ? shading::kMostReliefBlocks : shading::kMostBlocks) {
  switch (kind) {
    case PoolKind::relief:
      placeholder_ = makePlaceholder(TexelFormat::linear);
      break;
    case PoolKind::colour:
      placeholder_ = makePlaceholder(TexelFormat::srgb);
      break;
    case PoolKind::compressedColour:
      placeholder_ = makePlaceholder(TexelFormat::bc1);
      coveragePlaceholder_ = makePlaceholder(TexelFormat::bc3);
      break;
  }
}

const TexturePlace* TexturePool::upload(const scene::TextureImage& image, std::uint64_t frame) {
  assert(isWellFormed(image));
  if (!isWellFormed(image)) return nullptr;
  const TextureArrayShape shape = shapeOf(image, kind_);
  if (isBlockFormat(shape.format) && !readsBlocks()) return nullptr;
  Block* block = blockWithRoom(shape, frame);
  if (block == nullptr) return nullptr;
  const std::uint32_t layer = block->freeLayers.back();
  block->freeLayers.pop_back();
  copyLayer(block->texture, layer, image);
  return resident_.insert(image.serial, frame, {static_cast<std::uint32_t>(block - blocks_.data()), layer});
}

unsigned int TexturePool::texture(std::uint32_t block) const {
  if (blocks_[block].texture) return blocks_[block].texture.name();
  const bool isOfCoverage = coveragePlaceholder_ && block >= slotsFor(TexelFormat::bc3).first;
  return isOfCoverage ? coveragePlaceholder_.name() : placeholder_.name();
}

std::uint32_t TexturePool::blockOfCoverage() const {
  return static_cast<std::uint32_t>(slotsFor(TexelFormat::bc3).first);
}

/// Formats have slots of their own, so that a slot's texture is of the same format before and after.
TexturePool::Slots TexturePool::slotsFor(TexelFormat format) const {
  if (kind_ != PoolKind::compressedColour) return {0, blocks_.size()};
  const std::size_t coverage = blocks_.size() - kBlocksOfCoverage;
  return format == TexelFormat::bc3 ? Slots{coverage, blocks_.size()} : Slots{0, coverage};
}

std::size_t TexturePool::freeSlots(TexelFormat format) const {
  const auto [first, end] = slotsFor(format);
  std::size_t count = 0;
  for (std::size_t i = first; i < end; ++i)
    if (!blocks_[i].texture) ++count;
  return count;
}

std::uint64_t TexturePool::countOf(const TextureArrayShape& shape) const {
  return static_cast<std::uint64_t>(
      std::ranges::count_if(blocks_, [&](const Block& block) { return block.texture && block.shape == shape; }));
}

TexturePool::Block* TexturePool::blockWithRoom(const TextureArrayShape& shape, std::uint64_t frame) {
  if (Block* block = freeLayerOf(shape)) return block;
  if (Block* block = grownBlock(shape)) return block;
  if (Block* block = addBlock(shape)) return block;
  while (const auto evicted = resident_.evictOldest(frame)) {
    Block& block = blocks_[evicted->block];
    block.freeLayers.push_back(evicted->layer);
    if (block.shape == shape) return &block;
  }
  return nullptr;
}

TexturePool::Block* TexturePool::freeLayerOf(const TextureArrayShape& shape) {
  const auto found = std::ranges::find_if(
      blocks_, [&](const Block& block) { return block.texture && block.shape == shape && !block.freeLayers.empty(); });
  return found == blocks_.end() ? nullptr : &*found;
}

/// The first block of a shape, made larger; layers stay where they are.
TexturePool::Block* TexturePool::grownBlock(const TextureArrayShape& shape) {
  if (countOf(shape) != 1) return nullptr;
  Block& block = *std::ranges::find_if(blocks_, [&](const Block& b) { return b.texture && b.shape == shape; });
  const std::uint64_t each = shape.bytesALayer();
  const auto before = static_cast<std::uint64_t>(block.layers);
  const std::uint64_t inBudget = budget_ > bytes_ ? before + (budget_ - bytes_) / each : before;
  const std::uint64_t wanted = std::min({kGrowth * kFirstBlockBytes / each, inBudget, mostLayers_});
  if (wanted < 2 * before) return nullptr;
  const int layers = static_cast<int>(wanted);
  Texture grown = makeTextureArray(shape, layers);
  if (!grown) return nullptr;
  copyLayers(block.texture, grown, shape, block.layers);
  bytes_ += (wanted - before) * each;
  block.texture = std::move(grown);
  for (int layer = layers; layer-- > block.layers;)
    block.freeLayers.push_back(static_cast<std::uint32_t>(layer));
  block.layers = layers;
  return &block;
}

int TexturePool::layersForNewBlock(const TextureArrayShape& shape) const {
  const std::uint64_t before = countOf(shape);
  const std::uint64_t each = shape.bytesALayer();
  const std::uint64_t inBudget = budget_ > bytes_ ? (budget_ - bytes_) / each : 0;
  const std::uint64_t next = before == 0 ? std::clamp<std::uint64_t>(kFirstBlockBytes / each, 1, kMostFirstLayers)
                                         : std::max<std::uint64_t>((before + 1) * kNextBlockBytes / each, 1);
  // Half of the blocks that are left must do for the whole budget: others may be of other shapes.
  const std::uint64_t needed = before == 0 ? 1 : 2 * inBudget / freeSlots(shape.format);
  const std::uint64_t wanted = std::min({std::max(next, needed), inBudget, mostLayers_});
  // A shape that has no block at all gets one layer even from an exhausted budget.
  return static_cast<int>(std::max<std::uint64_t>(wanted, before == 0 ? 1 : 0));
}

TexturePool::Block* TexturePool::addBlock(const TextureArrayShape& shape) {
  if (freeSlots(shape.format) == 0) return nullptr;
  const int layers = layersForNewBlock(shape);
  if (layers == 0) return nullptr;
  Texture texture = makeTextureArray(shape, layers);
  if (!texture) return nullptr;
  bytes_ += shape.bytesALayer() * static_cast<std::uint64_t>(layers);
  std::size_t slot = slotsFor(shape.format).first;
  while (blocks_[slot].texture)
    ++slot;
  Block& block = blocks_[slot];
  block = {.shape = shape, .texture = std::move(texture), .layers = layers, .freeLayers = {}};
  for (int layer = layers; layer-- > 0;)
    block.freeLayers.push_back(static_cast<std::uint32_t>(layer));
  return &block;
}

}  // namespace tellurion::render
