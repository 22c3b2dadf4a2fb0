#include "scene/polygon_fill.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace tellurion::scene {
namespace {

using DirectedEdge = std::pair<GridPoint, GridPoint>;

/// Whether p lies in the triangle or on its border; the triangle's own corners do not count.
bool holds(const GridTriangle& t, GridPoint p) {
  if (p == t[0] || p == t[1] || p == t[2]) return false;
  return doubleArea(t[0], t[1], p) >= 0 && doubleArea(t[1], t[2], p) >= 0 && doubleArea(t[2], t[0], p) >= 0;
}

bool isEar(const std::vector<GridPoint>& polygon, std::size_t tip) {
  const std::size_t n = polygon.size();
  const GridTriangle t{polygon[(tip + n - 1) % n], polygon[tip], polygon[(tip + 1) % n]};
  if (doubleArea(t[0], t[1], t[2]) <= 0) return false;
  return std::none_of(polygon.begin(), polygon.end(), [&](GridPoint p) { return holds(t, p); });
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
  for (std::size_t tip = 0, misses = 0; outline.size() >= 3 && misses <= outline.size();) {
    const std::size_t n = outline.size();
    tip %= n;
    if (!isEar(outline, tip)) {
      ++tip;
      ++misses;
      continue;
    }
    out.push_back({outline[(tip + n - 1) % n], outline[tip], outline[(tip + 1) % n]});
    outline.erase(outline.begin() + static_cast<std::ptrdiff_t>(tip));
    ++tip;  // not the neighbour next: thin fans from one corner are avoided where possible
    misses = 0;
  }
}

}  // namespace tellurion::scene
