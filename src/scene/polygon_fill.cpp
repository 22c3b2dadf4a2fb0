#include "scene/polygon_fill.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

namespace tellurion::scene {
namespace {

using DirectedEdge = std::pair<GridPoint, GridPoint>;

/// Whether p lies in the triangle or on its border; the triangle's own corners do not count.
bool holds(const GridTriangle& t, GridPoint p) {
  if (p == t[0] || p == t[1] || p == t[2]) return false;
  return doubleArea(t[0], t[1], p) >= 0 && doubleArea(t[1], t[2], p) >= 0 && doubleArea(t[2], t[0], p) >= 0;
}

int squaredLength(GridPoint a, GridPoint b) {
  const int across = b.col - a.col;
  const int down = b.row - a.row;
  return across * across + down * down;
}

GridTriangle triangleAt(const std::vector<GridPoint>& polygon, std::size_t tip) {
  const std::size_t n = polygon.size();
  return {polygon[(tip + n - 1) % n], polygon[tip], polygon[(tip + 1) % n]};
}

/// Of the corners that stand out, the one that is cut off along the shortest line; `freeOnly`: of those whose triangle
/// holds no other corner. The number of corners where there is none.
std::size_t shortestEar(const std::vector<GridPoint>& polygon, bool freeOnly) {
  std::size_t best = polygon.size();
  int shortest = std::numeric_limits<int>::max();
  for (std::size_t tip = 0; tip < polygon.size(); ++tip) {
    const GridTriangle t = triangleAt(polygon, tip);
    const int length = squaredLength(t[0], t[2]);
    if (length >= shortest || doubleArea(t[0], t[1], t[2]) <= 0) continue;
    if (freeOnly && std::any_of(polygon.begin(), polygon.end(), [&](GridPoint p) { return holds(t, p); })) continue;
    best = tip;
    shortest = length;
  }
  return best;
}

}  // namespace

std::vector<GridPoint> outlineOf(const std::vector<GridTriangle>& region) {
  std::vector<DirectedEdge> open;  // edges that no triangle has the other way round
  for (const GridTriangle& t : region) {
    for (std::size_t i = 0; i < 3; ++i) {
      const DirectedEdge edge{t[i], t[(i + 1) % 3]};
      const auto twin = std::find(open.begin(), open.end(), DirectedEdge{edge.second, edge.first});
      if (twin == open.end()) {
        open.push_back(edge);
      } else {
        open.erase(twin);
      }
    }
  }
  std::vector<GridPoint> outline;
  if (open.empty()) return outline;
  for (GridPoint at = open.front().first;;) {
    const auto next = std::find_if(open.begin(), open.end(), [&](const DirectedEdge& e) { return e.first == at; });
    if (next == open.end()) return outline;
    outline.push_back(at);
    at = next->second;
    open.erase(next);
  }
}

void fillPolygon(std::vector<GridPoint> outline, std::vector<GridTriangle>& out) {
  while (outline.size() >= 3) {
    std::size_t tip = shortestEar(outline, true);
    // A simple polygon has an ear. One that crosses itself is covered twice somewhere rather than left open.
    if (tip == outline.size()) tip = shortestEar(outline, false);
    if (tip == outline.size()) return;
    out.push_back(triangleAt(outline, tip));
    outline.erase(outline.begin() + static_cast<std::ptrdiff_t>(tip));
  }
}

}  // namespace tellurion::scene
