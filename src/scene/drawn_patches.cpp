#include "scene/drawn_patches.h"

#include <bit>
#include <utility>

#include "scene/tile_record.h"

namespace tellurion::scene {
namespace {

MeshPart meshOf(const SelectedTile& tile) {
  if (tile.over == nullptr) return {.mesh = static_cast<const TileRecord*>(tile.facts)->content->mesh.get()};
  return {.mesh = static_cast<const TileRecord*>(tile.over)->content->mesh.get(), .quadrant = tile.id.quadrant()};
}

}  // namespace

FinerEdge finerEdgeAlong(const tiling::Tiling& tiling, const tiling::TileId& coarse, const tiling::TileId& fine,
                         std::uint8_t edge) {
  const tiling::EdgeNeighbour beyond = tiling.edgeNeighbour(fine, tiling::kEdges[edge]);
  const bool horizontal = beyond.edge == tiling::Edge::top || beyond.edge == tiling::Edge::bottom;
  const int levels = fine.level - coarse.level;
  const std::uint32_t within = (horizontal ? beyond.tile.x : beyond.tile.y) & ((1u << levels) - 1u);
  const double size = tiling::tileSize(levels);
  FinerEdge out{.finerEdge = edge,
                .edge = static_cast<std::uint8_t>(beyond.edge),
                .from = within * size,
                .to = (within + 1.0) * size};
  if (beyond.reversed) std::swap(out.from, out.to);
  return out;
}

void DrawnPatches::apply(const Selection& selection, const tiling::Tiling& tiling, Frame& frame) {
  std::swap(last_, now_);
  auto joined = selection.joined.begin();
  for (std::size_t i = 0; i < selection.drawn.size(); ++i) {
    const SelectedTile& tile = selection.drawn[i];
    finer_.clear();
    for (; joined != selection.joined.end() && joined->coarse == i; ++joined) {
      const SelectedTile& beside = selection.drawn[joined->fine];
      finer_.push_back(finerEdgeAlong(tiling, tile.id, beside.id, joined->edge));
      finer_.back().finer = meshOf(beside);
    }
    if (tile.over == nullptr && finer_.empty()) continue;
    frame.tiles[i].mesh = patch(meshOf(tile), tile.coarseEdges, finer_, frame.vertexGrid_m);
  }
  last_.clear();
}

std::shared_ptr<const TerrainMesh> DrawnPatches::patch(const MeshPart& base, std::uint8_t coarseEdges,
                                                       std::span<const FinerEdge> finer, double vertexGrid_m) {
  const auto numberOf = [](const MeshPart& part) { return static_cast<std::uint64_t>(part.quadrant + 1); };
  key_.assign({base.mesh->serial, numberOf(base), coarseEdges});
  for (const FinerEdge& each : finer) {
    const std::uint64_t edges = (std::uint64_t{each.edge} << 8u) | each.finerEdge;
    key_.insert(key_.end(), {each.finer.mesh->serial, numberOf(each.finer), edges,
                             std::bit_cast<std::uint64_t>(each.from), std::bit_cast<std::uint64_t>(each.to)});
  }
  if (auto before = last_.extract(key_)) return now_.insert(std::move(before)).position->second;
  auto& mesh = now_[key_];
  if (!mesh) mesh = patchMesh(base, coarseEdges, finer, vertexGrid_m);
  return mesh;
}

}  // namespace tellurion::scene
