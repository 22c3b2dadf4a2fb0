#include "render/render_target.h"

#include <epoxy/gl.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace tellurion::render {
namespace {

constexpr std::uint64_t kBytesAPixel = 4 + 4;

Texture makeAttachment(GLenum format, scene::Viewport size) {
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &name);
  Texture texture(name);
  glTextureStorage2D(name, 1, format, size.width, size.height);
  return texture;
}

/// Metres along the ray through a pixel's centre for its depth; NaN where nothing was drawn.
class DistanceFromDepth {
 public:
  explicit DistanceFromDepth(const scene::View& view) : sides_(view.sides()), size_(view.viewport) {}

  /// row counts from the top.
  double operator()(int col, int row, float depth) const {
    if (!(depth > 0.0f)) return std::numeric_limits<double>::quiet_NaN();
    const double x = sides_.middleX() + ((col + 0.5) / size_.width - 0.5) * sides_.width();
    const double y = sides_.middleY() + (0.5 - (row + 0.5) / size_.height) * sides_.height();
    return static_cast<double>(kNearPlane_m) / static_cast<double>(depth) * std::sqrt(1.0 + x * x + y * y);
  }

 private:
  scene::Sides sides_;
  scene::Viewport size_;
};

/// OpenGL counts rows from the bottom.
template <class T>
void flipRows(raster::Raster<T>& image) {
  const auto width = static_cast<std::ptrdiff_t>(image.width);
  for (int top = 0, bottom = image.height - 1; top < bottom; ++top, --bottom) {
    const auto a = image.samples.begin() + top * width;
    std::swap_ranges(a, a + width, image.samples.begin() + bottom * width);
  }
}

}  // namespace

scene::Viewport RenderTarget::largest() {
  GLint texture = 0;
  std::array<GLint, 2> viewport{};
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &texture);
  glGetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport.data());
  return {std::min(texture, viewport[0]), std::min(texture, viewport[1])};
}

io::Result<RenderTarget> RenderTarget::create(scene::Viewport size) {
  const auto text = fmt::format("{}x{}", size.width, size.height);
  const scene::Viewport most = largest();
  if (size.width < 1 || size.height < 1 || size.width > most.width || size.height > most.height) {
    return io::fail(io::Failure::Code::invalidArgument,
                    fmt::format("a picture must be from 1x1 to {}x{} pixels here", most.width, most.height), text);
  }
  RenderTarget target;
  target.size_ = size;
  target.colour_ = makeAttachment(GL_SRGB8_ALPHA8, size);
  target.depth_ = makeAttachment(GL_DEPTH_COMPONENT32F, size);
  GLuint name = 0;
  glCreateFramebuffers(1, &name);
  target.framebuffer_ = Framebuffer(name);
  glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, target.colour_.name(), 0);
  glNamedFramebufferTexture(name, GL_DEPTH_ATTACHMENT, target.depth_.name(), 0);
  const bool complete = glCheckNamedFramebufferStatus(name, GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
  if (ranOutOfMemory() || !complete) {
    return io::fail(io::Failure::Code::ioError,
                    fmt::format("the graphics driver has no memory for this picture ({} MiB); ask for a smaller one",
                                target.bytes() >> 20u),
                    text);
  }
  return target;
}

std::uint64_t RenderTarget::bytes() const {
  return static_cast<std::uint64_t>(size_.width) * static_cast<std::uint64_t>(size_.height) * kBytesAPixel;
}

raster::Raster<raster::Rgba8> readColour(const RenderTarget& target) {
  const scene::Viewport size = target.size();
  raster::Raster<raster::Rgba8> image(size.width, size.height);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, target.framebuffer());
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glReadPixels(0, 0, size.width, size.height, GL_RGBA, GL_UNSIGNED_BYTE, image.samples.data());
  flipRows(image);
  for (raster::Rgba8& pixel : image.samples)
    pixel.a = 255;
  return image;
}

raster::Raster<float> readDistance(const RenderTarget& target, const scene::View& view) {
  const scene::Viewport size = target.size();
  raster::Raster<float> distances(size.width, size.height);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, target.framebuffer());
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glReadPixels(0, 0, size.width, size.height, GL_DEPTH_COMPONENT, GL_FLOAT, distances.samples.data());
  flipRows(distances);
  const DistanceFromDepth distance(view);
  for (int row = 0; row < size.height; ++row) {
    for (int col = 0; col < size.width; ++col) {
      float& value = distances.at(col, row);
      value = static_cast<float>(distance(col, row, value));
    }
  }
  return distances;
}

std::optional<double> readDistanceAt(const RenderTarget& target, const scene::View& view, scene::PixelPosition pixel) {
  const scene::Viewport size = target.size();
  const double col = std::floor(pixel.x);
  const double row = std::floor(pixel.y);
  if (!(col >= 0.0 && col < size.width && row >= 0.0 && row < size.height)) return std::nullopt;
  float depth = 0.0f;
  glBindFramebuffer(GL_READ_FRAMEBUFFER, target.framebuffer());
  glReadPixels(static_cast<GLint>(col), size.height - 1 - static_cast<GLint>(row), 1, 1, GL_DEPTH_COMPONENT, GL_FLOAT,
               &depth);
  if (!(depth > 0.0f)) return std::nullopt;
  return DistanceFromDepth(view)(static_cast<int>(col), static_cast<int>(row), depth);
}

void copyToWindow(const RenderTarget& target, scene::Viewport window) {
  const scene::Viewport size = target.size();
  glDisable(GL_FRAMEBUFFER_SRGB);
  glDisable(GL_SCISSOR_TEST);
  const bool same = size.width == window.width && size.height == window.height;
  glBlitNamedFramebuffer(target.framebuffer(), 0, 0, 0, size.width, size.height, 0, 0, window.width, window.height,
                         GL_COLOR_BUFFER_BIT, same ? GL_NEAREST : GL_LINEAR);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glViewport(0, 0, window.width, window.height);
}

}  // namespace tellurion::render
