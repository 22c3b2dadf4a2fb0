#include "pyramid/sample_views.h"

#include <algorithm>

namespace tellurion::pyramid {
namespace {

bool liesOn(const SampleView& sample, tiling::Edge edge, int cells) {
  switch (edge) {
    case tiling::Edge::top:
      return sample.row == 0;
    case tiling::Edge::right:
      return sample.column == cells;
    case tiling::Edge::bottom:
      return sample.row == cells;
    case tiling::Edge::left:
      return sample.column == 0;
  }
  return false;
}

int along(const SampleView& sample, tiling::Edge edge) {
  return edge == tiling::Edge::top || edge == tiling::Edge::bottom ? sample.column : sample.row;
}

}  // namespace

SampleView viewFromEdge(const tiling::TileId& tile, tiling::Edge edge, int along, int depth, int cells) {
  switch (edge) {
    case tiling::Edge::top:
      return {tile, along, depth};
    case tiling::Edge::right:
      return {tile, cells - depth, along};
    case tiling::Edge::bottom:
      return {tile, along, cells - depth};
    case tiling::Edge::left:
      return {tile, depth, along};
  }
  return {tile, 0, 0};
}

SampleView viewAcross(const tiling::Tiling& tiling, const tiling::TileId& tile, tiling::Edge edge, int along, int depth,
                      int cells) {
  const tiling::EdgeNeighbour beyond = tiling.edgeNeighbour(tile, edge);
  return viewFromEdge(beyond.tile, beyond.edge, beyond.reversed ? cells - along : along, depth, cells);
}

std::vector<SampleView> viewsOf(const tiling::Tiling& tiling, const SampleView& sample, int cells) {
  std::vector<SampleView> views{sample};
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (const tiling::Edge edge : tiling::kEdges) {
      const SampleView from = views[i];
      if (!liesOn(from, edge, cells)) continue;
      const SampleView across = viewAcross(tiling, from.tile, edge, along(from, edge), 0, cells);
      if (std::ranges::find(views, across) == views.end()) views.push_back(across);
    }
  }
  return views;
}

}  // namespace tellurion::pyramid
