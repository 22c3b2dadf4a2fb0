#include "scene/polygon_fill.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "geo/seed_test.h"

namespace tellurion::scene {
namespace {

GridPoint at(int col, int row) {
  return {static_cast<std::int16_t>(col), static_cast<std::int16_t>(row)};
}

int doubleArea(const std::vector<GridPoint>& polygon) {
  int sum = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    sum += scene::doubleArea(at(0, 0), polygon[i], polygon[(i + 1) % polygon.size()]);
  return sum;
}

/// By the crossings of a line to the right: no point here lies on a border.
bool isIn(const std::vector<GridPoint>& polygon, double col, double row) {
  bool inside = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const GridPoint a = polygon[i];
    const GridPoint b = polygon[(i + 1) % polygon.size()];
    if ((a.row > row) == (b.row > row)) continue;
    inside = inside != (col < a.col + (row - a.row) * (b.col - a.col) / (b.row - a.row));
  }
  return inside;
}

/// A ring of unit triangles that grows at random without ever closing around a hole: its outline is simple, with
/// straight angles and deep bays.
std::vector<GridPoint> randomPolygon(std::mt19937_64& random) {
  std::vector<GridPoint> polygon{at(0, 0), at(0, 1), at(1, 0)};
  if (doubleArea(polygon) < 0) std::swap(polygon[1], polygon[2]);
  const auto any = [&](int low, int high) { return static_cast<int>(std::floor(geo::uniform(random, low, high + 1))); };
  const int tries = any(5, 120);
  for (int i = 0; i < tries; ++i) {
    const auto side = static_cast<std::size_t>(any(0, static_cast<int>(polygon.size()) - 1));
    const GridPoint a = polygon[side];
    const GridPoint b = polygon[(side + 1) % polygon.size()];
    const GridPoint p = at(a.col + any(-3, 3), a.row + any(-3, 3));
    const GridTriangle added{b, a, p};
    if (scene::doubleArea(b, a, p) <= 0) continue;
    // The triangle touches the polygon along its one side and nowhere else.
    const auto meets = [&](GridPoint c, GridPoint d) {
      const auto sign = [](int v) { return (v > 0) - (v < 0); };
      for (const auto& [from, to] : {std::pair{a, p}, std::pair{p, b}}) {
        const bool shares = c == from || d == from || c == to || d == to;
        const int s = sign(scene::doubleArea(from, to, c)) * sign(scene::doubleArea(from, to, d));
        const int t = sign(scene::doubleArea(c, d, from)) * sign(scene::doubleArea(c, d, to));
        if (!shares && s <= 0 && t <= 0) return true;
      }
      return false;
    };
    bool free = true;
    for (std::size_t k = 0; k < polygon.size() && free; ++k) {
      const GridPoint c = polygon[k];
      const bool isCorner = c == a || c == b;
      free = !meets(c, polygon[(k + 1) % polygon.size()]) && c != p &&
             (isCorner || scene::doubleArea(added[0], added[1], c) < 0 ||
              scene::doubleArea(added[1], added[2], c) < 0 || scene::doubleArea(added[2], added[0], c) < 0);
    }
    if (free) polygon.insert(polygon.begin() + static_cast<std::ptrdiff_t>(side) + 1, p);
  }
  return polygon;
}

TEST(PolygonFill, fillsWhollyAndWithoutOverlap) {
  std::mt19937_64 random = geo::seededGenerator();
  std::size_t most = 0;
  int withStraightAngles = 0;
  for (int i = 0; i < 300; ++i) {
    const std::vector<GridPoint> polygon = randomPolygon(random);
    const std::size_t n = polygon.size();
    most = std::max(most, n);
    for (std::size_t k = 0; k < n; ++k)
      withStraightAngles += scene::doubleArea(polygon[k], polygon[(k + 1) % n], polygon[(k + 2) % n]) == 0 ? 1 : 0;
    std::vector<GridTriangle> filled;
    fillPolygon(polygon, filled);
    ASSERT_EQ(filled.size(), n - 2);
    int area = 0;
    for (const GridTriangle& t : filled) {
      ASSERT_GT(scene::doubleArea(t[0], t[1], t[2]), 0);
      area += scene::doubleArea(t[0], t[1], t[2]);
    }
    ASSERT_EQ(area, doubleArea(polygon));
    for (int k = 0; k < 200; ++k) {
      const double col = geo::uniform(random, -12, 12);
      const double row = geo::uniform(random, -12, 12);
      const auto holding = std::ranges::count_if(filled, [&](const GridTriangle& t) {
        return isIn({t.begin(), t.end()}, col, row);
      });
      ASSERT_EQ(holding, isIn(polygon, col, row) ? 1 : 0) << col << ", " << row;
    }
    // And back: its triangles have its outline again, from wherever that begins.
    std::vector<GridPoint> outline = outlineOf(filled);
    const auto first = std::ranges::find(outline, polygon.front());
    ASSERT_NE(first, outline.end());
    std::rotate(outline.begin(), first, outline.end());
    ASSERT_EQ(outline, polygon);
  }
  EXPECT_GT(most, 20u);
  EXPECT_GT(withStraightAngles, 50);
}

TEST(PolygonFill, leavesNoHoleWhereAPolygonCrossesItself) {
  std::mt19937_64 random = geo::seededGenerator();
  int without = 0;
  for (int i = 0; i < 300; ++i) {
    std::vector<GridPoint> polygon(8);
    for (GridPoint& p : polygon)
      p = at(static_cast<int>(geo::uniform(random, 0, 9)), static_cast<int>(geo::uniform(random, 0, 9)));
    if (doubleArea(polygon) <= 0) continue;
    ++without;
    std::vector<GridTriangle> filled;
    fillPolygon(polygon, filled);
    int area = 0;
    for (const GridTriangle& t : filled)
      area += scene::doubleArea(t[0], t[1], t[2]);
    ASSERT_GE(area, doubleArea(polygon));
  }
  EXPECT_GT(without, 50);
}

TEST(PolygonFill, nothingFillsWhatHasNoArea) {
  std::vector<GridTriangle> filled;
  for (const std::vector<GridPoint>& polygon :
       {std::vector<GridPoint>{}, {at(1, 1)}, {at(0, 0), at(5, 5)}, {at(0, 0), at(2, 2), at(7, 7), at(3, 3)}})
    fillPolygon(polygon, filled);
  EXPECT_TRUE(filled.empty());
  EXPECT_TRUE(outlineOf({}).empty());
}

}  // namespace
}  // namespace tellurion::scene
