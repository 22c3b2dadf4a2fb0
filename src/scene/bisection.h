#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geo/vector.h"

namespace tellurion::scene {

/// Right-triangle bisection of a square of cells, and its triangulation, in whole numbers: which samples become
/// vertices and how they are joined (docs/selection.md, "Too many triangles"). Knows no body and no heights but through
/// points in space.
///
/// Sample (col, row), 0..cells, row down. Counter-clockwise means as seen with the row axis down: from outside the
/// body.

/// A sample's place in the square.
struct GridPoint {
  std::int16_t col = 0;
  std::int16_t row = 0;
  friend bool operator==(const GridPoint&, const GridPoint&) = default;
};
using GridTriangle = std::array<GridPoint, 3>;  ///< counter-clockwise

/// Twice the area, positive when counter-clockwise from outside.
inline int doubleArea(GridPoint a, GridPoint b, GridPoint c) {
  return (b.row - a.row) * (c.col - a.col) - (b.col - a.col) * (c.row - a.row);
}

/// Along an edge of the square (tiling::Edge as a number): its i-th sample. Top and bottom run with col, left and right
/// with row.
GridPoint edgePoint(int edge, int i, int cells);
/// The inverse: which sample of an edge, or -1 when it lies elsewhere.
int alongEdge(int edge, GridPoint p, int cells);

/// One flag for each sample of an edge: whether it is a vertex. Bisection: a sample in the middle of two others stays
/// when it lies further than tolerance from the middle of the straight line between them, or when one below it stays.
/// The ends always stay. Reversing the samples reverses the flags, to the last bit. samples.size() - 1 is a power of
/// two.
std::vector<std::uint8_t> keptAlongEdge(std::span<const geo::Vec3> samples, double tolerance_m, bool keepMiddle);

/// Triangles of a square, in the groups that frame.h draws.
struct Triangulation {
  std::vector<GridTriangle> interior;  ///< those that touch no edge
  std::array<std::vector<GridTriangle>, 4> fine;
  std::array<std::vector<GridTriangle>, 4> coarse;
};

/// What makes a sample a vertex inside of a square, whose samples are (cells + 1)^2, row-major.
struct BisectionRule {
  std::vector<std::span<const geo::Vec3>> surfaces;  ///< each of which the triangles are to follow
  double tolerance_m = 0.0;        ///< by which a sample that is left out may lie off the middle of the line across it
  std::vector<std::uint8_t> kept;  ///< flags of samples that are vertices in any case, or empty
};

/// Inside, a sample is a vertex by the rule, or when one below it is. On edge e exactly those flagged in fineEdge[e]
/// (cells + 1 flags) are vertices of the fine variant and those of coarseEdge[e], a subset, of the coarse one. An
/// edge's flags hold its ends and middle, and with a sample the one above it (keptAlongEdge); the coarse ones need no
/// middle. The interior, with one variant of each edge, covers the square exactly once, whichever variants are taken.
Triangulation triangulate(const BisectionRule& rule, int cells,
                          const std::array<std::vector<std::uint8_t>, 4>& fineEdge,
                          const std::array<std::vector<std::uint8_t>, 4>& coarseEdge);

}  // namespace tellurion::scene
