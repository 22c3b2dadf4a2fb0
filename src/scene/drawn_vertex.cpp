#include "scene/drawn_vertex.h"

namespace tellurion::scene {

geo::BodyPosition drawnPosition(const DrawnTile& tile, const TerrainVertex& vertex, const Frame& frame) {
  const auto vec = [](const auto& v) { return geo::Vec3(v[0], v[1], v[2]); };
  const float s = static_cast<float>(vertex.s) / kPlaceUnits;
  const float t = static_cast<float>(vertex.t) / kPlaceUnits;
  const float above = tile.morph[0] * (1.0f - s) + tile.morph[1] * s;
  const float below = tile.morph[2] * (1.0f - s) + tile.morph[3] * s;
  const float back = 1.0f - (above * (1.0f - t) + below * t);
  const double step = static_cast<double>(back) * static_cast<double>(tile.mesh->parentStep_m);
  const geo::Vec3 exact =
      tile.mesh->origin.m + geo::Vec3(vertex.position_tile) + vec(vertex.fine_tile) * frame.vertexGrid_m;
  const double lift = (static_cast<double>(vertex.height_m) + vertex.toParent[3] * step) * (frame.exaggeration - 1.0);
  return {exact + (vec(vertex.toParent) * step + vec(vertex.up_body) * (lift / 32767.0))};
}

}  // namespace tellurion::scene
