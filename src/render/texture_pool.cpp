#include "render/texture_pool.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cassert>

#include "raster/colour.h"

namespace tellurion::render {
namespace {

namespace shading {
#include "render/shaders/constants.glsl"
}  // namespace shading

// 22 of 256-pixel tiles with their mips; the next blocks of a shape have three times that and more: few of them, few
// draw calls.
constexpr std::uint64_t kFirstBlockBytes = 8u << 20u;
constexpr std::uint64_t kMostLayers = 1024;  // of small pictures

constexpr std::size_t kMostBlocks = shading::kMostBlocks;

int largestArray() {
  GLint layers = 0;
  glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &layers);
  return std::max(1, layers);
}

TextureArrayShape shapeOf(const scene::TextureImage& image, bool srgb) {
  const auto& top = image.mips.front();
  return {.width = top.width, .height = top.height, .mips = static_cast<int>(image.mips.size()), .srgb = srgb};
}

bool isWellFormed(const scene::TextureImage& image) {
  if (image.mips.empty() || image.mips.front().width < 1 || image.mips.front().height < 1) return false;
  const auto& top = image.mips.front();
  for (std::size_t level = 0; level < image.mips.size(); ++level) {
    const auto& mip = image.mips[level];
    if (mip.width != std::max(1, top.width >> level) || mip.height != std::max(1, top.height >> level)) return false;
    if (level > 0 && image.mips[level - 1].width == 1 && image.mips[level - 1].height == 1) return false;
  }
  return true;
}

void copyLayer(GLuint texture, std::uint32_t layer, const scene::TextureImage& image) {
  for (std::size_t level = 0; level < image.mips.size(); ++level) {
    const auto& mip = image.mips[level];
    glTextureSubImage3D(texture, static_cast<GLint>(level), 0, 0, static_cast<GLint>(layer), mip.width, mip.height, 1,
                        GL_RGBA, GL_UNSIGNED_BYTE, mip.samples.data());
  }
}

}  // namespace

std::uint64_t bytesOf(const scene::TextureImage& image) {
  std::uint64_t bytes = 0;
  for (const auto& mip : image.mips)
    bytes += mip.samples.size() * sizeof(raster::Rgba8);
  return bytes;
}

geo::Vec4f meanLight(const scene::TextureImage& image) {
  const auto& last = image.mips.back();
  const raster::Rgba8 pixel = last.at(last.width / 2, last.height / 2);
  const auto light = [](std::uint8_t srgb) { return static_cast<float>(raster::linearFromSrgb(srgb)) / 65535.0f; };
  return {light(pixel.r), light(pixel.g), light(pixel.b), static_cast<float>(pixel.a) / 255.0f};
}

TexturePool::TexturePool(std::uint64_t budgetBytes, bool srgb)
    : budget_(budgetBytes), srgb_(srgb), mostLayers_(largestArray()) {}

const TexturePlace* TexturePool::upload(const scene::TextureImage& image, std::uint64_t frame) {
  assert(isWellFormed(image));
  if (!isWellFormed(image)) return nullptr;
  Block* block = blockWithRoom(shapeOf(image, srgb_), frame);
  if (block == nullptr) return nullptr;
  const std::uint32_t layer = block->freeLayers.back();
  block->freeLayers.pop_back();
  copyLayer(block->texture.name(), layer, image);
  return resident_.insert(image.serial, frame, {static_cast<std::uint32_t>(block - blocks_.data()), layer});
}

TexturePool::Block* TexturePool::blockWithRoom(const TextureArrayShape& shape, std::uint64_t frame) {
  if (Block* block = freeLayerOf(shape)) return block;
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
      blocks_, [&](const Block& block) { return block.shape == shape && !block.freeLayers.empty(); });
  return found == blocks_.end() ? nullptr : &*found;
}

int TexturePool::layersForNewBlock(const TextureArrayShape& shape) const {
  const auto before = std::ranges::count_if(blocks_, [&](const Block& block) { return block.shape == shape; });
  const std::uint64_t each = shape.bytesALayer();
  const std::uint64_t inBudget = budget_ > bytes_ ? (budget_ - bytes_) / each : 0;
  const std::uint64_t next = (before == 0 ? 1 : 3 * static_cast<std::uint64_t>(before)) * kFirstBlockBytes / each;
  // Half of the blocks that are left must do for the whole budget: others may be of other shapes.
  const std::uint64_t needed = before == 0 ? 1 : 2 * inBudget / (kMostBlocks - blocks_.size());
  const std::uint64_t wanted = std::min({std::max(std::clamp<std::uint64_t>(next, 1, kMostLayers), needed), inBudget,
                                         static_cast<std::uint64_t>(mostLayers_)});
  // A shape that has no block at all gets one layer even from an exhausted budget.
  return static_cast<int>(std::max<std::uint64_t>(wanted, before == 0 ? 1 : 0));
}

TexturePool::Block* TexturePool::addBlock(const TextureArrayShape& shape) {
  if (blocks_.size() == kMostBlocks) return nullptr;
  const int layers = layersForNewBlock(shape);
  if (layers == 0) return nullptr;
  Texture texture = makeTextureArray(shape, layers);
  if (!texture) return nullptr;
  bytes_ += shape.bytesALayer() * static_cast<std::uint64_t>(layers);
  Block block{.shape = shape, .texture = std::move(texture), .layers = layers, .freeLayers = {}};
  for (int layer = layers; layer-- > 0;)
    block.freeLayers.push_back(static_cast<std::uint32_t>(layer));
  blocks_.push_back(std::move(block));
  return &blocks_.back();
}

}  // namespace tellurion::render
