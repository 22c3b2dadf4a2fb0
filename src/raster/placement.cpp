#include "raster/placement.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tellurion::raster {
namespace {

constexpr double kDegree = 180.0 / geo::kPi;
/// Rounding of coordinates, in pixels: a place so little outside is on the edge.
constexpr double kEdge = 1e-6;
/// How far, in pixels, a raster may miss a whole turn or the pole and still be meant to reach it.
constexpr double kAlmost = 0.1;

struct LonLat {
  double lon;
  double lat;
};
LonLat lonLatDegrees(const geo::Vec3& n) {
  const double fromAxis = std::sqrt(n.x * n.x + n.y * n.y);
  const double lon = fromAxis == 0.0 ? 0.0 : std::atan2(n.y + 0.0, n.x);
  return {lon * kDegree, std::atan2(n.z, fromAxis) * kDegree};
}

std::optional<int> twicePole(double rowOfPole, int edgeRow) {
  const double twice = 2.0 * rowOfPole;
  const double whole = std::round(twice);
  if (std::abs(twice - whole) > 2.0 * kAlmost || std::abs(whole - 2.0 * edgeRow) > 1.0) return std::nullopt;
  return static_cast<int>(whole);
}

}  // namespace

bool GridTopology::resolve(int& col, int& row) const {
  if (row < 0 || row >= height) {
    const std::optional<int>& pole = row < 0 ? topPole : bottomPole;
    if (!pole) return false;
    row = *pole - row - 1;
    col += ring / 2;
  }
  if ((col < 0 || col >= width) && ring > 0) {
    col %= ring;
    if (col < 0) col += ring;
  }
  return row >= 0 && row < height && col >= 0 && col < width;
}

GridTopology GridTopology::scaledTo(int otherWidth, int otherHeight) const {
  const double sx = static_cast<double>(otherWidth) / width;
  const double sy = static_cast<double>(otherHeight) / height;
  GridTopology other{otherWidth, otherHeight, 0, std::nullopt, std::nullopt};
  if (ring > 0) other.ring = std::min(otherWidth, static_cast<int>(std::lround(ring * sx)));
  if (topPole) other.topPole = static_cast<int>(std::lround(*topPole * sy));
  if (bottomPole) other.bottomPole = static_cast<int>(std::lround(*bottomPole * sy));
  return other;
}

Placement::Placement(Georeference georeference, int width, int height) : reference_(std::move(georeference)) {
  const auto& t = reference_.transform;
  const double determinant = t[1] * t[5] - t[2] * t[4];
  inverse_ = {0.0, t[5] / determinant, -t[2] / determinant, 0.0, -t[4] / determinant, t[1] / determinant};
  straight_ = t[2] == 0.0 && t[4] == 0.0;
  if (straight_) period_ = reference_.turn / std::abs(t[1]);
  middleX_ = t[0] + 0.5 * (width * t[1] + height * t[2]);
  findTopology(width, height);
}

void Placement::findTopology(int width, int height) {
  topology_ = {width, height, 0, std::nullopt, std::nullopt};
  const double ring = std::round(period_);
  if (period_ == 0.0 || ring < 1.0 || width < ring || std::abs(period_ - ring) > kAlmost) return;
  topology_.ring = static_cast<int>(ring);
  if (!isLonLat()) return;
  const auto& t = reference_.transform;
  const double topLatitude = t[5] < 0.0 ? 90.0 : -90.0;
  topology_.topPole = twicePole((topLatitude - t[3]) / t[5], 0);
  topology_.bottomPole = twicePole((-topLatitude - t[3]) / t[5], height);
}

/// A column of one of the turns of the map, brought to the turn that the raster lies on.
double Placement::pixelColumn(double col) const {
  if (period_ == 0.0) return col;
  if (col < 0.0 || col >= period_) col -= std::floor(col / period_) * period_;
  return col > period_ - kEdge ? col - period_ : col;
}

void Placement::toPixels(std::span<double> lon, std::span<double> lat) const {
  const auto& t = reference_.transform;
  if (reference_.projection) reference_.projection->forward(lon, lat);
  if (straight_) {
    for (std::size_t i = 0; i < lon.size(); ++i) {
      lon[i] = pixelColumn((lon[i] - t[0]) / t[1]);
      lat[i] = (lat[i] - t[3]) / t[5];
    }
  } else {
    for (std::size_t i = 0; i < lon.size(); ++i) {
      const double x = (isLonLat() ? middleX_ + std::remainder(lon[i] - middleX_, 360.0) : lon[i]) - t[0];
      const double y = lat[i] - t[3];
      lon[i] = x * inverse_[1] + y * inverse_[2];
      lat[i] = x * inverse_[4] + y * inverse_[5];
    }
  }
  toEdges(lon, lat);
}

/// What rounding has put just outside is brought back to the edge.
void Placement::toEdges(std::span<double> col, std::span<double> row) const {
  const double right = topology_.width;
  const double bottom = topology_.height;
  for (std::size_t i = 0; i < col.size(); ++i) {
    if (col[i] > -kEdge && col[i] < right + kEdge) col[i] = std::clamp(col[i], 0.0, right);
    if (row[i] > -kEdge && row[i] < bottom + kEdge) row[i] = std::clamp(row[i], 0.0, bottom);
  }
}

void Placement::settle(PixelPlaces& places) const {
  for (double& col : places.col)
    col = pixelColumn(col);
  toEdges(places.col, places.row);
}

void Placement::pixels(std::span<const geo::Direction> directions, PixelPlaces& places) const {
  places.col.resize(directions.size());
  places.row.resize(directions.size());
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const LonLat p = lonLatDegrees(directions[i].n);
    places.col[i] = p.lon;
    places.row[i] = p.lat;
  }
  toPixels(places.col, places.row);
}

void Placement::squares(std::span<const geo::Direction> directions, geo::Angle side, PixelPlaces& places) const {
  pixels(directions, places);
  places.width.resize(directions.size());
  places.height.resize(directions.size());
  const auto& t = reference_.transform;
  // No square needs to be larger than what surely holds the raster from any place on it.
  const double widest = topology_.ring > 0 ? topology_.ring : 2.0 * topology_.width + 2.0;
  const double highest = 2.0 * topology_.height + 2.0;
  if (isStraightLonLat()) {
    const double rows = side.degrees() / std::abs(t[5]);
    const double columns = side.degrees() / std::abs(t[1]);
    for (std::size_t i = 0; i < directions.size(); ++i) {
      const geo::Vec3& n = directions[i].n;
      const double fromAxis = std::sqrt(n.x * n.x + n.y * n.y);
      places.width[i] = std::min(columns / std::max(fromAxis, 1e-300), widest);
      places.height[i] = std::min(rows, highest);
    }
    return;
  }
  // The map's scale is measured on the square itself: half its side to the east, west, north and south.
  const double half = 0.5 * side.radians();
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const geo::Vec3& n = directions[i].n;
    const bool onAxis = n.x == 0.0 && n.y == 0.0;
    const geo::Vec3 east = onAxis ? geo::Vec3(0.0, 1.0, 0.0) : geo::normalize(geo::Vec3(-n.y, n.x, 0.0));
    const geo::Vec3 north = geo::cross(n, east);
    const std::array around{n + half * east, n - half * east, n + half * north, n - half * north};
    std::array<double, 4> col{};
    std::array<double, 4> row{};
    for (std::size_t k = 0; k < around.size(); ++k) {
      const LonLat p = lonLatDegrees(around[k]);
      col[k] = p.lon;
      row[k] = p.lat;
    }
    toPixels(col, row);
    const double acrossCol = period_ > 0.0 ? std::remainder(col[0] - col[1], period_) : col[0] - col[1];
    const double upCol = period_ > 0.0 ? std::remainder(col[2] - col[3], period_) : col[2] - col[3];
    const double wide = std::hypot(acrossCol, upCol);
    const double high = std::hypot(row[0] - row[1], row[2] - row[3]);
    // Where the map ends within the square, a pixel must do.
    places.width[i] = std::isfinite(wide) ? std::min(wide, widest) : 1.0;
    places.height[i] = std::isfinite(high) ? std::min(high, highest) : 1.0;
  }
}

void Placement::lonLat(std::span<double> col, std::span<double> row) const {
  const auto& t = reference_.transform;
  for (std::size_t i = 0; i < col.size(); ++i) {
    const double c = col[i];
    const double r = row[i];
    col[i] = t[0] + c * t[1] + r * t[2];
    row[i] = t[3] + c * t[4] + r * t[5];
  }
  if (reference_.projection) reference_.projection->inverse(col, row);
}

std::optional<geo::Direction> Placement::direction(double col, double row) const {
  lonLat({&col, 1}, {&row, 1});
  if (!std::isfinite(col) || !std::isfinite(row) || std::abs(row) > 91.0) return std::nullopt;
  return geo::directionFromDegrees(std::clamp(row, -90.0, 90.0), col);
}

}  // namespace tellurion::raster
