#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "io/failure.h"
#include "raster/placement.h"

namespace tellurion::raster {

/// A window of one level of a raster: level 0 is the raster itself, the others are its overviews.
struct Window {
  int level = 0;
  int col = 0;
  int row = 0;
  int width = 0;
  int height = 0;
};

/// All pixels of a file, level by level, read in blocks of 256 x 256 of which the latest used are kept.
/// One thread only.
template <class T>
class PixelStore {
 public:
  static constexpr int kBits = 8;
  static constexpr int kSide = 1 << kBits;
  static constexpr std::size_t kFewestBlocks = 4;  ///< those around a corner

  /// Fills a window at the start of a block, whose rows are kSide apart.
  using Read = std::function<io::Result<void>(const Window&, T* block)>;

  PixelStore(std::vector<GridTopology> levels, std::size_t budgetBytes, Read read)
      : levels_(std::move(levels)),
        read_(std::move(read)),
        mostBlocks_(std::max(kFewestBlocks, budgetBytes / (sizeof(T) * kSide * kSide))) {}

  const std::vector<GridTopology>& levels() const { return levels_; }
  /// Set once a read has failed.
  const std::optional<io::Failure>& failure() const { return failure_; }

  /// The pixel, which must be inside. Nullptr: it cannot be read.
  const T* pixel(int level, int col, int row) {
    const T* block = blockAt(level, col >> kBits, row >> kBits);
    return block == nullptr ? nullptr : block + offset(col, row);
  }

  /// The first of some pixels, inclusive and inside, that lie in one block, whose rows are kSide apart. Nullptr: they
  /// do not, or cannot be read.
  const T* pixelsOfOneBlock(int level, int firstCol, int lastCol, int firstRow, int lastRow) {
    if ((firstCol >> kBits) != (lastCol >> kBits) || (firstRow >> kBits) != (lastRow >> kBits)) return nullptr;
    return pixel(level, firstCol, firstRow);
  }

  /// The 2 x 2 pixels from (col, row) on, row by row; beyond the ends as the topology says, else the last pixel again.
  bool quad(int col, int row, std::array<T, 4>& out) {
    const GridTopology& grid = levels_.front();
    const bool inside = col >= 0 && row >= 0 && col + 1 < grid.width && row + 1 < grid.height;
    if (inside && (col & (kSide - 1)) != kSide - 1 && (row & (kSide - 1)) != kSide - 1) {
      const T* first = pixel(0, col, row);
      if (first == nullptr) return false;
      out = {first[0], first[1], first[kSide], first[kSide + 1]};
      return true;
    }
    return edgeQuad(col, row, out);
  }

 private:
  using Pixels = std::unique_ptr<T[]>;
  struct Block {
    std::uint64_t key;
    Pixels pixels;
  };

  static std::size_t offset(int col, int row) {
    return (static_cast<std::size_t>(row & (kSide - 1)) << kBits) + static_cast<std::size_t>(col & (kSide - 1));
  }
  static std::uint64_t keyOf(int level, int x, int y) {
    return (static_cast<std::uint64_t>(level) << 56u) | (static_cast<std::uint64_t>(y) << 28u) |
           static_cast<std::uint64_t>(x);
  }

  bool edgeQuad(int col, int row, std::array<T, 4>& out) {
    const GridTopology& grid = levels_.front();
    for (int i = 0; i < 4; ++i) {
      int c = col + (i & 1);
      int r = row + (i >> 1);
      if (!grid.resolve(c, r)) {
        c = std::clamp(c, 0, grid.width - 1);
        r = std::clamp(r, 0, grid.height - 1);
      }
      const T* found = pixel(0, c, r);
      if (found == nullptr) return false;
      out[static_cast<std::size_t>(i)] = *found;
    }
    return true;
  }

  const T* blockAt(int level, int x, int y) {
    const std::uint64_t key = keyOf(level, x, y);
    if (key == lastKey_) return last_;
    const auto found = index_.find(key);
    if (found != index_.end()) {
      blocks_.splice(blocks_.begin(), blocks_, found->second);
    } else if (!load(key, level, x, y)) {
      return nullptr;
    }
    lastKey_ = key;
    last_ = blocks_.front().pixels.get();
    return last_;
  }

  bool load(std::uint64_t key, int level, int x, int y) {
    const GridTopology& grid = levels_[static_cast<std::size_t>(level)];
    const Window window{level, x << kBits, y << kBits, std::min(kSide, grid.width - (x << kBits)),
                        std::min(kSide, grid.height - (y << kBits))};
    Pixels pixels = roomForOne();
    lastKey_ = kNone;
    if (auto done = read_(window, pixels.get()); !done) {
      failure_ = std::move(done.error());
      return false;
    }
    blocks_.push_front({key, std::move(pixels)});
    index_[key] = blocks_.begin();
    return true;
  }

  /// New memory, or that of the block unused for longest.
  Pixels roomForOne() {
    if (blocks_.size() < mostBlocks_) return Pixels(new T[static_cast<std::size_t>(kSide) * kSide]);
    Pixels pixels = std::move(blocks_.back().pixels);
    index_.erase(blocks_.back().key);
    blocks_.pop_back();
    return pixels;
  }

  static constexpr std::uint64_t kNone = ~std::uint64_t{0};
  std::vector<GridTopology> levels_;
  Read read_;
  std::size_t mostBlocks_;
  std::list<Block> blocks_;  // The latest used is in front.
  std::unordered_map<std::uint64_t, typename std::list<Block>::iterator> index_;
  std::uint64_t lastKey_ = kNone;
  const T* last_ = nullptr;
  std::optional<io::Failure> failure_;
};

/// A rectangle of pixel coordinates of level 0.
struct PixelBox {
  double left, right, top, bottom;
};

/// At least a pixel on each side, so that a mean over a box smaller than a pixel is the bilinear value.
inline PixelBox boxAround(double col, double row, double width, double height) {
  const double halfWidth = 0.5 * std::max(width, 1.0);
  const double halfHeight = 0.5 * std::max(height, 1.0);
  return {col - halfWidth, col + halfWidth, row - halfHeight, row + halfHeight};
}

/// The coarsest level on which the box still is two pixels wide and high.
int levelFor(const std::vector<GridTopology>& levels, const PixelBox& box);

/// Calls visit(pixel, area) for the pixels that a box meets, with the area of theirs inside it in pixels of their
/// level; pixels that the raster does not have are left out. Of more than 512 pixels a side every second, third, ...
/// stands for all. Returns the area of the whole box, in the same unit; nothing when a read failed.
template <class T, class Visit>
std::optional<double> visitBox(PixelStore<T>& store, const PixelBox& box, const Visit& visit) {
  constexpr int kMostASide = 512;
  const int level = levelFor(store.levels(), box);
  const GridTopology& full = store.levels().front();
  const GridTopology& grid = store.levels()[static_cast<std::size_t>(level)];
  const double sx = static_cast<double>(grid.width) / full.width;
  const double sy = static_cast<double>(grid.height) / full.height;
  const PixelBox b{box.left * sx, box.right * sx, box.top * sy, box.bottom * sy};
  const int firstRow = static_cast<int>(std::floor(b.top));
  const int firstCol = static_cast<int>(std::floor(b.left));
  const int rowStep = 1 + static_cast<int>(b.bottom - b.top) / kMostASide;
  const int colStep = 1 + static_cast<int>(b.right - b.left) / kMostASide;
  double whole = 0.0;
  const int lastCol = static_cast<int>(std::ceil(b.right)) - 1;
  const int lastRow = static_cast<int>(std::ceil(b.bottom)) - 1;
  const bool isInside = firstCol >= 0 && firstRow >= 0 && lastCol < grid.width && lastRow < grid.height;
  if (isInside && rowStep == 1 && colStep == 1) {
    // The same sums in the same order, without a look-up a pixel.
    if (const T* pixels = store.pixelsOfOneBlock(level, firstCol, lastCol, firstRow, lastRow)) {
      for (int row = firstRow; row <= lastRow; ++row, pixels += PixelStore<T>::kSide) {
        const double high = std::min(b.bottom, row + 1.0) - std::max(b.top, static_cast<double>(row));
        for (int col = firstCol; col <= lastCol; ++col) {
          const double area = high * (std::min(b.right, col + 1.0) - std::max(b.left, static_cast<double>(col)));
          whole += area;
          visit(pixels[col - firstCol], area);
        }
      }
      return whole;
    }
  }
  for (int row = firstRow; row < b.bottom; row += rowStep) {
    const double high = std::min(b.bottom, row + 1.0) - std::max(b.top, static_cast<double>(row));
    for (int col = firstCol; col < b.right; col += colStep) {
      const double area = high * (std::min(b.right, col + 1.0) - std::max(b.left, static_cast<double>(col)));
      whole += area;
      int c = col;
      int r = row;
      if (!grid.resolve(c, r)) continue;
      const T* pixel = store.pixel(level, c, r);
      if (pixel == nullptr) return std::nullopt;
      visit(*pixel, area);
    }
  }
  return whole;
}

}  // namespace tellurion::raster
