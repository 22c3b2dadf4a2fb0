#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "geo/geo_rect.h"

namespace tellurion::tiling {

/// The deepest level: a tile coordinate then fits 29 bits and a root's sample coordinates are exact in a double.
inline constexpr int kMaxLevel = 29;

/// One square of the forest. Level 0 is a root. x counts columns to the right, y rows downwards, from 0 to 2^level - 1,
/// as seen from outside the body with the root's top edge up.
struct TileId {
  std::uint8_t level = 0;
  std::uint8_t root = 0;
  std::uint32_t x = 0;
  std::uint32_t y = 0;

  auto operator<=>(const TileId&) const = default;

  TileId parent() const { return {static_cast<std::uint8_t>(level - 1), root, x >> 1, y >> 1}; }
  /// quadrant: 0 top left, 1 top right, 2 bottom left, 3 bottom right.
  TileId child(int quadrant) const {
    const auto q = static_cast<std::uint32_t>(quadrant);
    return {static_cast<std::uint8_t>(level + 1), root, 2 * x + (q & 1u), 2 * y + (q >> 1u)};
  }
  int quadrant() const { return static_cast<int>((x & 1u) | ((y & 1u) << 1u)); }
  TileId ancestor(int ancestorLevel) const {  ///< ancestorLevel <= level
    const int up = level - ancestorLevel;
    return {static_cast<std::uint8_t>(ancestorLevel), root, x >> up, y >> up};
  }
  bool isDescendantOf(const TileId& a) const;  ///< true also for a itself
};

struct TileIdHash {
  std::size_t operator()(const TileId& id) const noexcept;
};

/// A place on a root's square: u to the right, v down, both in [0, 1].
struct RootPoint {
  int root = 0;
  double u = 0.0;
  double v = 0.0;
};

enum class Edge : std::uint8_t { top, right, bottom, left };
enum class Corner : std::uint8_t { topLeft, topRight, bottomRight, bottomLeft };
inline constexpr std::array kEdges{Edge::top, Edge::right, Edge::bottom, Edge::left};
inline constexpr std::array kCorners{Corner::topLeft, Corner::topRight, Corner::bottomRight, Corner::bottomLeft};

struct EdgeNeighbour {
  TileId tile;
  Edge edge = Edge::top;  ///< the neighbour's edge that is shared
  bool reversed = false;  ///< the two run along the shared edge in opposite senses (top and bottom run with u, left and
                          ///< right with v)
};

/// Angles on the unit sphere of directions. Smallest and largest hold for every tile edge of the level, measured along
/// it; the largest, divided by the samples a side, for every sample spacing too.
struct LevelMetrics {
  geo::Angle smallestEdge;
  geo::Angle meanEdge;  ///< square root of the mean tile area
  geo::Angle largestEdge;
};

/// A cone of directions that holds a tile.
struct Cap {
  geo::Direction centre;
  geo::Angle radius;
};

enum class Scheme : std::uint8_t { geographic, cube, healpix };
std::optional<Scheme> schemeByName(std::string_view name);
std::string_view nameOf(Scheme scheme);

/// Degrees: longitude in (-180, 180], 0 at a pole.
struct LonLat {
  double longitude_degrees = 0.0;
  double latitude_degrees = 0.0;
};

/// How the surface is cut: one interface, three schemes (docs/tilings.md). Speaks geo::Direction, so it knows no body.
/// Immutable, thread-safe, a value.
class Tiling {
 public:
  explicit Tiling(Scheme scheme) : scheme_(scheme) {}
  Scheme scheme() const { return scheme_; }
  int rootCount() const;

  /// Bit-identical for the same place reached through different roots, wherever u and v are multiples of 2^-40.
  geo::Direction direction(const RootPoint& p) const;
  /// The same place as longitude and latitude, where the scheme is made of meridians and parallels (geographic); nothing
  /// for the others. Bit-identical through different roots too, and on roots 0 to 3 the longitude is a function of u
  /// alone and the latitude of v.
  std::optional<LonLat> lonLat(const RootPoint& p) const;
  /// The inverse, for a unit vector: back within 2e-15 rad, u and v always in [0, 1]. A place on a border belongs to
  /// the lowest root (geographic and healpix: within 2e-15 of it). NaN gives root 0 or any, with NaN in u or v.
  RootPoint rootPoint(const geo::Direction& d) const;
  TileId tileAt(const geo::Direction& d, int level) const;  ///< always a tile that there is, for NaN too

  /// Brings a point that lies across one edge of its root (u or v outside [0, 1] by less than 1, not both) to the root
  /// where it really is, exactly for dyadic coordinates. Points inside come back as they are. Nothing when both are
  /// outside and no single root owns the place (around corners where three roots meet).
  std::optional<RootPoint> wrapped(const RootPoint& p) const;

  EdgeNeighbour edgeNeighbour(const TileId& id, Edge edge) const;
  /// The tile of the same level that touches a corner of `id`, besides `id` itself and its two edge neighbours there:
  /// one where four tiles meet, none where three do.
  std::optional<TileId> cornerNeighbour(const TileId& id, Corner corner) const;

  geo::GeoRect bounds(const TileId& id) const;  ///< holds the tile; tight to 1e-9 degrees where no pole is inside
  Cap cap(const TileId& id) const;              ///< holds the tile
  LevelMetrics metrics(int level) const;

  /// Area of a tile on the unit sphere, steradians.
  double area(const TileId& id) const;

 private:
  Scheme scheme_;
};

/// Of a tile's side, in u and v.
inline double tileSize(int level) {
  return 1.0 / static_cast<double>(std::int64_t{1} << level);
}
/// Place of a tile-local coordinate (s, t in [0, 1], t down) on its root.
inline RootPoint rootPointIn(const TileId& id, double s, double t) {
  const double size = tileSize(id.level);
  return {id.root, (static_cast<double>(id.x) + s) * size, (static_cast<double>(id.y) + t) * size};
}

/// The HEALPix NESTED pixel of order `level` that this tile of the healpix scheme is, and back.
std::uint64_t healpixNested(const TileId& id);
TileId tileFromHealpixNested(int order, std::uint64_t pixel);

}  // namespace tellurion::tiling
