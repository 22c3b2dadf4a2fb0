#include "tiling/tiling.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "tiling/faces.h"
#include "tiling/morton.h"

namespace tellurion::tiling {

namespace {

constexpr std::array<std::string_view, 3> kNames{"geographic", "cube", "healpix"};
constexpr double kPad = 2e-15;        // radians by which caps are wider than measured, against rounding
constexpr double kBoundsPad = 1e-14;  // and bounds

}  // namespace

geo::GeoRect paddedBounds(double south, double north, double west, double east) {
  return {.south = geo::Angle::radians(std::max(south - kBoundsPad, -geo::kPi / 2.0)),
          .north = geo::Angle::radians(std::min(north + kBoundsPad, geo::kPi / 2.0)),
          .west = geo::wrappedLongitude(geo::Angle::radians(west - kBoundsPad)),
          .width = geo::Angle::radians(east - west + 2.0 * kBoundsPad)};
}

bool TileId::isDescendantOf(const TileId& a) const {
  return level >= a.level && ancestor(a.level) == a;
}

std::size_t TileIdHash::operator()(const TileId& id) const noexcept {
  std::uint64_t h = (std::uint64_t{id.level} << 58u) ^ (std::uint64_t{id.root} << 54u) ^ interleaved(id.x, id.y);
  h = (h ^ (h >> 32u)) * 0x9E3779B97F4A7C15u;
  return static_cast<std::size_t>(h ^ (h >> 29u));
}

std::optional<Scheme> schemeByName(std::string_view name) {
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<Scheme>(found - kNames.begin());
}

std::string_view nameOf(Scheme scheme) {
  return kNames[static_cast<std::size_t>(scheme)];
}

int Tiling::rootCount() const {
  switch (scheme_) {
    case Scheme::geographic:
    case Scheme::cube:
      return kFaces;
    case Scheme::healpix:
      break;
  }
  return healpix::kRoots;
}

geo::Direction Tiling::direction(const RootPoint& p) const {
  switch (scheme_) {
    case Scheme::geographic:
      return geographic::direction(p);
    case Scheme::cube:
      return cube::direction(p);
    case Scheme::healpix:
      break;
  }
  return healpix::direction(p);
}

std::optional<LonLat> Tiling::lonLat(const RootPoint& p) const {
  if (scheme_ != Scheme::geographic) return std::nullopt;
  return geographic::lonLat(p);
}

RootPoint Tiling::rootPoint(const geo::Direction& d) const {
  switch (scheme_) {
    case Scheme::geographic:
      return geographic::rootPoint(d);
    case Scheme::cube:
      return cube::rootPoint(d);
    case Scheme::healpix:
      break;
  }
  return healpix::rootPoint(d);
}

TileId Tiling::tileAt(const geo::Direction& d, int level) const {
  assert(level >= 0 && level <= kMaxLevel);
  const RootPoint p = rootPoint(d);
  return {static_cast<std::uint8_t>(level), static_cast<std::uint8_t>(p.root), tileCoordinate(p.u, level),
          tileCoordinate(p.v, level)};
}

geo::GeoRect Tiling::bounds(const TileId& id) const {
  switch (scheme_) {
    case Scheme::geographic:
      return geographic::bounds(id);
    case Scheme::cube:
      return cube::bounds(id);
    case Scheme::healpix:
      break;
  }
  return healpix::bounds(id);
}

Cap Tiling::cap(const TileId& id) const {
  Cap cap{direction(rootPointIn(id, 0.5, 0.5)), {}};
  for (const double s : {0.0, 1.0}) {
    for (const double t : {0.0, 1.0}) {
      cap.radius = std::max(cap.radius, geo::angleBetween(cap.centre, direction(rootPointIn(id, s, t))));
    }
  }
  cap.radius = cap.radius + geo::Angle::radians(kPad);
  return cap;
}

LevelMetrics Tiling::metrics(int level) const {
  assert(level >= 0 && level <= kMaxLevel);
  Scale scale{};
  switch (scheme_) {
    case Scheme::geographic:
      scale = geographic::scale();
      break;
    case Scheme::cube:
      scale = cube::scale();
      break;
    case Scheme::healpix:
      scale = healpix::scale();
      break;
  }
  const double size = tileSize(level);
  const double mean = std::sqrt(4.0 * geo::kPi / rootCount());
  return {.smallestEdge = geo::Angle::radians(scale.smallest * size),
          .meanEdge = geo::Angle::radians(mean * size),
          .largestEdge = geo::Angle::radians(scale.largest * size)};
}

double Tiling::area(const TileId& id) const {
  switch (scheme_) {
    case Scheme::geographic:
      return geographic::area(id);
    case Scheme::cube:
      return cube::area(id);
    case Scheme::healpix:
      break;
  }
  return healpix::area(id);
}

}  // namespace tellurion::tiling
