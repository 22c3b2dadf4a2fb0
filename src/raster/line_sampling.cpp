#include "raster/line_sampling.h"

#include <algorithm>
#include <array>

#include "raster/bilinear_pixels.h"

namespace tellurion::raster {
namespace {

/// The columns of a tile over a raster.
struct Columns {
  std::vector<int> left;  ///< of the two pixels around each, of those that the raster has
  std::vector<int> right;
  std::vector<double> share;  ///< of the way from left to right
  std::vector<bool> isInside;
};

/// As PixelStore::quad, in rows that the raster has.
int existing(const GridTopology& grid, int col) {
  int row = 0;
  return grid.resolve(col, row) ? col : std::clamp(col, 0, grid.width - 1);
}

Columns columnsOf(const GridTopology& grid, const std::vector<double>& cols) {
  Columns columns;
  for (const double col : cols) {
    const bool inside = isInside(grid, col, 0.0);
    const Between place = between(inside ? col : 0.5, 0.5);
    columns.left.push_back(existing(grid, place.col));
    columns.right.push_back(existing(grid, place.col + 1));
    columns.share.push_back(place.s);
    columns.isInside.push_back(inside);
  }
  return columns;
}

/// Calls visit(column of the tile, left pixel, right pixel) along a row of the raster. False: a read failed.
template <class T, class Visit>
bool alongRow(PixelStore<T>& store, const Columns& columns, int row, const Visit& visit) {
  const T* block = nullptr;
  int blockOf = -1;
  const auto pixel = [&](int col, T& out) {
    if (col >> PixelStore<T>::kBits != blockOf) {
      blockOf = col >> PixelStore<T>::kBits;
      block = store.pixel(0, blockOf << PixelStore<T>::kBits, row);
    }
    if (block != nullptr) out = block[col & (PixelStore<T>::kSide - 1)];
    return block != nullptr;
  };
  for (std::size_t c = 0; c < columns.left.size(); ++c) {
    if (!columns.isInside[c]) continue;
    T left{};
    T right{};
    if (!pixel(columns.left[c], left) || !pixel(columns.right[c], right)) return false;
    visit(c, left, right);
  }
  return true;
}

/// The two rows of a raster that were asked for last, between which a tile's row lies. Line has
///   bool fill(PixelStore&, const Columns&, int row)
template <class Line, class T>
class LatestRows {
 public:
  LatestRows(PixelStore<T>& store, const Columns& columns) : store_(store), columns_(columns) {}

  /// Null: a read failed. Good until two other rows were asked for.
  const Line* row(int row) {
    for (Slot& slot : slots_) {
      if (slot.row == row) {
        latest_ = &slot;
        return &slot.line;
      }
    }
    Slot& other = latest_ == &slots_[0] ? slots_[1] : slots_[0];
    other.row = -1;
    if (!other.line.fill(store_, columns_, row)) return nullptr;
    other.row = row;
    latest_ = &other;
    return &other.line;
  }

 private:
  struct Slot {
    int row = -1;
    Line line;
  };
  PixelStore<T>& store_;
  const Columns& columns_;
  std::array<Slot, 2> slots_;
  Slot* latest_ = nullptr;
};

struct HeightLine {
  std::vector<double> heights;

  bool fill(PixelStore<float>& store, const Columns& columns, int row) {
    heights.resize(columns.left.size());
    return alongRow(store, columns, row, [&](std::size_t c, float left, float right) {
      const double s = columns.share[c];
      heights[c] = static_cast<double>(left) * (1.0 - s) + static_cast<double>(right) * s;
    });
  }
};

/// Linear light, times 256.
struct ColourLine {
  std::vector<std::uint32_t> light;  ///< three a column
  bool isOpaque = true;

  bool fill(PixelStore<Rgba8>& store, const Columns& columns, int row) {
    const ColourTables tables = colourTables();
    light.resize(3 * columns.left.size());
    std::uint8_t coverage = 255;
    const bool done = alongRow(store, columns, row, [&](std::size_t c, Rgba8 left, Rgba8 right) {
      const std::uint32_t s = roundedUnsigned(columns.share[c] * 256.0);
      light[3 * c] = (256 - s) * tables.linear[left.r] + s * tables.linear[right.r];
      light[3 * c + 1] = (256 - s) * tables.linear[left.g] + s * tables.linear[right.g];
      light[3 * c + 2] = (256 - s) * tables.linear[left.b] + s * tables.linear[right.b];
      coverage &= left.a & right.a;
    });
    isOpaque = coverage == 255;
    return done;
  }
};

/// Samples of one row of the tile.
struct Run {
  std::span<const std::size_t> columns;  ///< indices into the tile, the first of the row taken off below
  std::size_t origin = 0;
  int row = 0;     ///< of the raster, above the line
  double t = 0.0;  ///< the line between it and the next
};

/// Calls visit(run, its part of `out`) for each row; rows that lie beyond the raster are left out.
template <class T, class Visit>
bool forEachRun(const GridTopology& grid, const PixelLines& lines, std::span<const std::size_t> indices,
                std::span<T> out, const Visit& visit) {
  const std::size_t side = lines.col.size();
  for (std::size_t first = 0, end = 0; first < indices.size(); first = end) {
    const std::size_t tileRow = indices[first] / side;
    const std::size_t next = (tileRow + 1) * side;
    end = static_cast<std::size_t>(std::ranges::lower_bound(indices, next) - indices.begin());
    const double row = lines.row[tileRow];
    if (!isInside(grid, 0.0, row)) continue;
    const Between place = between(0.5, row);
    const Run run{
        .columns = indices.subspan(first, end - first), .origin = tileRow * side, .row = place.row, .t = place.t};
    if (!visit(run, out.subspan(first, end - first))) return false;
  }
  return true;
}

/// Few samples of a row are read one by one, and those between rows of which the raster has not both.
bool isWorthALine(const Run& run, const GridTopology& grid, const PixelLines& lines) {
  return 2 * run.columns.size() >= lines.col.size() && run.row >= 0 && run.row + 1 < grid.height;
}

template <class T, class Lay>
bool layOne(PixelStore<T>& store, const PixelLines& lines, const Run& run, std::size_t column, T& out, const Lay& lay) {
  Between place = between(lines.col[column], 0.5);
  place.row = run.row;
  place.t = run.t;
  std::array<T, 4> corners{};
  if (!store.quad(place.col, place.row, corners)) return false;
  lay(corners, place, out);
  return true;
}

}  // namespace

bool bilinearHeightsOnLines(PixelStore<float>& store, const PixelLines& lines, std::span<const std::size_t> indices,
                            std::span<float> out) {
  const GridTopology grid = store.levels().front();
  const Columns columns = columnsOf(grid, lines.col);
  LatestRows<HeightLine, float> rows(store, columns);
  return forEachRun(grid, lines, indices, out, [&](const Run& run, std::span<float> part) {
    const bool isLine = isWorthALine(run, grid, lines);
    const HeightLine* upper = isLine ? rows.row(run.row) : nullptr;
    const HeightLine* lower = isLine ? rows.row(run.row + 1) : nullptr;
    if (isLine && (upper == nullptr || lower == nullptr)) return false;
    for (std::size_t i = 0; i < run.columns.size(); ++i) {
      const std::size_t c = run.columns[i] - run.origin;
      if (!columns.isInside[c]) continue;
      if (isLine) {
        const double height = upper->heights[c] * (1.0 - run.t) + lower->heights[c] * run.t;
        if (!std::isnan(height)) {
          part[i] = static_cast<float>(height);
          continue;
        }
      }
      if (!layOne(store, lines, run, c, part[i], layHeight)) return false;
    }
    return true;
  });
}

bool bilinearColoursOnLines(PixelStore<Rgba8>& store, const PixelLines& lines, std::span<const std::size_t> indices,
                            std::span<Rgba8> out) {
  const GridTopology grid = store.levels().front();
  const ColourTables tables = colourTables();
  const Columns columns = columnsOf(grid, lines.col);
  LatestRows<ColourLine, Rgba8> rows(store, columns);
  std::vector<std::uint32_t> mixed(3 * columns.left.size());
  const auto lay = [&](const std::array<Rgba8, 4>& corners, const Between& place, Rgba8& colour) {
    layColour(tables, corners, place, colour);
  };
  return forEachRun(grid, lines, indices, out, [&](const Run& run, std::span<Rgba8> part) {
    const bool isLine = isWorthALine(run, grid, lines);
    const ColourLine* upper = isLine ? rows.row(run.row) : nullptr;
    const ColourLine* lower = isLine ? rows.row(run.row + 1) : nullptr;
    if (isLine && (upper == nullptr || lower == nullptr)) return false;
    const bool isOpaque = isLine && upper->isOpaque && lower->isOpaque;
    if (isOpaque) {
      const std::uint32_t t = roundedUnsigned(run.t * 256.0);
      for (std::size_t i = 0; i < mixed.size(); ++i)
        mixed[i] = ((256 - t) * upper->light[i] + t * lower->light[i] + 32768u) >> 16u;
    }
    for (std::size_t i = 0; i < run.columns.size(); ++i) {
      const std::size_t c = run.columns[i] - run.origin;
      if (!columns.isInside[c]) continue;
      if (isOpaque) {
        part[i] = {tables.srgb[mixed[3 * c]], tables.srgb[mixed[3 * c + 1]], tables.srgb[mixed[3 * c + 2]], 255};
      } else if (!layOne(store, lines, run, c, part[i], lay)) {
        return false;
      }
    }
    return true;
  });
}

}  // namespace tellurion::raster
