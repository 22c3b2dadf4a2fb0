#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "geo/ellipsoid.h"
#include "scene/camera.h"
#include "scene/corner_lattice.h"
#include "scene/cut_memory.h"
#include "scene/oriented_box.h"
#include "scene/tiles_around.h"
#include "scene/view_leeway.h"
#include "tiling/tiling.h"

namespace tellurion::scene {

struct CutOptions {
  double tolerance_px = 1.0;       ///< geometric error on screen that needs no refinement, > 0
  double texelTolerance_px = 1.0;  ///< side of a texel on screen that needs no finer picture, > 0
  /// Spacing of a tile's samples on screen that needs no refinement, whatever the error; > 0. One sample or more for
  /// each square of that side.
  double maxSpacing_px = std::numeric_limits<double>::infinity();
  /// What the leaves of the cut that may be seen may be: the worst are refined first, as far as this goes. Their number
  /// (a picture of 3840 x 2160 needs some 2200 in mountains, docs/selection.md, so this is for what was asked for by
  /// mistake), their triangles, and the bytes of their meshes and pictures.
  int maxTiles = 4000;
  std::int64_t maxTriangles = std::numeric_limits<std::int64_t>::max();
  std::uint64_t maxBytes = std::numeric_limits<std::uint64_t>::max();
  /// Tiles leave their parents' surfaces as the eye comes near, not at once. Without, they are their own always.
  bool morph = true;
  /// Samples of tiles are samples of their children. Else tiles lie on their parents' surfaces where they meet coarser
  /// ones, without morphing too: only there is the ground of both the same.
  bool isNested = true;
  /// Where the scene's clock stands. With it, what would jump (late data above all) fades in over fade_s seconds a
  /// level, faster where it is far off, from what was drawn at the last different time; until then a frame is not
  /// within the tolerance and not complete. Without, nothing is remembered, and a frame depends on its view alone.
  std::optional<double> time_s;
  double fade_s = 0.3;  ///< > 0
  /// With a clock, and an eye that moves: what the view a second ahead will want is asked for too, last of all.
  bool prefetch = true;
  /// With morphing: how far beyond the sides of the picture the ground is kept as fine as in it, so that it has left
  /// its parents' surfaces when a moving eye gets to see it; a share of half the picture. Infinite: all around the eye.
  /// Then all pictures from one eye choose the same tiles, for the several of a dome, and each loads what all need.
  double margin = 0.15;  ///< >= 0
  /// With a clock: the most that drawing the frame may copy to the GPU (TileFacts::copy_bytes), but for one split that
  /// alone is more and for what cannot wait: roots, and what comes into the picture beside ground that is drawn finer.
  std::uint64_t copies_bytes = std::uint64_t{8} << 20;

  friend bool operator==(const CutOptions&, const CutOptions&) = default;
};

/// What the cut knows of a tile, loaded or not.
struct TileFacts {
  TileCorners corners;  ///< known from the start
  TilesAround around;   ///< likewise
  /// Where it bends far away from under one box: smaller ones that hold all of that together, and all that is drawn.
  /// Empty: there are none.
  std::span<const OrientedBox> parts;
  std::size_t partInSight = 0;  ///< where select() looks first; of any value, it changes nothing but the time it takes
  /// Holds its ground and that of every tile below it. Must not depend on whether the tile is loaded: it decides which
  /// tiles are, so that a complete cut is the same whatever was loaded before.
  OrientedBox box;
  OrientedBox tightBox;  ///< likewise, but known once it is drawable; distances are measured to it
  /// The largest distance in space between the ground as drawn from this tile and the finest ground there is, curvature
  /// and mesh tolerance included; 0 when no refinement makes it better. Known once it is drawable.
  double error_m = 0.0;
  /// The side of one texel on the ground when there are finer pictures below, else 0.
  double texel_m = 0.0;
  /// The spacing of its samples, whatever its mesh makes of them; 0 on the deepest level. Known once it is drawable.
  double spacing_m = 0.0;
  std::int64_t triangles = 0;  ///< of its mesh, no coarser neighbours
  std::uint64_t bytes = 0;     ///< of its mesh and pictures
  /// That must be copied to the GPU to draw it; 0 when all of it is there. A picture of an ancestor counts in part.
  std::uint64_t copy_bytes = 0;
  bool drawable = false;  ///< loaded, with all that is needed to draw it
  /// Of a root: what is drawable lacks pictures that are still to come. It is not split before they have.
  bool isStandIn = false;
};

/// Where select() finds its facts.
class TileTree {
 public:
  virtual ~TileTree() = default;
  /// Never null. Pointers stay valid while select() runs.
  virtual TileFacts* root(int root) = 0;
  /// By quadrant, of a drawable tile.
  virtual std::array<TileFacts*, 4> children(const tiling::TileId& id, TileFacts& facts) = 0;
};

struct SelectedTile {
  tiling::TileId id;
  TileFacts* facts = nullptr;    ///< as TileTree gave it
  std::uint8_t coarseEdges = 0;  ///< bit e: the neighbour across tiling::Edge e is one level coarser
  std::array<float, 4> morph{1.0f, 1.0f, 1.0f, 1.0f};  ///< as DrawnTile has it
  double error_px = 0.0;                               ///< the most that what is drawn of it is off, from the eye
  TileFacts* over = nullptr;  ///< the tile over it, where that quarter of its mesh is drawn instead; else null
  bool waits = false;         ///< finer ones are here, and take its place once it has left its parent's surface
};

/// Where a drawn tile is next to one that is finer than its mesh has an edge for: the vertices that the finer one's
/// coarse edge has there have to be its vertices too.
struct JoinedEdge {
  std::uint32_t coarse = 0;  ///< of Selection::drawn
  std::uint32_t fine = 0;    ///< likewise
  std::uint8_t edge = 0;     ///< tiling::Edge of the finer one
};

struct WantedTile {
  tiling::TileId id;
  /// What it adds to the picture; larger is more urgent: the share of the picture that the tile covers for whose sake
  /// it is wanted.
  double priority = 0.0;
};

/// A cut through the forest: drawn are its leaves that may be seen.
struct Selection {
  std::vector<SelectedTile> drawn;
  std::vector<JoinedEdge> joined;       ///< with a history only, where tiles come into the picture that are not here
  std::vector<SelectedTile> soon;       ///< drawn if they were in the picture: those in the margin
  std::uint64_t spareCopies_bytes = 0;  ///< what drawing leaves of CutOptions::copies_bytes
  std::vector<WantedTile> wanted;       ///< not loaded yet, each once, most urgent first
  int visited = 0;
  int culledFrustum = 0;
  int culledHorizon = 0;
  int heldBack = 0;                ///< splits that wait for a later frame, since CutOptions::copies_bytes is spent
  std::vector<double> rootShares;  ///< of the picture, a root each, > 0 if it may be seen
  bool cappedByBudget = false;     ///< a budget left something coarser than the tolerance
  bool morphing = false;           ///< some tile is still on its way to where it should be: with a history only
  float fading = 0.0f;             ///< how many whole ways from 0 to 1 until all morph values are where they should be
  double nearest_m = 0.0;          ///< the distance of the nearest drawn tile; infinite: there is none
  double maxScreenError_px = 0.0;  ///< of what is drawn
};

void clear(Selection& selection);  ///< but for its memory

struct CutHistory {
  const CutMemory* last = nullptr;  ///< not null
  CutMemory* now = nullptr;         ///< not null; is overwritten
  double step = 1.0;                ///< the most that a morph value (0..1) may have changed since
  Leeway leeway = {};               ///< for all of these views besides
};

/// Chooses what to draw (docs/selection.md). From the roots down, worst first, a tile is replaced by its four children
/// while
///  - its error as an angle from the eye is larger than the tolerance, or
///  - its texels are larger than CutOptions::texelTolerance_px and there are finer ones, or
///  - its samples are further apart than CutOptions::maxSpacing_px,
/// all taken at the point of its box nearest to the eye, whatever the eye looks at. A tile is replaced only when those
/// of its children that may be seen are drawable, and when every drawn neighbour ends up at most one level apart over
/// edges and corners (forced splits, across roots too). With morphing, those next to a tile that needs its children get
/// theirs too. What is drawn already is split as it was; what else the copies allow is split worst first. A pure
/// function of its arguments, `tree` included: nothing is remembered but in `history`, where it is
/// given: then a tile that was drawn is split only once it has wholly left its parent's surface, and four children
/// become their parent only once they are back on its; and what was drawn finer stays so beside what comes into view
/// and is not loaded: parts of parents' meshes (SelectedTile::over), and neighbours more than one level apart, that are
/// then `joined`. With a leeway it is right for each of those views: nothing is left out that one of them may see, and
/// errors are what they are from the nearest eye at most, now and until all morph values are where they should be.
/// Where ground is not nested all is held ready for an eye that turns instead: all four children are waited for, and
/// all neighbours are at most one level apart. occluderDepth_m: how far below the ellipsoid the deepest ground of the
/// body lies, >= 0 (horizon culling hides nothing behind ground that may not be there).
Selection select(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const View& view,
                 const CutOptions& options, double occluderDepth_m, TileTree& tree,
                 const CutHistory* history = nullptr);

/// The same, frame after frame: keeps the memory of its work, so that a view that needs nothing new allocates nothing.
/// One thread only.
class Selector {
 public:
  Selector(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid);
  ~Selector();
  Selector(Selector&&) noexcept;
  Selector& operator=(Selector&&) noexcept;

  /// Valid until the next call.
  const Selection& select(const View& view, const CutOptions& options, double occluderDepth_m, TileTree& tree,
                          const CutHistory* history = nullptr);
  /// The same selection, made with a history, its morph values by so many whole ways further than they were then; the
  /// memory too.
  const Selection& goOn(double steps, CutMemory& memory);

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

/// An angle in pixels from a length in metres seen across at a distance in metres; distances under half a metre count
/// as that. pixelAngle: radians of a pixel in the middle of the picture.
inline double pixelsAcross(double length_m, double distance_m, double pixelAngle) {
  constexpr double kNearest_m = 0.5;
  return length_m / (std::max(distance_m, kNearest_m) * pixelAngle);
}

}  // namespace tellurion::scene
