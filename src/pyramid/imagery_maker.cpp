#include <algorithm>

#include "pyramid/tile_maker.h"
#include "raster/codec.h"
#include "raster/reduce.h"
#include "raster/tile_places.h"

namespace tellurion::pyramid {
namespace {

using raster::kGutter;
using raster::Raster;
using raster::Rgba8;

constexpr int kJpegQuality = 90;
constexpr int kLossless = 100;

struct Canvas {
  Raster<Rgba8> pixels;
  std::vector<bool> known;
  int size;

  explicit Canvas(int tileSize)
      : pixels(tileSize + 2 * kGutter, tileSize + 2 * kGutter), known(pixels.samples.size(), false), size(tileSize) {}
  /// (column, row) without gutter: -1 .. size.
  void set(int column, int row, Rgba8 colour) {
    pixels.at(column + kGutter, row + kGutter) = colour;
    known[static_cast<std::size_t>((row + kGutter) * pixels.width + column + kGutter)] = true;
  }
};

struct Window {
  int column = 0;  ///< gutter included
  int row = 0;
  int width = 0;
  int height = 0;
};

/// Part of a tile, each line twice where the window is one wide, so that halving averages along the other axis alone.
Raster<Rgba8> cut(const Raster<Rgba8>& tile, const Window& window) {
  Raster<Rgba8> part(std::max(window.width, 2), std::max(window.height, 2));
  for (int row = 0; row < part.height; ++row) {
    for (int column = 0; column < part.width; ++column) {
      part.at(column, row) =
          tile.at(window.column + std::min(column, window.width - 1), window.row + std::min(row, window.height - 1));
    }
  }
  return part;
}

/// A window of a child, halved, put at (column, row) of the canvas.
void put(Canvas& canvas, const Raster<Rgba8>& child, const Window& window, int column, int row) {
  const Raster<Rgba8> half = raster::halved(cut(child, window));
  for (int r = 0; r < half.height; ++r) {
    for (int c = 0; c < half.width; ++c)
      canvas.set(column + c, row + r, half.at(c, r));
  }
}

/// The child's pixels halved, and its outer gutter for this tile's: two pixels along the edge to one.
void takeChild(Canvas& canvas, int quadrant, const Raster<Rgba8>& child) {
  const int size = canvas.size;
  const bool isRight = (quadrant & 1) != 0;
  const bool isBottom = (quadrant >> 1) != 0;
  const int column = isRight ? size / 2 : 0;
  const int row = isBottom ? size / 2 : 0;
  const int outerColumn = isRight ? size + kGutter : 0;
  const int outerRow = isBottom ? size + kGutter : 0;
  put(canvas, child, {kGutter, kGutter, size, size}, column, row);
  put(canvas, child, {outerColumn, kGutter, 1, size}, isRight ? size : -1, row);
  put(canvas, child, {kGutter, outerRow, size, 1}, column, isBottom ? size : -1);
}

/// The corners of the gutter: no promise, so the nearest pixel, which compresses well and filters well.
void fillCorners(Raster<Rgba8>& pixels) {
  const int last = pixels.width - 1;
  for (const int row : {0, last}) {
    for (const int column : {0, last}) {
      pixels.at(column, row) = pixels.at(std::clamp(column, 1, last - 1), std::clamp(row, 1, last - 1));
    }
  }
}

/// No coverage in the tile itself; the gutter is its neighbours'.
bool isEmpty(const Raster<Rgba8>& pixels) {
  for (int row = kGutter; row < pixels.height - kGutter; ++row) {
    const auto inside = pixels.row(row).subspan(kGutter, static_cast<std::size_t>(pixels.width - 2 * kGutter));
    if (std::ranges::any_of(inside, [](Rgba8 p) { return p.a != 0; })) return false;
  }
  return true;
}

io::Result<std::shared_ptr<const Raster<Rgba8>>> pixelsOf(const KnownTile& tile, int tileCells) {
  if (tile.pixels) return tile.pixels;
  const int side = sideOf(raster::Kind::imagery, tileCells);
  auto pixels = raster::decodeImage(tile.record.payload, side, side);
  if (pixels) return std::make_shared<const Raster<Rgba8>>(std::move(*pixels));
  pixels.error().where += " " + nameOf(tile.record.id);
  return tl::unexpected(pixels.error());
}

raster::ImageFormat formatOf(const Raster<Rgba8>& pixels, TileFormat wanted) {
  switch (wanted) {
    case TileFormat::png:
      return raster::ImageFormat::png;
    case TileFormat::webp:
      return raster::ImageFormat::webp;
    case TileFormat::jpeg:
      break;
  }
  const bool isCovered = std::ranges::all_of(pixels.samples, [](Rgba8 p) { return p.a == 255; });
  return isCovered ? raster::ImageFormat::jpeg : raster::ImageFormat::webp;
}

io::Result<std::vector<std::byte>> payloadOf(const Raster<Rgba8>& pixels, TileFormat wanted) {
  const raster::ImageFormat format = formatOf(pixels, wanted);
  return raster::encodeImage(pixels, format, format == raster::ImageFormat::jpeg ? kJpegQuality : kLossless);
}

}  // namespace

io::Result<void> TileMaker::sampleOpenColours(const TileTask& task, const std::vector<bool>& known,
                                              Raster<Rgba8>& pixels) {
  const auto open = openSamples(plan_.tiling(), task.id, raster::Kind::imagery, plan_.meta.tileCells, known);
  if (open.empty()) return {};
  std::vector<Rgba8> colours(open.size());
  if (base_ != nullptr) {
    const auto below = base_->colours(task.id);
    if (!below) return tl::unexpected(below.error());
    std::ranges::transform(open, colours.begin(), [&](std::size_t i) { return below->samples[i]; });
  }
  if (auto ok = inputs_.colours(task.inputs, task.id, open, colours); !ok) return ok;
  for (std::size_t i = 0; i < colours.size(); ++i)
    pixels.samples[open[i]] = colours[i];
  return {};
}

TileMaker::Made TileMaker::makeImagery(const TileTask& task) {
  Canvas canvas(plan_.meta.tileCells);
  TileRecord record{.id = task.id, .statistics = {}, .childMask = 0, .children = {}, .payload = {}};
  for (std::size_t q = 0; q < 4; ++q) {
    if (!task.children[q]) continue;
    const auto child = pixelsOf(*task.children[q], canvas.size);
    if (!child) return tl::unexpected(child.error());
    takeChild(canvas, static_cast<int>(q), **child);
    record.childMask = static_cast<std::uint8_t>(record.childMask | (1u << q));
  }
  for (const int row : {-1, canvas.size}) {
    for (const int column : {-1, canvas.size})
      canvas.set(column, row, {});  // filled from beside it below
  }
  if (auto ok = sampleOpenColours(task, canvas.known, canvas.pixels); !ok) return tl::unexpected(ok.error());
  fillCorners(canvas.pixels);
  if (record.childMask == 0 && isEmpty(canvas.pixels)) return std::optional<KnownTile>{};
  auto payload = payloadOf(canvas.pixels, plan_.format);
  if (!payload) return tl::unexpected(payload.error());
  record.payload = std::move(*payload);
  return std::optional(KnownTile{.record = std::move(record),
                                 .heights = nullptr,
                                 .pixels = std::make_shared<const Raster<Rgba8>>(std::move(canvas.pixels))});
}

}  // namespace tellurion::pyramid
