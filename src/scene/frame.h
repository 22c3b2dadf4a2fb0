#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "geo/ellipsoid.h"
#include "raster/block_compression.h"
#include "raster/raster.h"
#include "scene/atmosphere.h"
#include "scene/camera.h"
#include "scene/debug_view.h"
#include "scene/layer_look.h"
#include "scene/sky.h"
#include "tiling/tiling.h"

namespace tellurion::scene {

/// Tile-local places of vertices run from 0 to this. A power of two, so that shares of it are exact.
inline constexpr int kPlaceUnits = 32768;

/// 40 bytes, as the vertex shader reads it. Its place is exact: origin + position_tile + fine_tile *
/// Frame::vertexGrid_m, all multiples of that grid, so tiles that share a vertex, whatever their levels, have the same
/// bits in body coordinates. `toParent` leads from there to the surface that the parent's mesh draws at the same (s,
/// t); it too is the same in all tiles of the level that share the vertex. See drawn_vertex.h for what is drawn.
struct TerrainVertex {
  geo::Vec3f position_tile;                 ///< metres from the mesh's origin, body axes
  std::array<std::int16_t, 3> up_body{};    ///< the ellipsoid's normal, signed normalised 16 bit
  std::uint16_t s = 0;                      ///< tile-local place, 0..kPlaceUnits for 0..1
  std::array<std::int16_t, 3> fine_tile{};  ///< what single precision lost, in steps of the grid
  std::uint16_t t = 0;
  std::array<std::int16_t, 4> toParent{};  ///< x, y, z in body axes, and the difference in height; in parentStep_m
  float height_m = 0.0f;                   ///< above the ellipsoid
};
static_assert(sizeof(TerrainVertex) == 40);

struct IndexRange {
  std::uint32_t first = 0;
  std::uint32_t count = 0;
};

/// A tile's triangles, made once on a worker. Counter-clockwise from outside. Immutable once made.
/// The triangles that touch an edge exist twice: with the edge's own vertices (fine), and with those that a neighbour
/// one level coarser has there. Drawn are the interior and, for each edge, one of the two.
struct TerrainMesh {
  std::uint64_t serial = 0;  ///< unique in the process; what GPU copies are keyed by
  geo::BodyPosition
      origin;  ///< on the displaced ground near the tile's centre, a multiple of 2^-10 m and of the vertex grid
  float parentStep_m = 0.0f;  ///< the unit of TerrainVertex::toParent: a power of two, of the level alone
  std::vector<TerrainVertex> vertices;
  std::vector<std::uint16_t> indices;
  IndexRange interior;
  std::array<IndexRange, 4> fineEdge;  ///< indexed by tiling::Edge
  std::array<IndexRange, 4> coarseEdge;
  // All normals of the ellipsoid over the tile lie within upReach of this one, as lengths of unit vectors' differences.
  geo::Vec3f middleUp_body{0.0f};
  float upReach = 2.0f;
  /// Metres from the origin within which all of it lies, on its parent's surface too, drawn without exaggeration; and
  /// the largest height above or below the ellipsoid. Infinite: not known.
  float reach_m = std::numeric_limits<float>::infinity();
  float highest_m = 0.0f;
};

/// A picture for the GPU with its mip levels, each half the one before (rounded down), made on a worker. Immutable once
/// made. Colours are sRGB of light that is multiplied with the coverage a; night lights are black, and a their
/// strength.
struct TextureImage {
  std::uint64_t serial = 0;
  bool isOpaque = false;  ///< covered all over
  // Of these two one is empty.
  std::vector<raster::Raster<raster::Rgba8>> mips;
  std::vector<raster::BlockPicture> blocks;  ///< compressed levels, of one format
};

/// Where a tile finds itself in a texture: texture coordinate = offset + scale * (s, t).
struct TextureWindow {
  geo::Vec2f offset{0.0f, 0.0f};
  geo::Vec2f scale{1.0f, 1.0f};
};

/// An imagery layer on a tile, (size + 2)^2 with a gutter.
struct DrawnPicture {
  std::shared_ptr<const TextureImage> image;  ///< not null
  TextureWindow window;
  std::uint32_t layer = 0;  ///< index into Frame::looks
};

struct DrawnTile {
  tiling::TileId id;
  std::shared_ptr<const TerrainMesh> mesh;
  std::uint8_t coarseEdges = 0;  ///< bit e: the neighbour across tiling::Edge e is one level coarser
  /// How far the tile has left its parent's surface at its corners, quadrants' order: 0 it is that, 1 it is its own.
  /// Between them bilinear. Tiles of a level that share a corner have the same number there.
  std::array<float, 4> morph{1.0f, 1.0f, 1.0f, 1.0f};
  // Its pictures, bottom first: a range of Frame::pictures. None: plain ground.
  std::uint32_t firstPicture = 0;
  std::uint32_t pictureCount = 0;
  /// Relief, (cells + 1)^2: shading normal minus the ellipsoid's, body axes, in x, y, z the whole number nearest to
  /// 128 + 127 v, so that 128 is exactly none: v = (texel - 128) / 127. May be null: smooth ground.
  std::shared_ptr<const TextureImage> relief;
  TextureWindow reliefWindow;
  double error_px = 0.0;  ///< screen error in the view of the cut
};

struct Light {
  bool enabled = true;
  geo::Vec3 toSun_body{1.0, 0.0, 0.0};  ///< unit
  double ambient = 0.03;                ///< share of full light, linear, where the sun does not reach
};

struct FrameStatistics {
  double update_ms = 0.0;
  int cutAge = 0;  ///< updates since the cut was made; 0: in this one. The next figures are from then
  int tilesVisited = 0;
  int tilesCulledFrustum = 0;
  int tilesCulledHorizon = 0;
  int tilesWanted = 0;             ///< finer ones that are not there yet, and pictures of the clock's time step
  int tilesHeldBack = 0;           ///< finer ones that are there, but wait for CutOptions::copies_bytes of later frames
  bool cappedByBudget = false;     ///< a budget of CutOptions left something coarser than the tolerance
  double maxScreenError_px = 0.0;  ///< of what is drawn
  std::array<int, 32> tilesALevel{};
  std::uint64_t cpuCacheBytes = 0;  ///< when the update ends
  /// Of those, beyond GlobeOptions::cpuCacheBytes: in use by the cut, or by looking ahead.
  std::uint64_t cpuCacheOver_bytes = 0;
  int layersComing = 0;  ///< of the scene, not part of the picture yet: their source, or that of the clock's step,
                         ///< is not open or not here
  std::uint64_t requests = 0;  ///< since the globe was opened: to servers, and tiles read from this machine
  std::uint64_t failedRequests = 0;
  std::uint64_t failures = 0;  ///< what could not be loaded and is not tried again
};

/// The colour of ground that no layer of a scene with imagery covers, sRGB; without imagery ground is neutral grey.
inline constexpr raster::Rgba8 kPlainGround{150, 145, 138, 255};

/// Exactly what to draw: plain data, the product of this room.
struct Frame {
  View view;
  Light light;
  Air air;  ///< drawn where light is enabled too
  Sky sky;
  geo::Ellipsoid ellipsoid{6378137.0, 1.0 / 298.257223563};  ///< of the body, around which the air is
  std::array<float, 3> background{0.0f, 0.0f, 0.0f};         ///< sRGB, 0..1
  std::vector<DrawnTile> tiles;
  std::vector<DrawnPicture> pictures;  ///< of the tiles, and of those in `soon`, which follow each other
  std::vector<LayerLook> looks;        ///< a layer each, as DrawnPicture::layer counts them
  std::vector<DrawnTile> soon;  ///< just outside the picture: not drawn, but to be kept on the GPU if there is room
  std::uint64_t soonCopies_bytes = 0;  ///< the most that may be copied of those now
  /// Nothing finer is wanted: all layers take part, all has come, none waits for its copy, all has faded in, and the
  /// budget of tiles was enough.
  bool complete = false;
  bool morphing = false;  ///< with time the picture changes on its own: what has come is still fading in
  /// A later update of the same view draws something else, though nothing more has come: this one fades in, waits for
  /// copies, or has a cut that was chosen for an eye that moves on. Who draws only when something has changed draws
  /// once more; in the end this is false.
  bool unsettled = false;
  double exaggeration = 1.0;      ///< heights above the ellipsoid are drawn this many times as high, >= 0
  double vertexGrid_m = 0x1p-15;  ///< a power of two, the same for all meshes of a body (terrain_mesh.h)
  FrameStatistics statistics;
  DebugOverlay debug;  ///< nothing unless asked for
};

/// The same ground in another picture from nearly the same eye: what of the frame's tiles may be seen in `view`, at the
/// same levels and with the same morphs. For pictures that are drawn in parts, or in several directions.
Frame partOf(const Frame& frame, const View& view);

}  // namespace tellurion::scene
