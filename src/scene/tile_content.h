#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "scene/colour_layers.h"
#include "scene/ground_layers.h"
#include "scene/terrain_mesh.h"

namespace tellurion::scene {

/// No tile is made deeper than this: samples 2 mm apart on Earth.
inline constexpr int kDeepestLevel = 26;

/// All that is needed to draw a tile and to plan beyond it. Immutable once made; shared by workers, globe and frame.
struct TileContent {
  std::shared_ptr<const TerrainMesh> mesh;
  std::vector<LayerPicture> pictures;          ///< a layer each, bottom first
  std::shared_ptr<const TextureImage> relief;  ///< its own or an ancestor's
  int reliefLevel = 0;
  GroundSamples heights;
  OrientedBox box;                 ///< holds the ground of the tile and of all below it
  std::vector<OrientedBox> parts;  ///< TileFacts::parts of ground that is not exaggerated
  HeightRange range;               ///< of the ground of the tile and of all below it
  std::array<HeightRange, 4> childRange;
  double error_m = 0.0;    ///< as TileFacts has it
  bool isStandIn = false;  ///< likewise
  double side_m = 0.0;
  double spacing_m = 0.0;
  std::uint64_t bytes = 0;  ///< of what is its own
};

/// The same tile with other pictures, a layer each.
std::shared_ptr<const TileContent> withPictures(const TileContent& content, std::vector<LayerPicture> pictures);

/// TileFacts::texel_m of a tile, a flag each for the layers in sight: those that have finer pictures below count.
double texelOf_m(const TileContent& content, const ColourLayers& layers, const std::vector<bool>& isVisible);

/// Everything that makes contents. Immutable, thread-safe.
struct ContentMaker {
  tiling::Tiling tiling;
  geo::Ellipsoid ellipsoid;
  GroundLayers ground;
  ColourLayers colours;
  bool regularMesh = false;  ///< as GlobeOptions has it

  /// Blocks while sources do. parent: of the tile over it; null for roots.
  std::shared_ptr<const TileContent> make(const tiling::TileId& id, const TileContent* parent) const;
  /// Of a root: with the pictures that are here.
  std::shared_ptr<const TileContent> makeStandIn(const tiling::TileId& id) const;
  bool isBare() const { return ground.isBare() && colours.isBare(); }  ///< no layer takes part
  /// What make() may load of sources that tell what they store, so that it can be prepared; the same tile may be named
  /// twice. Never blocks. What any first make() loads besides are all roots of all layers.
  void addNeeds(const tiling::TileId& id, std::vector<TileNeed>& needs) const;
};

/// Where tile `id` finds itself in a texture that belongs to its ancestor at `level`: `cells` wide without its border,
/// whose texel centres lie `border` texels inside its edge (colour: 1, a gutter; relief: 0.5, vertex-registered).
TextureWindow windowIn(const tiling::TileId& id, int level, int cells, double border);

/// A box that surely holds the ground of a tile that has not been made, from the range of its heights.
OrientedBox estimatedBox(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const tiling::TileId& id,
                         const HeightRange& range);

/// Height at a place of a tile (s, t in 0..1), bilinear.
double heightIn(const GroundSamples& heights, double s, double t);

}  // namespace tellurion::scene
