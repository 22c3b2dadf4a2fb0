#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

#include "io/failure.h"

// OpenGL objects as move-only values: one object, one owner, deleted with it. They may be made, used and destroyed only
// while their context is current, on the thread where it is. Inside this room only; OpenGL itself is in no header.
namespace tellurion::render {

/// An object's name and the duty to delete it. A default one holds nothing.
template <class Kind>
class GlObject {
 public:
  GlObject() = default;
  explicit GlObject(unsigned int name) : name_(name) {}
  ~GlObject() { release(); }
  GlObject(GlObject&& o) noexcept : name_(std::exchange(o.name_, 0u)) {}
  GlObject& operator=(GlObject&& o) noexcept {
    if (this != &o) {
      release();
      name_ = std::exchange(o.name_, 0u);
    }
    return *this;
  }
  GlObject(const GlObject&) = delete;
  GlObject& operator=(const GlObject&) = delete;

  unsigned int name() const { return name_; }
  explicit operator bool() const { return name_ != 0; }

 private:
  void release() {
    if (name_ != 0) Kind::destroy(name_);
  }
  unsigned int name_ = 0;
};

struct BufferKind {
  static void destroy(unsigned int name);
};
struct TextureKind {
  static void destroy(unsigned int name);
};
struct VertexArrayKind {
  static void destroy(unsigned int name);
};
struct FramebufferKind {
  static void destroy(unsigned int name);
};
struct ProgramKind {
  static void destroy(unsigned int name);
};
struct SamplerKind {
  static void destroy(unsigned int name);
};

using Buffer = GlObject<BufferKind>;
using Texture = GlObject<TextureKind>;
using VertexArray = GlObject<VertexArrayKind>;
using Framebuffer = GlObject<FramebufferKind>;
using Program = GlObject<ProgramKind>;
using Sampler = GlObject<SamplerKind>;

/// A buffer of fixed size whose content is written with glNamedBufferSubData. Empty when memory does not suffice.
Buffer makeBuffer(std::uint64_t bytes);

/// What a texel is: 8 bits a channel, linear or sRGB, or sRGB in blocks (raster/block_compression.h).
enum class TexelFormat : std::uint8_t { linear, srgb, bc1, bc3 };

/// The fields of a 2D array texture. mips >= 1.
struct TextureArrayShape {
  int width = 0;
  int height = 0;
  int mips = 1;
  TexelFormat format = TexelFormat::linear;

  std::uint64_t bytesALayer() const;
  friend bool operator==(const TextureArrayShape&, const TextureArrayShape&) = default;
};
/// Clamped to its edges, trilinear, and anisotropic where a GPU is. Empty when memory does not suffice.
Texture makeTextureArray(const TextureArrayShape& shape, int layers);

/// Copies the first `layers`, with all mip levels, between arrays of this shape.
void copyLayers(const Texture& from, const Texture& to, const TextureArrayShape& shape, int layers);

/// The same with more bytes behind those that it has. Empty, and the old one as it was, when memory does not suffice.
Buffer grownBuffer(const Buffer& old, std::uint64_t oldBytes, std::uint64_t bytes);

/// Whether the GPU reads bc1 and bc3: every GPU of desktop computers does, but OpenGL does not ask for it.
bool readsBlocks();

/// Whether the CPU draws.
bool isSoftwareRenderer();

/// Whether OpenGL ran out of memory since the last call; other errors are our own mistakes and assert.
bool ranOutOfMemory();

}  // namespace tellurion::render
