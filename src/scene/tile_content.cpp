#include "scene/tile_content.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scene/relief.h"
#include "scene/texture_image.h"

namespace tellurion::scene {
namespace {

std::uint64_t bytesOf(const TextureImage& image) {
  return sizeof(TextureImage) + pixelBytes(image);
}

std::uint64_t bytesOf(const std::vector<LayerPicture>& pictures) {
  std::uint64_t bytes = 0;
  for (const LayerPicture& picture : pictures)
    bytes += sizeof(LayerPicture) + (picture.isOwn && picture.image ? bytesOf(*picture.image) : 0);
  return bytes;
}

std::uint64_t bytesOf(const TerrainMesh& mesh) {
  return sizeof(TerrainMesh) + mesh.vertices.size() * sizeof(TerrainVertex) +
         mesh.indices.size() * sizeof(std::uint16_t);
}

/// The longer of the two lines across the middle of a tile, metres.
double sideOf(const SurfaceGrid& grid) {
  const int middle = grid.cells / 2;
  const double across =
      geo::length(grid.positions[grid.index(grid.cells, middle)] - grid.positions[grid.index(0, middle)]);
  const double down =
      geo::length(grid.positions[grid.index(middle, grid.cells)] - grid.positions[grid.index(middle, 0)]);
  return std::max(across, down);
}

void addRelief(const ComposedGround& ground, const tiling::TileId& id, const TileContent* parent,
               const SurfaceGrid& grid, TileContent& content) {
  if (ground.level < 0) return;
  if (ground.level < id.level && parent != nullptr) {
    content.relief = parent->relief;
    content.reliefLevel = parent->reliefLevel;
    return;
  }
  content.relief = makeRelief(grid);
  content.reliefLevel = id.level;
  content.bytes += bytesOf(*content.relief);
}

/// The heights of the ground of the tile, of all below it, and of what it is drawn as on its way from its parent.
HeightRange drawnRange(const HeightRange& ground, const TerrainMesh& mesh) {
  HeightRange range = ground;
  for (const TerrainVertex& v : mesh.vertices) {
    const auto own_m = static_cast<double>(v.height_m);
    const double ofParent_m = own_m + v.toParent[3] * static_cast<double>(mesh.parentStep_m);
    range.low_m = std::min({range.low_m, own_m, ofParent_m});
    range.high_m = std::max({range.high_m, own_m, ofParent_m});
  }
  return range;
}

/// Boxes around the tiles below it that bend no further than heights reach anyway.
std::vector<OrientedBox> partsOf(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid,
                                 const tiling::TileId& id, const HeightRange& range) {
  constexpr int kLevel = 4;  // on Earth a box stands 13 km over the corners of the ground there
  std::vector<tiling::TileId> below;
  if (id.level < kLevel) below.push_back(id);
  while (!below.empty() && below.front().level < kLevel) {
    std::vector<tiling::TileId> children;
    for (const tiling::TileId& tile : below) {
      for (int quadrant = 0; quadrant < 4; ++quadrant)
        children.push_back(tile.child(quadrant));
    }
    below = std::move(children);
  }
  std::vector<OrientedBox> parts;
  for (const tiling::TileId& tile : below)
    parts.push_back(estimatedBox(tiling, ellipsoid, tile, range));
  return parts;
}

/// All but the pictures, which `pictures` makes.
template <class Pictures>
std::shared_ptr<TileContent> contentWith(const ContentMaker& maker, const tiling::TileId& id, const TileContent* parent,
                                         const Pictures& pictures) {
  auto content = std::make_shared<TileContent>();
  ComposedGround composed = maker.ground.compose(id, parent != nullptr ? &parent->heights : nullptr);
  const SurfaceGrid grid = surfaceGrid(maker.tiling, maker.ellipsoid, id, composed.heights);
  const TerrainMesh* from = parent != nullptr ? parent->mesh.get() : nullptr;
  const MadeMesh made = makeTerrainMesh(maker.tiling, maker.ellipsoid, grid, from, maker.regularMesh);
  content->mesh = made.mesh;
  content->box = grown(made.box, composed.error_m);
  content->error_m = id.level < kDeepestLevel ? made.error_m + composed.error_m : 0.0;
  content->side_m = sideOf(grid);
  content->spacing_m = id.level < kDeepestLevel ? content->side_m / grid.cells : 0.0;
  content->range = composed.range;
  content->childRange = composed.childRange;
  content->parts = partsOf(maker.tiling, maker.ellipsoid, id, drawnRange(composed.range, *content->mesh));
  addRelief(composed, id, parent, grid, *content);
  content->pictures = pictures();
  content->bytes += bytesOf(content->pictures);
  content->heights = std::move(composed.heights);
  content->bytes += sizeof(TileContent) + content->parts.size() * sizeof(OrientedBox) + bytesOf(*content->mesh) +
                    content->heights.samples.size() * sizeof(float);
  return content;
}

}  // namespace

std::shared_ptr<const TileContent> ContentMaker::make(const tiling::TileId& id, const TileContent* parent) const {
  return contentWith(*this, id, parent, [&] {
    return colours.pictures(id, parent != nullptr ? std::span(parent->pictures) : std::span<const LayerPicture>());
  });
}

std::shared_ptr<const TileContent> ContentMaker::makeStandIn(const tiling::TileId& id) const {
  auto content = contentWith(*this, id, nullptr, [&] { return colours.standIns(id); });
  content->isStandIn = true;
  return content;
}

std::shared_ptr<const TileContent> withPictures(const TileContent& content, std::vector<LayerPicture> pictures) {
  auto out = std::make_shared<TileContent>(content);
  out->bytes += bytesOf(pictures) - bytesOf(content.pictures);
  out->pictures = std::move(pictures);
  return out;
}

void ContentMaker::addNeeds(const tiling::TileId& id, std::vector<TileNeed>& needs) const {
  ground.addNeeds(id, needs);
  colours.addNeeds(id, needs);
}

double texelOf_m(const TileContent& content, const ColourLayers& layers, const std::vector<bool>& isVisible) {
  double largest_m = 0.0;
  for (std::size_t i = 0; i < content.pictures.size(); ++i) {
    if (content.pictures[i].finerBelow && isVisible[i])
      largest_m = std::max(largest_m, content.side_m / layers.pixels(i));
  }
  return largest_m;
}

TextureWindow windowIn(const tiling::TileId& id, int level, int cells, double border) {
  const double size = tiling::tileSize(id.level - level);
  const double texels = cells + 2.0 * border;
  const auto offset = [&](std::uint32_t index) {
    const std::uint32_t within = index & ((1u << (id.level - level)) - 1u);
    return static_cast<float>((border + within * size * cells) / texels);
  };
  const auto scale = static_cast<float>(size * cells / texels);
  return {.offset = geo::Vec2f(offset(id.x), offset(id.y)), .scale = geo::Vec2f(scale, scale)};
}

double heightIn(const GroundSamples& heights, double s, double t) {
  const int cells = heights.width - 3;
  const double col = std::clamp(s, 0.0, 1.0) * cells;
  const double row = std::clamp(t, 0.0, 1.0) * cells;
  const int c = std::min(static_cast<int>(col), cells - 1);
  const int r = std::min(static_cast<int>(row), cells - 1);
  const auto at = [&](int dc, int dr) { return static_cast<double>(heights.at(c + dc + 1, r + dr + 1)); };
  const double above = at(0, 0) + (at(1, 0) - at(0, 0)) * (col - c);
  const double below = at(0, 1) + (at(1, 1) - at(0, 1)) * (col - c);
  return above + (below - above) * (row - r);
}

OrientedBox estimatedBox(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const tiling::TileId& id,
                         const HeightRange& range) {
  constexpr int kSteps = 8;
  std::vector<geo::BodyPosition> points;
  points.reserve(2 * (kSteps + 1) * (kSteps + 1));
  geo::Direction middle;
  geo::Vec3 across{0.0, 0.0, 0.0};
  for (int row = 0; row <= kSteps; ++row) {
    for (int col = 0; col <= kSteps; ++col) {
      const geo::Direction d = tiling.direction(tiling::rootPointIn(id, double(col) / kSteps, double(row) / kSteps));
      points.push_back(ellipsoid.bodyFromDirection(d, range.low_m));
      points.push_back(ellipsoid.bodyFromDirection(d, range.high_m));
      if (row == kSteps / 2 && col == kSteps / 2) middle = d;
      if (row == kSteps / 2 && col == 0) across -= d.n;
      if (row == kSteps / 2 && col == kSteps) across += d.n;
    }
  }
  // Between two points the ground bulges by the sagitta of the angle between them; a diagonal is the longest.
  const double angle = tiling.metrics(id.level).largestEdge.radians() / kSteps * std::sqrt(2.0);
  const double bulge =
      (ellipsoid.semiMajorAxis_m() + std::abs(range.high_m)) / (1.0 - ellipsoid.flattening()) * (angle * angle / 8.0);
  return boxAround(points, across, middle.n, bulge);
}

}  // namespace tellurion::scene
