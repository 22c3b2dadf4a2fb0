#include <cmath>

#include "scene/frame.h"
#include "scene/view_frustum.h"

namespace tellurion::scene {
namespace {

bool mayShow(const ViewFrustum& frustum, const TerrainMesh& mesh, double exaggeration) {
  if (!std::isfinite(mesh.reach_m)) return true;
  const double lifted_m = std::abs(exaggeration - 1.0) * static_cast<double>(mesh.highest_m);
  return frustum.mayShow(mesh.origin, static_cast<double>(mesh.reach_m) + lifted_m);
}

}  // namespace

Frame partOf(const Frame& frame, const View& view) {
  Frame part{.view = view,
             .light = frame.light,
             .air = frame.air,
             .sky = frame.sky,
             .ellipsoid = frame.ellipsoid,
             .background = frame.background,
             .looks = frame.looks,
             .complete = frame.complete,
             .morphing = frame.morphing,
             .exaggeration = frame.exaggeration,
             .vertexGrid_m = frame.vertexGrid_m,
             .statistics = frame.statistics,
             .debug = frame.debug};
  const ViewFrustum frustum(view);
  for (const DrawnTile& tile : frame.tiles) {
    if (!mayShow(frustum, *tile.mesh, frame.exaggeration)) continue;
    part.tiles.push_back(tile);
    part.tiles.back().firstPicture = static_cast<std::uint32_t>(part.pictures.size());
    const auto first = frame.pictures.begin() + tile.firstPicture;
    part.pictures.insert(part.pictures.end(), first, first + tile.pictureCount);
  }
  return part;
}

}  // namespace tellurion::scene
