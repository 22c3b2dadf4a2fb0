#include "render/gl_objects.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cassert>
#include <string_view>

namespace tellurion::render {
namespace {

constexpr float kAnisotropy = 8.0f;

/// Anisotropic filtering costs a software renderer 25 times a trilinear fetch (docs/rendering.md).
bool useAnisotropy() {
  static const bool use = epoxy_has_gl_extension("GL_EXT_texture_filter_anisotropic") && !isSoftwareRenderer();
  return use;
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

std::uint64_t TextureArrayShape::bytesALayer() const {
  std::uint64_t pixels = 0;
  for (int level = 0; level < mips; ++level) {
    const int w = std::max(1, width >> level);
    const int h = std::max(1, height >> level);
    pixels += static_cast<std::uint64_t>(w) * static_cast<std::uint64_t>(h);
  }
  return pixels * 4;
}

Texture makeTextureArray(const TextureArrayShape& shape, int layers) {
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &name);
  Texture texture(name);
  glTextureStorage3D(name, shape.mips, shape.srgb ? GL_SRGB8_ALPHA8 : GL_RGBA8, shape.width, shape.height, layers);
  if (ranOutOfMemory()) return {};
  glTextureParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(name, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, shape.mips > 1 ? GL_LINEAR_MIPMAP_LINEAR : GL_LINEAR);
  if (useAnisotropy() && shape.mips > 1) glTextureParameterf(name, GL_TEXTURE_MAX_ANISOTROPY_EXT, kAnisotropy);
  return texture;
}

}  // namespace tellurion::render
