#include "scene/bisection.h"

#include <algorithm>
#include <cstddef>

#include "scene/polygon_fill.h"

namespace tellurion::scene {
namespace {

GridPoint middleOf(GridPoint a, GridPoint b) {
  return {static_cast<std::int16_t>((a.col + b.col) / 2), static_cast<std::int16_t>((a.row + b.row) / 2)};
}

double deviation(const geo::Vec3& a, const geo::Vec3& b, const geo::Vec3& middle) {
  return geo::length(middle - (a + b) * 0.5);
}

/// Which samples of the square are vertices of its bisection. Blocks of 2, 4, ... cells: the middles of a block's sides
/// are split after its centre, its centre after the two of its corners that are middles of sides of the block twice as
/// wide.
class KeptSamples {
 public:
  KeptSamples(const BisectionRule& rule, int cells, const std::array<std::vector<std::uint8_t>, 4>& edges)
      : surfaces_(rule.surfaces), tolerance_m_(rule.tolerance_m), cells_(cells), kept_(rule.kept) {
    kept_.resize(static_cast<std::size_t>((cells + 1) * (cells + 1)), 0);
    for (int edge = 0; edge < 4; ++edge) {
      for (int i = 0; i <= cells; ++i) {
        const GridPoint p = edgePoint(edge, i, cells);
        if (edges[static_cast<std::size_t>(edge)][static_cast<std::size_t>(i)] != 0) mark(p.col, p.row);
      }
    }
    for (int size = 2; size <= cells; size *= 2) {
      markSideMiddles(size);
      markCentres(size);
    }
    const int half = cells / 2;
    mark(half, half);
    mark(half, 0);
    mark(half, cells);
    mark(0, half);
    mark(cells, half);
  }

  bool has(GridPoint p) const { return kept_[index(p.col, p.row)] != 0; }

 private:
  std::size_t index(int col, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(cells_ + 1) + static_cast<std::size_t>(col);
  }
  void mark(int col, int row) { kept_[index(col, row)] = 1; }

  bool keep(int col, int row, int dCol, int dRow) {
    std::uint8_t& flag = kept_[index(col, row)];
    const auto leaves = [&](std::span<const geo::Vec3> surface) {
      return deviation(surface[index(col - dCol, row - dRow)], surface[index(col + dCol, row + dRow)],
                       surface[index(col, row)]) > tolerance_m_;
    };
    if (flag == 0 && std::any_of(surfaces_.begin(), surfaces_.end(), leaves)) flag = 1;
    return flag != 0;
  }

  void markSideMiddles(int size) {
    const int half = size / 2;
    for (int line = 0; line <= cells_; line += size) {
      for (int middle = half; middle < cells_; middle += size) {
        if (keep(middle, line, half, 0)) {
          if (line > 0) mark(middle, line - half);
          if (line < cells_) mark(middle, line + half);
        }
        if (keep(line, middle, 0, half)) {
          if (line > 0) mark(line - half, middle);
          if (line < cells_) mark(line + half, middle);
        }
      }
    }
  }

  void markCentres(int size) {
    const int half = size / 2;
    for (int row = half; row < cells_; row += size) {
      for (int col = half; col < cells_; col += size) {
        // The diagonal runs from the corner that is a corner of the block twice as wide to that block's centre.
        const bool falling = ((col / size) & 1) == ((row / size) & 1);
        if (!keep(col, row, half, falling ? half : -half) || size == cells_) continue;
        mark(col + half, falling ? row - half : row + half);
        mark(col - half, falling ? row + half : row - half);
      }
    }
  }

  std::span<const std::span<const geo::Vec3>> surfaces_;
  double tolerance_m_;
  int cells_;
  std::vector<std::uint8_t> kept_;
};

/// The triangles of one quarter of the square (an edge and the centre).
void bisect(const KeptSamples& kept, GridPoint a, GridPoint b, GridPoint apex, std::vector<GridTriangle>& out) {
  const bool even = ((a.col + b.col) & 1) == 0 && ((a.row + b.row) & 1) == 0;
  if (even && kept.has(middleOf(a, b))) {
    const GridPoint middle = middleOf(a, b);
    bisect(kept, apex, a, middle, out);
    bisect(kept, b, apex, middle, out);
  } else {
    out.push_back({a, b, apex});
  }
}

/// An edge's strip with only the flagged vertices on the edge: triangles whose vertices all stay are taken over, the
/// holes around vertices that go are filled again.
std::vector<GridTriangle> stripWith(const std::vector<GridTriangle>& strip, int edge, int cells,
                                    const std::vector<std::uint8_t>& flags) {
  // hole[i]: the flagged sample at or before i, which numbers the hole that an unflagged sample i lies in.
  std::vector<int> hole(flags.size());
  for (int i = 0, last = 0; i <= cells; ++i) {
    if (flags[static_cast<std::size_t>(i)] != 0) last = i;
    hole[static_cast<std::size_t>(i)] = last;
  }
  std::vector<GridTriangle> out;
  std::vector<std::pair<int, GridTriangle>> torn;
  for (const GridTriangle& t : strip) {
    int in = -1;
    for (const GridPoint p : t) {
      const int i = alongEdge(edge, p, cells);
      if (i >= 0 && flags[static_cast<std::size_t>(i)] == 0) in = hole[static_cast<std::size_t>(i)];
    }
    if (in < 0) {
      out.push_back(t);
    } else {
      torn.emplace_back(in, t);
    }
  }
  std::stable_sort(torn.begin(), torn.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (std::size_t i = 0; i < torn.size();) {
    std::vector<GridTriangle> region;
    const int in = torn[i].first;
    for (; i < torn.size() && torn[i].first == in; ++i)
      region.push_back(torn[i].second);
    std::vector<GridPoint> outline = outlineOf(region);
    std::erase_if(outline, [&](GridPoint p) {
      const int at = alongEdge(edge, p, cells);
      return at >= 0 && flags[static_cast<std::size_t>(at)] == 0;
    });
    fillPolygon(std::move(outline), out);
  }
  return out;
}

}  // namespace

GridPoint edgePoint(int edge, int i, int cells) {
  const auto at = static_cast<std::int16_t>(i);
  const auto far = static_cast<std::int16_t>(cells);
  switch (edge) {
    case 0:
      return {at, 0};
    case 1:
      return {far, at};
    case 2:
      return {at, far};
    default:
      return {0, at};
  }
}

int alongEdge(int edge, GridPoint p, int cells) {
  const bool horizontal = edge == 0 || edge == 2;
  const int across = horizontal ? p.row : p.col;
  const int line = edge == 1 || edge == 2 ? cells : 0;
  if (across != line) return -1;
  return horizontal ? p.col : p.row;
}

std::vector<std::uint8_t> keptAlongEdge(std::span<const geo::Vec3> samples, double tolerance_m, bool keepMiddle) {
  const std::size_t cells = samples.size() - 1;
  std::vector<std::uint8_t> kept(samples.size(), 0);
  kept.front() = kept.back() = 1;
  if (keepMiddle) kept[cells / 2] = 1;
  for (std::size_t half = 1; half <= cells / 2; half *= 2) {
    for (std::size_t i = half; i < cells; i += 2 * half) {
      if (kept[i] == 0 && !(deviation(samples[i - half], samples[i + half], samples[i]) > tolerance_m)) continue;
      kept[i] = 1;
      // The sample above it: the middle of the segment twice as long that this one's segment is a half of.
      const std::size_t above = ((i / (2 * half)) & 1) == 0 ? i + half : i - half;
      kept[above] = 1;
    }
  }
  return kept;
}

Triangulation triangulate(const BisectionRule& rule, int cells,
                          const std::array<std::vector<std::uint8_t>, 4>& fineEdge,
                          const std::array<std::vector<std::uint8_t>, 4>& coarseEdge) {
  const KeptSamples vertices(rule, cells, fineEdge);
  const GridPoint centre{static_cast<std::int16_t>(cells / 2), static_cast<std::int16_t>(cells / 2)};
  Triangulation out;
  for (int edge = 0; edge < 4; ++edge) {
    GridPoint a = edgePoint(edge, 0, cells);
    GridPoint b = edgePoint(edge, cells, cells);
    if (doubleArea(a, b, centre) < 0) std::swap(a, b);
    std::vector<GridTriangle> quarter;
    bisect(vertices, a, b, centre, quarter);
    const auto inside = std::partition(quarter.begin(), quarter.end(), [&](const GridTriangle& t) {
      return std::any_of(t.begin(), t.end(), [&](GridPoint p) { return alongEdge(edge, p, cells) >= 0; });
    });
    out.interior.insert(out.interior.end(), inside, quarter.end());
    quarter.erase(inside, quarter.end());
    const auto e = static_cast<std::size_t>(edge);
    out.fine[e] = stripWith(quarter, edge, cells, fineEdge[e]);
    out.coarse[e] = stripWith(quarter, edge, cells, coarseEdge[e]);
  }
  return out;
}

}  // namespace tellurion::scene
