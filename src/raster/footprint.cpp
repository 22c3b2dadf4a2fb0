#include "raster/footprint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace tellurion::raster {
namespace {

using geo::Angle;

/// Points along a line in pixel coordinates, both ends included.
std::vector<double> steps(double from, double to, int count) {
  std::vector<double> values(static_cast<std::size_t>(count) + 1);
  for (int i = 0; i <= count; ++i)
    values[static_cast<std::size_t>(i)] = from + (to - from) * i / count;
  return values;
}

/// Longitudes and latitudes, in degrees, of a closed lattice over the raster; the outline is its border.
struct Lattice {
  int side = 0;  ///< points a side
  std::vector<double> lon;
  std::vector<double> lat;
  std::vector<geo::Direction> directions;
  bool complete = true;  ///< every point has a place

  Lattice(const Placement& placement, int cells) : side(cells + 1) {
    const GridTopology& grid = placement.topology();
    for (const double row : steps(0.0, grid.height, cells)) {
      for (const double col : steps(0.0, grid.width, cells)) {
        lon.push_back(col);
        lat.push_back(row);
      }
    }
    placement.lonLat(lon, lat);
    for (std::size_t i = 0; i < lon.size(); ++i) {
      complete = complete && std::isfinite(lon[i]) && std::isfinite(lat[i]);
      lat[i] = std::clamp(lat[i], -90.0, 90.0);
      directions.push_back(geo::directionFromDegrees(lat[i], lon[i]));
    }
  }
  std::size_t index(int col, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(side) + static_cast<std::size_t>(col);
  }
  const geo::Direction& direction(int col, int row) const { return directions[index(col, row)]; }
};

/// The largest gap between neighbouring longitudes is what the points leave out.
geo::GeoRect around(const Lattice& lattice) {
  std::vector<double> lon;
  lon.reserve(lattice.lon.size());
  for (const double l : lattice.lon)
    lon.push_back(geo::wrappedLongitude(Angle::degrees(l)).degrees());
  std::ranges::sort(lon);
  double widestGap = lon.front() + 360.0 - lon.back();
  double west = lon.front();
  for (std::size_t i = 1; i < lon.size(); ++i) {
    if (lon[i] - lon[i - 1] <= widestGap) continue;
    widestGap = lon[i] - lon[i - 1];
    west = lon[i];
  }
  const auto [south, north] = std::ranges::minmax(lattice.lat);
  return {Angle::degrees(south), Angle::degrees(north), Angle::degrees(west), Angle::degrees(360.0 - widestGap)};
}

/// The widest step between points next to each other.
double widestStep(const Lattice& lattice) {
  double widest = 0.0;
  for (int row = 0; row < lattice.side; ++row) {
    for (int col = 0; col < lattice.side; ++col) {
      const geo::Direction here = lattice.direction(col, row);
      if (col > 0) widest = std::max(widest, geo::angleBetween(here, lattice.direction(col - 1, row)).radians());
      if (row > 0) widest = std::max(widest, geo::angleBetween(here, lattice.direction(col, row - 1)).radians());
    }
  }
  return widest;
}

/// Grows a rectangle by what an edge between two points `step` apart can bulge.
geo::GeoRect grown(const geo::GeoRect& r, double step) {
  const double bulge = step * step;
  const double farthest = std::max(std::abs(r.south.radians()), std::abs(r.north.radians()));
  const double nearPole = std::max(std::cos(farthest) - step, 1e-6);
  const Angle dLat = Angle::radians(bulge + 1e-12);
  const Angle dLon = Angle::radians(bulge / (nearPole * nearPole) + 1e-12);
  const Angle pole = Angle::degrees(90.0);
  const bool allAround = (r.width + dLon * 2.0).degrees() >= 360.0;
  return {std::max(r.south - dLat, -pole), std::min(r.north + dLat, pole),
          allAround ? Angle::degrees(-180.0) : geo::wrappedLongitude(r.west - dLon),
          allAround ? Angle::degrees(360.0) : r.width + dLon * 2.0};
}

bool holdsPole(const Placement& placement, double latitude) {
  const std::array pole{geo::directionFromDegrees(latitude, 0.0)};
  PixelPlaces places;
  placement.pixels(pole, places);
  const GridTopology& grid = placement.topology();
  // A pole on the very edge is easily missed by rounding.
  return places.col[0] >= -1.0 && places.col[0] <= grid.width + 1.0 && places.row[0] >= -1.0 &&
         places.row[0] <= grid.height + 1.0;
}

/// Longitude and latitude are straight: the corners say it all.
geo::GeoRect straightBounds(const Placement& placement) {
  const GridTopology& grid = placement.topology();
  std::array<double, 2> lon{0.0, static_cast<double>(grid.width)};
  std::array<double, 2> lat{0.0, static_cast<double>(grid.height)};
  placement.lonLat(lon, lat);
  const auto [west, east] = std::minmax(lon[0], lon[1]);
  const auto [south, north] = std::minmax(lat[0], lat[1]);
  const bool allAround = grid.ring > 0 || east - west >= 360.0;
  return {Angle::degrees(std::clamp(south, -90.0, 90.0)), Angle::degrees(std::clamp(north, -90.0, 90.0)),
          allAround ? Angle::degrees(-180.0) : geo::wrappedLongitude(Angle::degrees(west)),
          allAround ? Angle::degrees(360.0) : Angle::degrees(east - west)};
}

/// A cap around a part of the lattice.
tiling::Cap capOf(const Lattice& lattice, int firstCol, int firstRow, int cells) {
  geo::Vec3 sum(0.0, 0.0, 0.0);
  for (int row = firstRow; row <= firstRow + cells; ++row) {
    for (int col = firstCol; col <= firstCol + cells; ++col)
      sum += lattice.direction(col, row).n;
  }
  const geo::Direction centre =
      geo::length(sum) > 1e-9 ? geo::Direction{geo::normalize(sum)} : lattice.direction(firstCol, firstRow);
  double radius = 0.0;
  double step = 0.0;
  for (int row = firstRow; row <= firstRow + cells; ++row) {
    for (int col = firstCol; col <= firstCol + cells; ++col) {
      const geo::Direction here = lattice.direction(col, row);
      radius = std::max(radius, geo::angleBetween(centre, here).radians());
      if (col > firstCol) step = std::max(step, geo::angleBetween(here, lattice.direction(col - 1, row)).radians());
      if (row > firstRow) step = std::max(step, geo::angleBetween(here, lattice.direction(col, row - 1)).radians());
    }
  }
  // Between its points an edge bulges by about step^2 / 8 on a sphere; eight times that for maps that bend more.
  return {centre, Angle::radians(radius + step * step + 1e-10)};
}

/// Conservative: true when two caps surely have no place in common.
bool areApart(const tiling::Cap& a, const tiling::Cap& b) {
  const double reach = a.radius.radians() + b.radius.radians();
  if (reach >= geo::kPi) return false;
  return geo::length(a.centre.n - b.centre.n) > 2.0 * std::sin(0.5 * reach) + 1e-12;
}

}  // namespace

Footprint::Footprint(const Placement& placement) {
  measureSpacing(placement);
  findBounds(placement);
  findPatches(placement);
}

void Footprint::measureSpacing(const Placement& placement) {
  constexpr int kPlaces = 9;
  const GridTopology& grid = placement.topology();
  const auto middle = [](double cells, int i) {
    return std::clamp((cells - 1.0) * i / (kPlaces - 1), 0.0, cells - 1.0);
  };
  for (int i = 0; i < kPlaces * kPlaces; ++i) {
    const double col = middle(grid.width, i % kPlaces);
    const double row = middle(grid.height, i / kPlaces);
    const auto corner = placement.direction(col, row);
    const auto right = placement.direction(col + 1.0, row);
    const auto below = placement.direction(col, row + 1.0);
    if (!corner || !right || !below) continue;
    spacing_ = std::max(spacing_, std::min(geo::angleBetween(*corner, *right), geo::angleBetween(*corner, *below)));
  }
}

void Footprint::findBounds(const Placement& placement) {
  if (placement.isStraightLonLat()) {
    bounds_ = straightBounds(placement);
    return;
  }
  constexpr int kCells = 64;
  const Lattice lattice(placement, kCells);
  if (!lattice.complete) return;
  bounds_ = grown(around(lattice), widestStep(lattice));
  const bool north = holdsPole(placement, 90.0);
  const bool south = holdsPole(placement, -90.0);
  if (north) bounds_.north = Angle::degrees(90.0);
  if (south) bounds_.south = Angle::degrees(-90.0);
  if (north || south || placement.topology().ring > 0) {
    bounds_.west = Angle::degrees(-180.0);
    bounds_.width = Angle::degrees(360.0);
  }
}

void Footprint::findPatches(const Placement& placement) {
  constexpr int kPatches = 16;
  constexpr int kCellsAPatch = 4;
  const Lattice lattice(placement, kPatches * kCellsAPatch);
  if (!lattice.complete) return;
  for (int i = 0; i < kPatches * kPatches; ++i) {
    patches_.push_back(capOf(lattice, i % kPatches * kCellsAPatch, i / kPatches * kCellsAPatch, kCellsAPatch));
  }
}

bool Footprint::mayTouch(const tiling::Tiling& tiling, const tiling::TileId& id, geo::Angle within) const {
  if (!bounds_.grown(within).intersects(tiling.bounds(id))) return false;
  if (patches_.empty()) return true;
  tiling::Cap cap = tiling.cap(id);
  cap.radius = cap.radius + within;
  return std::ranges::any_of(patches_, [&](const tiling::Cap& patch) { return !areApart(cap, patch); });
}

}  // namespace tellurion::raster
