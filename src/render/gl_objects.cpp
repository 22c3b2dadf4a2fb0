#include "render/gl_objects.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cassert>
#include <string_view>

#include "raster/block_compression.h"

namespace tellurion::render {
namespace {

constexpr float kAnisotropy = 8.0f;

/// Anisotropic filtering costs a software renderer 25 times a trilinear fetch (docs/rendering.md).
bool useAnisotropy() {
  static const bool use = epoxy_has_gl_extension("GL_EXT_texture_filter_anisotropic") && !isSoftwareRenderer();
  return use;
}

GLenum internalFormat(TexelFormat format) {
  switch (format) {
    case TexelFormat::linear:
      return GL_RGBA8;
    case TexelFormat::srgb:
      return GL_SRGB8_ALPHA8;
    case TexelFormat::bc1:
      return GL_COMPRESSED_SRGB_S3TC_DXT1_EXT;
    case TexelFormat::bc3:
      return GL_COMPRESSED_SRGB_ALPHA_S3TC_DXT5_EXT;
  }
  return GL_NONE;
}

std::uint64_t bytesOfLevel(TexelFormat format, int width, int height) {
  switch (format) {
    case TexelFormat::linear:
    case TexelFormat::srgb:
      return sizeof(raster::Rgba8) * static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
    case TexelFormat::bc1:
      return raster::blockBytes(raster::BlockFormat::bc1, width, height);
    case TexelFormat::bc3:
      return raster::blockBytes(raster::BlockFormat::bc3, width, height);
  }
  return 0;
}

}  // namespace

void BufferKind::destroy(unsigned int name) {
  glDeleteBuffers(1, &name);
}
void TextureKind::destroy(unsigned int name) {
  glDeleteTextures(1, &name);
}
void VertexArrayKind::destroy(unsigned int name) {
  glDeleteVertexArrays(1, &name);
}
void FramebufferKind::destroy(unsigned int name) {
  glDeleteFramebuffers(1, &name);
}
void SamplerKind::destroy(unsigned int name) {
  glDeleteSamplers(1, &name);
}
void ProgramKind::destroy(unsigned int name) {
  glDeleteProgram(name);
}

bool isSoftwareRenderer() {
  const GLubyte* text = glGetString(GL_RENDERER);
  const std::string_view name = text != nullptr ? reinterpret_cast<const char*>(text) : "";
  return name.find("llvmpipe") != name.npos || name.find("softpipe") != name.npos ||
         name.find("SwiftShader") != name.npos;
}

bool ranOutOfMemory() {
  bool out = false;
  for (GLenum error = glGetError(); error != GL_NO_ERROR; error = glGetError()) {
    assert(error == GL_OUT_OF_MEMORY);
    out = out || error == GL_OUT_OF_MEMORY;
  }
  return out;
}

Buffer makeBuffer(std::uint64_t bytes) {
  GLuint name = 0;
  glCreateBuffers(1, &name);
  Buffer buffer(name);
  glNamedBufferStorage(name, static_cast<GLsizeiptr>(bytes), nullptr, GL_DYNAMIC_STORAGE_BIT);
  return ranOutOfMemory() ? Buffer() : std::move(buffer);
}

Buffer grownBuffer(const Buffer& old, std::uint64_t oldBytes, std::uint64_t bytes) {
  Buffer grown = makeBuffer(bytes);
  if (grown) glCopyNamedBufferSubData(old.name(), grown.name(), 0, 0, static_cast<GLsizeiptr>(oldBytes));
  return grown;
}

std::uint64_t TextureArrayShape::bytesALayer() const {
  std::uint64_t bytes = 0;
  for (int level = 0; level < mips; ++level)
    bytes += bytesOfLevel(format, std::max(1, width >> level), std::max(1, height >> level));
  return bytes;
}

Texture makeTextureArray(const TextureArrayShape& shape, int layers) {
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &name);
  Texture texture(name);
  glTextureStorage3D(name, shape.mips, internalFormat(shape.format), shape.width, shape.height, layers);
  if (ranOutOfMemory()) return {};
  glTextureParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(name, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, shape.mips > 1 ? GL_LINEAR_MIPMAP_LINEAR : GL_LINEAR);
  if (useAnisotropy() && shape.mips > 1) glTextureParameterf(name, GL_TEXTURE_MAX_ANISOTROPY_EXT, kAnisotropy);
  return texture;
}

void copyLayers(const Texture& from, const Texture& to, const TextureArrayShape& shape, int layers) {
  for (int level = 0; level < shape.mips; ++level) {
    glCopyImageSubData(from.name(), GL_TEXTURE_2D_ARRAY, level, 0, 0, 0, to.name(), GL_TEXTURE_2D_ARRAY, level, 0, 0, 0,
                       std::max(1, shape.width >> level), std::max(1, shape.height >> level), layers);
  }
}

bool readsBlocks() {
  return epoxy_has_gl_extension("GL_EXT_texture_compression_s3tc") && epoxy_has_gl_extension("GL_EXT_texture_sRGB");
}

}  // namespace tellurion::render
