#include "render/picture_maker.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tellurion::render {
namespace {

template <class T>
void place(const raster::Raster<T>& from, int left, int top, raster::Raster<T>& into) {
  for (int row = 0; row < from.height; ++row)
    std::copy_n(from.samples.begin() + std::ptrdiff_t{row} * from.width, from.width,
                into.samples.begin() + std::ptrdiff_t{top + row} * into.width + left);
}

}  // namespace

void add(const RenderStatistics& drawn, RenderStatistics& sum) {
  sum.tilesDrawn += drawn.tilesDrawn;
  sum.triangles += drawn.triangles;
  sum.drawCalls += drawn.drawCalls;
  sum.tilesWithoutRoom += drawn.tilesWithoutRoom;
  sum.uploads += drawn.uploads;
  sum.uploadBytes += drawn.uploadBytes;
  sum.gpuBytes = std::max(sum.gpuBytes, drawn.gpuBytes);
  sum.upload_ms += drawn.upload_ms;
  sum.submit_ms += drawn.submit_ms;
}

io::Result<PictureMaker> PictureMaker::create() {
  auto warp = WarpPass::create();
  if (!warp) return tl::unexpected(warp.error());
  return PictureMaker(std::move(*warp));
}

io::Result<const RenderTarget*> PictureMaker::targetOf(scene::Viewport size) {
  if (!target_ || target_->size().width != size.width || target_->size().height != size.height) {
    target_.reset();
    auto target = RenderTarget::create(size);
    if (!target) return tl::unexpected(target.error());
    target_ = std::move(*target);
  }
  return &*target_;
}

PicturePiece blankPiece(const scene::PixelRect& place, bool withDistances) {
  PicturePiece piece{.place = place,
                     .colours = raster::Raster<raster::Rgba8>(place.width, place.height),
                     .distances_m = {},
                     .drawn = {}};
  std::ranges::fill(piece.colours.samples, raster::Rgba8{0, 0, 0, 255});
  if (withDistances) {
    piece.distances_m = raster::Raster<float>(place.width, place.height);
    std::ranges::fill(piece.distances_m.samples, std::numeric_limits<float>::quiet_NaN());
  }
  return piece;
}

io::Result<void> PictureMaker::draw(Renderer& renderer, const scene::Frame& frame, const scene::EyePicture& eye,
                                    const scene::PixelRect& part, PicturePiece& piece) {
  return eye.panes.empty() ? drawWarp(renderer, frame, eye, part, piece) : drawPanes(renderer, frame, eye, part, piece);
}

io::Result<void> PictureMaker::drawPanes(Renderer& renderer, const scene::Frame& frame, const scene::EyePicture& eye,
                                         const scene::PixelRect& part, PicturePiece& piece) {
  for (const scene::Pane& pane : eye.panes) {
    const scene::PixelRect common = scene::overlapOf(pane.place, part);
    if (common.width == 0 || common.height == 0) continue;
    const auto target = targetOf({.width = common.width, .height = common.height});
    if (!target) return tl::unexpected(target.error());
    const scene::PixelRect inPane{common.left - pane.place.left, common.top - pane.place.top, common.width,
                                  common.height};
    const scene::View view = common == pane.place ? pane.view : scene::partOf(pane.view, inPane);
    add(renderer.draw(scene::partOf(frame, view), **target), piece.drawn);
    const int left = common.left - piece.place.left;
    const int top = common.top - piece.place.top;
    place(readColour(**target), left, top, piece.colours);
    if (!piece.distances_m.samples.empty()) place(readDistance(**target, view), left, top, piece.distances_m);
  }
  return {};
}

io::Result<void> PictureMaker::drawWarp(Renderer& renderer, const scene::Frame& frame, const scene::EyePicture& eye,
                                        const scene::PixelRect& part, PicturePiece& piece) {
  const auto bent = RenderTarget::create({.width = part.width, .height = part.height});
  if (!bent) return tl::unexpected(bent.error());
  const std::array<GLfloat, 4> black{0.0f, 0.0f, 0.0f, 1.0f};
  glDisable(GL_SCISSOR_TEST);
  glClearNamedFramebufferfv(bent->framebuffer(), GL_COLOR, 0, black.data());
  const int left = part.left - piece.place.left;
  const int top = part.top - piece.place.top;
  for (const FaceWindow& window : windowsOf(eye.warp, part)) {
    const auto face = targetOf({.width = window.texels.width, .height = window.texels.height});
    if (!face) return tl::unexpected(face.error());
    const scene::View view = viewOf(window, eye);
    add(renderer.draw(scene::partOf(frame, view), **face), piece.drawn);
    warp_.draw(eye.warp, window, **face, part, *bent);
    if (piece.distances_m.samples.empty()) continue;
    const raster::Raster<float> distances = readDistance(**face, view);
    for (int row = 0; row < part.height; ++row) {
      for (int col = 0; col < part.width; ++col) {
        if (const auto texel = texelUnder(eye.warp, window, part.left + col, part.top + row))
          piece.distances_m.at(left + col, top + row) = distances.at(std::clamp(texel->left, 0, distances.width - 1),
                                                                     std::clamp(texel->top, 0, distances.height - 1));
      }
    }
  }
  place(readColour(*bent), left, top, piece.colours);
  return {};
}

std::vector<scene::PixelRect> piecesOf(scene::Viewport picture, int side) {
  constexpr std::int64_t kRowBytes = std::int64_t{64} << 20;
  const auto fits = static_cast<int>(std::max<std::int64_t>(kRowBytes / (4 * std::int64_t{picture.width}), 1));
  const int high = std::min(side, fits);
  std::vector<scene::PixelRect> pieces;
  for (int top = 0; top < picture.height; top += high) {
    for (int left = 0; left < picture.width; left += side)
      pieces.push_back({left, top, std::min(side, picture.width - left), std::min(high, picture.height - top)});
  }
  return pieces;
}

}  // namespace tellurion::render
