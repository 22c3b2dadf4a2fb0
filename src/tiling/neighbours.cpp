#include <algorithm>

#include "tiling/faces.h"

namespace tellurion::tiling {

namespace {

std::span<const RootLinks> linksOf(Scheme scheme) {
  switch (scheme) {
    case Scheme::geographic:
    case Scheme::cube:
      return faceLinks();
    case Scheme::healpix:
      break;
  }
  return healpix::links();
}

const RootLink& linkOf(Scheme scheme, int root, Edge edge) {
  return linksOf(scheme)[static_cast<std::size_t>(root)][static_cast<std::size_t>(edge)];
}

Edge opposite(Edge e) {
  return static_cast<Edge>((static_cast<int>(e) + 2) % 4);
}
bool runsWithU(Edge e) {
  return e == Edge::top || e == Edge::bottom;
}

// --- tiles

// The tile that lies at `along` on an edge of a root.
TileId tileOnEdge(std::uint8_t level, std::uint8_t root, Edge edge, std::uint32_t along) {
  const std::uint32_t last = (std::uint32_t{1} << level) - 1u;
  switch (edge) {
    case Edge::top:
      return {level, root, along, 0};
    case Edge::right:
      return {level, root, last, along};
    case Edge::bottom:
      return {level, root, along, last};
    case Edge::left:
      break;
  }
  return {level, root, 0, along};
}

bool isOnRootEdge(const TileId& id, Edge edge) {
  const std::uint32_t last = (std::uint32_t{1} << id.level) - 1u;
  switch (edge) {
    case Edge::top:
      return id.y == 0;
    case Edge::right:
      return id.x == last;
    case Edge::bottom:
      return id.y == last;
    case Edge::left:
      break;
  }
  return id.x == 0;
}

TileId besideWithinRoot(TileId id, Edge edge) {
  switch (edge) {
    case Edge::top:
      --id.y;
      break;
    case Edge::right:
      ++id.x;
      break;
    case Edge::bottom:
      ++id.y;
      break;
    case Edge::left:
      --id.x;
      break;
  }
  return id;
}

// --- corners: where an edge begins and ends in its sense of running, and the two edges of a corner

struct EdgeEnds {
  Corner begin;
  Corner end;
};
EdgeEnds endsOf(Edge e) {
  switch (e) {
    case Edge::top:
      return {Corner::topLeft, Corner::topRight};
    case Edge::right:
      return {Corner::topRight, Corner::bottomRight};
    case Edge::bottom:
      return {Corner::bottomLeft, Corner::bottomRight};
    case Edge::left:
      break;
  }
  return {Corner::topLeft, Corner::bottomLeft};
}

struct CornerEdges {
  Edge horizontal;
  Edge vertical;
};
CornerEdges edgesOf(Corner c) {
  switch (c) {
    case Corner::topLeft:
      return {Edge::top, Edge::left};
    case Corner::topRight:
      return {Edge::top, Edge::right};
    case Corner::bottomRight:
      return {Edge::bottom, Edge::right};
    case Corner::bottomLeft:
      break;
  }
  return {Edge::bottom, Edge::left};
}

Edge otherEdgeAt(Corner corner, Edge edge) {
  const CornerEdges edges = edgesOf(corner);
  return edges.horizontal == edge ? edges.vertical : edges.horizontal;
}

// --- places

// The edge of the unit square that (u, v) lies across, looking along u or along v only.
std::optional<Edge> crossedAlongU(const RootPoint& p) {
  if (p.u < 0.0) return Edge::left;
  if (p.u > 1.0) return Edge::right;
  return std::nullopt;
}
std::optional<Edge> crossedAlongV(const RootPoint& p) {
  if (p.v < 0.0) return Edge::top;
  if (p.v > 1.0) return Edge::bottom;
  return std::nullopt;
}

RootPoint placeInside(int root, Edge edge, double along, double depth) {
  switch (edge) {
    case Edge::top:
      return {root, along, depth};
    case Edge::right:
      return {root, 1.0 - depth, along};
    case Edge::bottom:
      return {root, along, 1.0 - depth};
    case Edge::left:
      break;
  }
  return {root, depth, along};
}

RootPoint acrossEdge(Scheme scheme, const RootPoint& p, Edge edge) {
  const RootLink& link = linkOf(scheme, p.root, edge);
  const double along = runsWithU(edge) ? p.u : p.v;
  const double position = runsWithU(edge) ? p.v : p.u;
  const double depth = position < 0.0 ? -position : position - 1.0;
  return placeInside(link.root, link.edge, link.reversed ? 1.0 - along : along, depth);
}

bool isOutside(const RootPoint& p) {
  return crossedAlongU(p).has_value() || crossedAlongV(p).has_value();
}

RootPoint acrossWhatItCrosses(Scheme scheme, const RootPoint& p) {
  if (const auto edge = crossedAlongU(p)) return acrossEdge(scheme, p, *edge);
  if (const auto edge = crossedAlongV(p)) return acrossEdge(scheme, p, *edge);
  return p;
}

}  // namespace

std::optional<RootPoint> Tiling::wrapped(const RootPoint& p) const {
  const auto acrossU = crossedAlongU(p);
  const auto acrossV = crossedAlongV(p);
  if (!acrossU || !acrossV) return acrossWhatItCrosses(scheme_, p);
  const RootPoint first = acrossWhatItCrosses(scheme_, acrossEdge(scheme_, p, *acrossU));
  const RootPoint second = acrossWhatItCrosses(scheme_, acrossEdge(scheme_, p, *acrossV));
  const bool agree = first.root == second.root && first.u == second.u && first.v == second.v;
  if (!agree || isOutside(first)) return std::nullopt;
  return first;
}

EdgeNeighbour Tiling::edgeNeighbour(const TileId& id, Edge edge) const {
  if (!isOnRootEdge(id, edge)) return {besideWithinRoot(id, edge), opposite(edge), false};
  const RootLink& link = linkOf(scheme_, id.root, edge);
  const std::uint32_t last = (std::uint32_t{1} << id.level) - 1u;
  const std::uint32_t along = runsWithU(edge) ? id.x : id.y;
  return {tileOnEdge(id.level, link.root, link.edge, link.reversed ? last - along : along), link.edge, link.reversed};
}

// Walks around the corner from tile to tile until it is back.
std::optional<TileId> Tiling::cornerNeighbour(const TileId& id, Corner corner) const {
  std::array<TileId, 4> around;
  std::size_t count = 0;
  TileId at = id;
  Corner atCorner = corner;
  Edge through = edgesOf(corner).horizontal;
  do {
    const EdgeNeighbour next = edgeNeighbour(at, through);
    const bool atBegin = (endsOf(through).begin == atCorner) != next.reversed;
    atCorner = atBegin ? endsOf(next.edge).begin : endsOf(next.edge).end;
    at = next.tile;
    through = otherEdgeAt(atCorner, next.edge);
    around[count++] = at;
  } while (at != id && count < around.size());
  // First and third are the edge neighbours, the fourth is id itself.
  return count < 4 ? std::nullopt : std::optional(around[1]);
}

}  // namespace tellurion::tiling
