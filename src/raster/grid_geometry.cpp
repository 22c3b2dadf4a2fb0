#include "raster/grid_geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;
using PlaneKind = MapPlane::Kind;

constexpr double kDegree = 180.0 / geo::kPi;
constexpr double kMaxWindowSide = 1 << 30;
constexpr int kMaxLevels = 64;
/// A pixel may be this much larger than a sample and still be taken for no larger: rounding of what servers say.
constexpr double kSlack = 1.001;
/// Mercator ends at y = pi over the radius; places beyond are put here.
constexpr double kBeyondMercator = geo::kPi + 0.01;
/// Larger samples, in pixels, are means.
constexpr double kMeanFrom = 1.25;
/// Pixels along a parallel in one sample, from which a coarser level is read, where a whole turn of the level is more
/// than kFewAround pixels.
constexpr double kCrowded = 16.0;
constexpr int kFewAround = 8192;
/// The widest square in pixels.
constexpr double kWidest = 64.0;
/// Pixels along a sample's side on the coarsest level from which it is too much to read; and how many images are not.
constexpr double kTooManyPixels = 8.0;
constexpr std::int64_t kFewImages = 64;
/// As for files (placement.cpp): how far, in pixels, a grid may miss a whole turn or the pole and still reach it.
constexpr double kAlmost = 0.1;

bool isPositive(double v) {
  return std::isfinite(v) && v > 0.0;
}

std::optional<int> twicePole(double rowOfPole, int edgeRow) {
  const double twice = 2.0 * rowOfPole;
  const double whole = std::round(twice);
  if (std::abs(twice - whole) > 2.0 * kAlmost || std::abs(whole - 2.0 * edgeRow) > 1.0) return std::nullopt;
  return static_cast<int>(whole);
}

double rounded(double pixels) {
  constexpr double kSteps = 1 << 20;
  return std::round(pixels * kSteps) / kSteps;
}

/// y of Mercator over the radius, of the sine of a latitude.
double mercatorY(double sine) {
  return std::clamp(std::atanh(sine), -kBeyondMercator, kBeyondMercator);
}

io::Result<void> checkLevel(const GridLevel& l, const std::string& name) {
  const bool sound = isPositive(l.pixelWidth) && isPositive(l.pixelHeight) && std::isfinite(l.left) &&
                     std::isfinite(l.top) && l.imageWidth >= 1 && l.imageHeight >= 1 && l.imageWidth <= kMaxImageSide &&
                     l.imageHeight <= kMaxImageSide && l.firstColumn >= 0 && l.firstRow >= 0 &&
                     l.firstColumn < l.endColumn && l.firstRow < l.endRow && l.endColumn <= l.columns &&
                     l.endRow <= l.rows;
  if (sound) return {};
  return io::fail(Code::corrupt,
                  fmt::format("a level of {} x {} images of {} x {} pixels makes no sense; each side of an image has 1 "
                              "to {} pixels",
                              l.columns, l.rows, l.imageWidth, l.imageHeight, kMaxImageSide),
                  name);
}

}  // namespace

std::size_t GridImageIdHash::operator()(const GridImageId& id) const noexcept {
  std::uint64_t h = static_cast<std::uint64_t>(id.level) * 0x9e3779b97f4a7c15u;
  h = (h ^ static_cast<std::uint64_t>(id.column)) * 0xbf58476d1ce4e5b9u;
  h = (h ^ (h >> 29u) ^ static_cast<std::uint64_t>(id.row)) * 0x94d049bb133111ebu;
  return static_cast<std::size_t>(h ^ (h >> 32u));
}

void PlanePlaces::resize(std::size_t count) {
  x.resize(count);
  y.resize(count);
  narrowing.resize(count);
}

GridGeometry::GridGeometry(const GridService& service)
    : plane_(service.plane), body_(service.body), bounds_(service.bounds), projections_(4) {}

io::Result<std::shared_ptr<const GridGeometry>> GridGeometry::make(const GridService& service) {
  std::shared_ptr<GridGeometry> made(new GridGeometry(service));
  switch (made->plane_.kind) {
    case PlaneKind::lonLat:
      made->turn_ = 360.0;
      made->radiansPerUnit_ = 1.0 / kDegree;
      break;
    case PlaneKind::webMercator:
      made->turn_ = 2.0 * geo::kPi * made->body_.ellipsoid.semiMajorAxis_m();
      made->radiansPerUnit_ = 1.0 / made->body_.ellipsoid.semiMajorAxis_m();
      break;
    case PlaneKind::other:
      break;
  }
  if (service.levels.empty() || service.levels.size() > kMaxLevels) {
    return io::fail(Code::corrupt, fmt::format("has {} levels; 1 to {} are read", service.levels.size(), kMaxLevels),
                    service.name);
  }
  for (const GridLevel& level : service.levels) {
    if (auto sound = checkLevel(level, service.name); !sound) return tl::unexpected(std::move(sound.error()));
    if (!made->levels_.empty() && !(level.pixelHeight < made->levels_.back().pixelHeight)) {
      return io::fail(Code::corrupt, "its levels do not become finer", service.name);
    }
    const double width = static_cast<double>(level.endColumn - level.firstColumn) * level.imageWidth;
    const double height = static_cast<double>(level.endRow - level.firstRow) * level.imageHeight;
    if (width > kMaxWindowSide || height > kMaxWindowSide) break;
    if (auto added = made->addLevel(level); !added) return tl::unexpected(std::move(added.error()));
  }
  if (made->levels_.empty()) {
    return io::fail(Code::unsupported, "its coarsest level has more than 2^30 pixels a side; name a smaller area",
                    service.name);
  }
  if (made->plane_.kind == PlaneKind::other) {
    if (auto measured = made->measureOther(); !measured) {
      measured.error().where = service.name;
      return tl::unexpected(std::move(measured.error()));
    }
  }
  made->findBounds();
  return made;
}

io::Result<void> GridGeometry::addLevel(const GridLevel& l) {
  GridWindow w;
  w.imageColumns = static_cast<int>(l.endColumn - l.firstColumn);
  w.imageRows = static_cast<int>(l.endRow - l.firstRow);
  w.left = l.left + static_cast<double>(l.firstColumn) * l.imageWidth * l.pixelWidth;
  w.top = l.top - static_cast<double>(l.firstRow) * l.imageHeight * l.pixelHeight;
  w.turn = turn_;
  w.period = turn_ / l.pixelWidth;
  w.topology.width = w.imageColumns * l.imageWidth;
  w.topology.height = w.imageRows * l.imageHeight;
  const double ring = std::round(w.period);
  if (ring >= 1.0 && ring <= w.topology.width && std::abs(w.period - ring) <= kAlmost) {
    w.topology.ring = static_cast<int>(ring);
    if (plane_.kind == PlaneKind::lonLat) {
      w.topology.topPole = twicePole((w.top - 90.0) / l.pixelHeight, 0);
      w.topology.bottomPole = twicePole((w.top + 90.0) / l.pixelHeight, w.topology.height);
    }
  }
  levels_.push_back(l);
  windows_.push_back(w);
  return {};
}

io::Result<Projection> GridGeometry::projection() const {
  if (body_ == geo::earth()) return Projection::fromWgs84(plane_.definition, bounds_);
  return Projection::fromOwnGeographic(plane_.definition);
}

/// The largest angle that a unit of the plane is, over the places of the coarsest level.
io::Result<void> GridGeometry::measureOther() {
  constexpr int kPlaces = 9;
  const GridWindow& w = windows_.front();
  const GridLevel& l = levels_.front();
  const double step = std::min(l.pixelWidth, l.pixelHeight);
  auto done = projections_.with(
      [this] { return projection(); },
      [&](const Projection& projection) -> io::Result<void> {
        for (int i = 0; i < kPlaces * kPlaces; ++i) {
          const double right = (i % kPlaces + 0.5) / kPlaces * w.topology.width;
          const double down = (i / kPlaces + 0.5) / kPlaces * w.topology.height;
          const double px = w.left + right * l.pixelWidth;
          const double py = w.top - down * l.pixelHeight;
          std::array x{px, px + step, px};
          std::array y{py, py, py + step};
          projection.inverse(x, y);
          std::array<geo::Direction, 3> d;
          bool finite = true;
          for (std::size_t k = 0; k < d.size(); ++k) {
            finite = finite && std::isfinite(x[k]) && std::abs(y[k]) <= 90.0;
            d[k] = geo::directionFromDegrees(y[k], x[k]);
          }
          if (!finite) continue;
          const double side = std::min(geo::angleBetween(d[0], d[1]), geo::angleBetween(d[0], d[2])).radians();
          radiansPerUnit_ = std::max(radiansPerUnit_, side / step);
        }
        return {};
      });
  if (done && !isPositive(radiansPerUnit_)) {
    return io::fail(Code::unsupported, "none of its images has a place on the body; is its reference right?");
  }
  return done;
}

void GridGeometry::findBounds() {
  // Rounding of what a server says never loses the last row: a ten-millionth of the finest pixel.
  const double edge = 1e-7 * levels_.back().pixelHeight;
  switch (plane_.kind) {
    case PlaneKind::lonLat:
      south_ = bounds_.south.degrees();
      north_ = bounds_.north.degrees();
      west_ = bounds_.west.degrees();
      width_ = bounds_.width.degrees();
      break;
    case PlaneKind::webMercator: {
      const double radius_m = body_.ellipsoid.semiMajorAxis_m();
      south_ = radius_m * mercatorY(geo::sinCos(bounds_.south).sin);
      north_ = radius_m * mercatorY(geo::sinCos(bounds_.north).sin);
      west_ = radius_m * bounds_.west.radians();
      width_ = radius_m * bounds_.width.radians();
      break;
    }
    case PlaneKind::other:
      break;
  }
  south_ -= edge;
  north_ += edge;
  west_ -= edge;
  width_ += 2.0 * edge;
}

bool GridGeometry::isInBounds(double x, double y) const {
  if (plane_.kind == PlaneKind::other) return true;
  if (!(y >= south_ && y <= north_)) return false;
  if (width_ >= turn_) return true;
  const double east = x - west_;
  return east - std::floor(east / turn_) * turn_ <= width_;
}

void GridGeometry::places(std::span<const geo::Direction> directions, PlanePlaces& out) const {
  out.resize(directions.size());
  const double radius_m = body_.ellipsoid.semiMajorAxis_m();
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const geo::Vec3& n = directions[i].n;
    const double fromAxis = std::sqrt(n.x * n.x + n.y * n.y);
    const double lon = fromAxis == 0.0 ? 0.0 : std::atan2(n.y + 0.0, n.x);
    out.narrowing[i] = std::min(fromAxis, 1.0);
    if (plane_.kind == PlaneKind::webMercator) {
      out.x[i] = radius_m * lon;
      out.y[i] = radius_m * mercatorY(std::clamp(n.z, -1.0, 1.0));
    } else {
      out.x[i] = lon * kDegree;
      out.y[i] = std::atan2(n.z, fromAxis) * kDegree;
    }
  }
  if (plane_.kind != PlaneKind::other) return;
  const auto done = projections_.with([this] { return projection(); },
                                      [&](const Projection& projection) -> io::Result<void> {
                                        projection.forward(out.x, out.y);
                                        return {};
                                      });
  // It could be made when the grid was opened.
  if (!done) std::ranges::fill(out.x, std::numeric_limits<double>::infinity());
}

geo::Angle GridGeometry::pixelSide(int level, double narrowing) const {
  const GridLevel& l = levels_[static_cast<std::size_t>(level)];
  switch (plane_.kind) {
    case PlaneKind::lonLat:
      return geo::Angle::degrees(std::max(l.pixelHeight, l.pixelWidth * narrowing));
    case PlaneKind::webMercator:
      return geo::Angle::radians(std::max(l.pixelHeight, l.pixelWidth) * radiansPerUnit_ * narrowing);
    case PlaneKind::other:
      break;
  }
  return geo::Angle::radians(std::max(l.pixelHeight, l.pixelWidth) * radiansPerUnit_);
}

GridFit GridGeometry::fitOn(int level, geo::Angle spacing, tiling::Scheme scheme, double narrowing) const {
  const GridLevel& l = levels_[static_cast<std::size_t>(level)];
  GridFit fit{.level = level};
  switch (plane_.kind) {
    case PlaneKind::lonLat: {
      // Between its caps, up to 45 degrees, the geographic tiling's samples narrow as the pixels do.
      const bool narrowsToo = scheme == tiling::Scheme::geographic && narrowing >= std::numbers::sqrt2 / 2.0;
      fit.width = spacing.degrees() / (l.pixelWidth * (narrowsToo ? 1.0 : std::max(narrowing, 1e-12)));
      fit.height = spacing.degrees() / l.pixelHeight;
      break;
    }
    case PlaneKind::webMercator: {
      const double metres = spacing.radians() / radiansPerUnit_ / std::max(narrowing, 1e-12);
      fit.width = metres / l.pixelWidth;
      fit.height = metres / l.pixelHeight;
      break;
    }
    case PlaneKind::other:
      fit.width = spacing.radians() / radiansPerUnit_ / l.pixelWidth;
      fit.height = spacing.radians() / radiansPerUnit_ / l.pixelHeight;
      break;
  }
  const GridTopology& grid = window(level).topology;
  const double most = grid.ring > 0 ? std::min<double>(kWidest, grid.ring) : kWidest;
  fit.width = std::min(fit.width, most);
  fit.height = std::min(fit.height, kWidest);
  fit.isMean = std::max(fit.width, fit.height) > kMeanFrom;
  return fit;
}

GridFit GridGeometry::fit(geo::Angle spacing, tiling::Scheme scheme, double narrowing) const {
  const double largest = spacing.radians() * kSlack;
  int level = 0;
  while (level + 1 < levels() && pixelSide(level, narrowing).radians() > largest)
    ++level;
  const auto isCrowded = [&](int l) {
    const GridWindow& w = window(l);
    const double pixel = levels_[static_cast<std::size_t>(l)].pixelWidth * narrowing;
    return w.period > kFewAround && pixel * kCrowded < spacing.degrees();
  };
  if (plane_.kind == PlaneKind::lonLat) {
    while (level > 0 && isCrowded(level))
      --level;
  }
  const GridWindow& coarsest = windows_.front();
  const bool isSmall = std::int64_t{coarsest.imageColumns} * coarsest.imageRows <= kFewImages;
  if (level == 0 && !isSmall && pixelSide(0, narrowing).radians() * kTooManyPixels < spacing.radians()) return {};
  return fitOn(level, spacing, scheme, narrowing);
}

GridGeometry::Pixel GridGeometry::pixel(int level, double x, double y) const {
  const GridWindow& w = window(level);
  const GridLevel& l = levels_[static_cast<std::size_t>(level)];
  double col = (x - w.left) / l.pixelWidth;
  if (w.topology.ring > 0) {
    if (col < 0.0 || col >= w.period) col -= std::floor(col / w.period) * w.period;
  } else if (w.period > 0.0) {
    const double middle = 0.5 * w.topology.width;
    col = middle + std::remainder(col - middle, w.period);
  }
  return {rounded(col), rounded((w.top - y) / l.pixelHeight)};
}

GridImageId GridGeometry::imageAt(int level, int column, int row) const {
  const GridLevel& l = levels_[static_cast<std::size_t>(level)];
  return {level, l.firstColumn + column, l.firstRow + row};
}

std::vector<GridImageId> GridGeometry::imagesUnder(const GridImageId& id) const {
  if (id.level == 0) return {};
  const GridLevel& own = levels_[static_cast<std::size_t>(id.level)];
  const GridLevel& coarser = levels_[static_cast<std::size_t>(id.level - 1)];
  const GridWindow& window = windows_[static_cast<std::size_t>(id.level - 1)];
  const double width = own.imageWidth * own.pixelWidth;
  const double height = own.imageHeight * own.pixelHeight;
  const double left = own.left + static_cast<double>(id.column) * width;
  const double top = own.top - static_cast<double>(id.row) * height;
  const double imageWidth = coarser.imageWidth * coarser.pixelWidth;
  const double imageHeight = coarser.imageHeight * coarser.pixelHeight;
  // A pixel around, for what lies between two of them.
  const auto index = [](double v, int count) { return static_cast<int>(std::clamp(std::floor(v), 0.0, count - 1.0)); };
  const int firstColumn = index((left - coarser.pixelWidth - window.left) / imageWidth, window.imageColumns);
  const int lastColumn = index((left + width + coarser.pixelWidth - window.left) / imageWidth, window.imageColumns);
  const int firstRow = index((window.top - top - coarser.pixelHeight) / imageHeight, window.imageRows);
  const int lastRow = index((window.top - top + height + coarser.pixelHeight) / imageHeight, window.imageRows);
  std::vector<GridImageId> under;
  for (int row = firstRow; row <= lastRow; ++row) {
    for (int column = firstColumn; column <= lastColumn; ++column)
      under.push_back(imageAt(id.level - 1, column, row));
  }
  return under;
}

geo::Angle sampleSpacing(const tiling::Tiling& tiling, int level, int cells) {
  const tiling::LevelMetrics metrics = tiling.metrics(level);
  const geo::Angle side = tiling.scheme() == tiling::Scheme::geographic ? metrics.largestEdge : metrics.meanEdge * 1.1;
  return side / cells;
}

}  // namespace tellurion::raster
