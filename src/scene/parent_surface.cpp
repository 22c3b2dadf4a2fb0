#include "scene/parent_surface.h"

#include <algorithm>
#include <tuple>

#include "scene/bisection.h"

namespace tellurion::scene {
namespace {

/// A vertex of the parent's mesh, placed in samples of the tile (outside of 0..cells too).
struct ParentVertex {
  GridPoint place;
  geo::Vec3 position;
  double height_m = 0.0;
};

bool isBefore(const geo::Vec3& a, const geo::Vec3& b) {
  return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

class Painter {
 public:
  Painter(const TerrainMesh& parent, double vertexGrid_m, int quadrant, int cells) : cells_(cells) {
    const auto samples = static_cast<std::size_t>((cells + 1) * (cells + 1));
    out_.positions.resize(samples);
    out_.heights_m.resize(samples);
    out_.isVertex.resize(samples);
    const auto placed = [&](std::uint16_t units, int half) {
      return static_cast<std::int16_t>(2 * cells * units / kPlaceUnits - half * cells);
    };
    for (const TerrainVertex& v : parent.vertices) {
      const geo::Vec3 fine(v.fine_tile[0], v.fine_tile[1], v.fine_tile[2]);
      vertices_.push_back({.place = {placed(v.s, quadrant & 1), placed(v.t, quadrant >> 1)},
                           .position = parent.origin.m + geo::Vec3(v.position_tile) + fine * vertexGrid_m,
                           .height_m = static_cast<double>(v.height_m)});
    }
    for (const ParentVertex& v : vertices_) {
      if (isWithin(v.place)) out_.isVertex[index(v.place)] = 1;
    }
    paint(parent, parent.interior);
    for (const IndexRange& edge : parent.fineEdge)
      paint(parent, edge);
    for (int edge = 0; edge < 4; ++edge)
      paintEdge(edge);
  }

  ParentSurface take() { return std::move(out_); }

 private:
  std::size_t index(GridPoint p) const {
    return static_cast<std::size_t>(p.row) * static_cast<std::size_t>(cells_ + 1) + static_cast<std::size_t>(p.col);
  }

  bool isWithin(GridPoint p) const { return std::min(p.col, p.row) >= 0 && std::max(p.col, p.row) <= cells_; }

  void set(GridPoint p, const geo::Vec3& position, double height_m) {
    const std::size_t i = index(p);
    out_.positions[i] = position;
    out_.heights_m[i] = height_m;
  }

  void paint(const TerrainMesh& parent, const IndexRange& range) {
    for (std::uint32_t i = range.first; i + 2 < range.first + range.count; i += 3) {
      paint(vertices_[parent.indices[i]], vertices_[parent.indices[i + 1]], vertices_[parent.indices[i + 2]]);
    }
  }

  void paint(const ParentVertex& a, const ParentVertex& b, const ParentVertex& c) {
    const auto [west, east] = std::minmax({a.place.col, b.place.col, c.place.col});
    const auto [north, south] = std::minmax({a.place.row, b.place.row, c.place.row});
    const int area = doubleArea(a.place, b.place, c.place);
    if (area <= 0) return;
    for (int row = std::max<int>(north, 0); row <= std::min<int>(south, cells_); ++row) {
      for (int col = std::max<int>(west, 0); col <= std::min<int>(east, cells_); ++col) {
        const GridPoint p{static_cast<std::int16_t>(col), static_cast<std::int16_t>(row)};
        const int wa = doubleArea(b.place, c.place, p);
        const int wb = doubleArea(c.place, a.place, p);
        const int wc = doubleArea(a.place, b.place, p);
        if (wa < 0 || wb < 0 || wc < 0) continue;
        const auto mix = [&](const auto& va, const auto& vb, const auto& vc) {
          return (va * static_cast<double>(wa) + vb * static_cast<double>(wb) + vc * static_cast<double>(wc)) *
                 (1.0 / area);
        };
        set(p, mix(a.position, b.position, c.position), mix(a.height_m, b.height_m, c.height_m));
      }
    }
  }

  void paintEdge(int edge) {
    std::vector<const ParentVertex*> chain(static_cast<std::size_t>(cells_) + 1, nullptr);
    for (const ParentVertex& v : vertices_) {
      const bool horizontal = edge == 0 || edge == 2;
      const int line = edge == 1 || edge == 2 ? cells_ : 0;
      const int along = horizontal ? v.place.col : v.place.row;
      if ((horizontal ? v.place.row : v.place.col) == line && along >= 0 && along <= cells_)
        chain[static_cast<std::size_t>(along)] = &v;
    }
    int last = 0;
    for (int i = 0; i <= cells_; ++i) {
      if (chain[static_cast<std::size_t>(i)] == nullptr) continue;
      for (int between = last; between <= i; ++between)
        paintBetween(edge, *chain[static_cast<std::size_t>(last)], last, *chain[static_cast<std::size_t>(i)], i,
                     between);
      last = i;
    }
  }

  void paintBetween(int edge, const ParentVertex& from, int first, const ParentVertex& to, int last, int i) {
    const GridPoint p = edgePoint(edge, i, cells_);
    if (first == last || i == first) return set(p, from.position, from.height_m);
    if (i == last) return set(p, to.position, to.height_m);
    double weightFrom = static_cast<double>(last - i) / (last - first);
    double weightTo = static_cast<double>(i - first) / (last - first);
    const ParentVertex* a = &from;
    const ParentVertex* b = &to;
    if (isBefore(b->position, a->position)) {
      std::swap(a, b);
      std::swap(weightFrom, weightTo);
    }
    set(p, a->position * weightFrom + b->position * weightTo, a->height_m * weightFrom + b->height_m * weightTo);
  }

  int cells_;
  std::vector<ParentVertex> vertices_;
  ParentSurface out_;
};

}  // namespace

ParentSurface parentSurface(const TerrainMesh& parent, double vertexGrid_m, int quadrant, int cells) {
  return Painter(parent, vertexGrid_m, quadrant, cells).take();
}

}  // namespace tellurion::scene
