#include "render/debug_legend.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace tellurion::render {
namespace {

using raster::Rgba8;

// In the font's dots.
constexpr int kGlyphWidth = 5;
constexpr int kGlyphHeight = 7;
constexpr int kAdvance = kGlyphWidth + 1;
constexpr int kMargin = 4;
constexpr int kPatchWidth = 14;
constexpr int kRowHeight = kGlyphHeight + 4;

constexpr Rgba8 kGround{24, 24, 24, 255};
constexpr Rgba8 kText{235, 235, 235, 255};

/// Seven rows from the top, the fifth bit on the left.
struct Glyph {
  char letter;
  std::array<std::uint8_t, kGlyphHeight> rows;
};

constexpr std::array kFont{
    Glyph{'0', {0x0E, 0x11, 0x13, 0x15, 0x19, 0x11, 0x0E}}, Glyph{'1', {0x04, 0x0C, 0x04, 0x04, 0x04, 0x04, 0x0E}},
    Glyph{'2', {0x0E, 0x11, 0x01, 0x06, 0x08, 0x10, 0x1F}}, Glyph{'3', {0x1F, 0x02, 0x04, 0x02, 0x01, 0x11, 0x0E}},
    Glyph{'4', {0x02, 0x06, 0x0A, 0x12, 0x1F, 0x02, 0x02}}, Glyph{'5', {0x1F, 0x10, 0x1E, 0x01, 0x01, 0x11, 0x0E}},
    Glyph{'6', {0x06, 0x08, 0x10, 0x1E, 0x11, 0x11, 0x0E}}, Glyph{'7', {0x1F, 0x01, 0x02, 0x04, 0x08, 0x08, 0x08}},
    Glyph{'8', {0x0E, 0x11, 0x11, 0x0E, 0x11, 0x11, 0x0E}}, Glyph{'9', {0x0E, 0x11, 0x11, 0x0F, 0x01, 0x02, 0x0C}},
    Glyph{'.', {0x00, 0x00, 0x00, 0x00, 0x00, 0x0C, 0x0C}}, Glyph{'>', {0x08, 0x04, 0x02, 0x01, 0x02, 0x04, 0x08}},
    Glyph{'-', {0x00, 0x00, 0x00, 0x1F, 0x00, 0x00, 0x00}}, Glyph{'+', {0x00, 0x04, 0x04, 0x1F, 0x04, 0x04, 0x00}},
    Glyph{'e', {0x00, 0x00, 0x0E, 0x11, 0x1F, 0x10, 0x0E}}, Glyph{'l', {0x0C, 0x04, 0x04, 0x04, 0x04, 0x04, 0x0E}},
    Glyph{'p', {0x00, 0x00, 0x1E, 0x11, 0x1E, 0x10, 0x10}}, Glyph{'v', {0x00, 0x00, 0x11, 0x11, 0x11, 0x0A, 0x04}},
    Glyph{'x', {0x00, 0x00, 0x11, 0x0A, 0x04, 0x0A, 0x11}},
};

/// A picture that is painted in the font's dots.
class Canvas {
 public:
  Canvas(int width, int height, int pixel) : pixel_(pixel), picture_(width * pixel, height * pixel, kGround) {}

  void fill(int x, int y, int width, int height, Rgba8 colour) {
    for (int row = y * pixel_; row < (y + height) * pixel_; ++row) {
      for (int col = x * pixel_; col < (x + width) * pixel_; ++col)
        picture_.at(col, row) = colour;
    }
  }
  void write(int x, int y, std::string_view text) {
    for (std::size_t i = 0; i < text.size(); ++i)
      draw(x + kAdvance * static_cast<int>(i), y, text[i]);
  }
  raster::Raster<Rgba8> take() { return std::move(picture_); }

 private:
  void draw(int x, int y, char letter) {
    const auto* const glyph =
        std::find_if(kFont.begin(), kFont.end(), [letter](const Glyph& g) { return g.letter == letter; });
    if (glyph == kFont.end()) return;
    for (int row = 0; row < kGlyphHeight; ++row) {
      for (int col = 0; col < kGlyphWidth; ++col) {
        const bool set = (glyph->rows[static_cast<std::size_t>(row)] >> (kGlyphWidth - 1 - col) & 1) != 0;
        if (set) fill(x + col, y + row, 1, 1, kText);
      }
    }
  }

  int pixel_;
  raster::Raster<Rgba8> picture_;
};

}  // namespace

LegendContent legendContentOf(const scene::Frame& frame) {
  LegendContent content;
  for (const scene::DebugView view : {scene::DebugView::levels, scene::DebugView::boxes, scene::DebugView::error})
    if (frame.debug.views.has(view)) content.views.add(view);
  for (const scene::DrawnTile& tile : frame.tiles)
    content.levels |= 1u << tile.id.level;
  content.tolerance_px = frame.debug.tolerance_px;
  return content;
}

std::vector<LegendRow> legendRows(const LegendContent& content) {
  std::vector<LegendRow> rows;
  if (content.views.has(scene::DebugView::error)) {
    const auto add = [&](double share, const char* before) {
      const double error_px = share * content.tolerance_px;
      rows.push_back(
          {scene::errorColour(error_px, content.tolerance_px), fmt::format("{}{:.3g} px", before, error_px)});
    };
    for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0})
      add(share, "");
    rows.push_back({scene::errorColour(1.25, 1.0), fmt::format(">{:.3g} px", content.tolerance_px)});
    add(2.0, ">");
  }
  const bool byLevel = content.views.has(scene::DebugView::levels) || content.views.has(scene::DebugView::boxes);
  for (int level = 0; byLevel && level < 32; ++level) {
    if ((content.levels >> level & 1u) != 0)
      rows.push_back({scene::levelColour(level), fmt::format("level {}", level)});
  }
  return rows;
}

raster::Raster<Rgba8> legendPicture(std::span<const LegendRow> rows, int pixel) {
  if (rows.empty()) return {};
  std::size_t letters = 0;
  for (const LegendRow& row : rows)
    letters = std::max(letters, row.label.size());
  const int width = 3 * kMargin + kPatchWidth + kAdvance * static_cast<int>(letters);
  Canvas canvas(width, 2 * kMargin + kRowHeight * static_cast<int>(rows.size()), pixel);
  int y = kMargin;
  for (const LegendRow& row : rows) {
    canvas.fill(kMargin, y, kPatchWidth, kRowHeight - 1, row.colour);
    canvas.write(2 * kMargin + kPatchWidth, y + 2, row.label);
    y += kRowHeight;
  }
  return canvas.take();
}

}  // namespace tellurion::render
