#include "raster/seam.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geo/local_frame.h"

namespace tellurion::raster {
namespace {

constexpr int kSide = Seam::kMapSide + 2;  ///< with a rim of cells that have no data

/// Squared distances along one line: out[i] is the least of in[k] + ((i - k) * step)^2. The lower envelope of parabolas
/// (Felzenszwalb and Huttenlocher, "Distance Transforms of Sampled Functions", Theory of Computing 8, 2012, section 2).
class LineTransform {
 public:
  void run(std::vector<double>& line, double step) {
    const std::size_t n = line.size();
    hull_.clear();
    starts_.clear();
    const auto meet = [&](std::size_t a, std::size_t b) {
      const double x = static_cast<double>(a) * step;
      const double y = static_cast<double>(b) * step;
      return ((line[b] + y * y) - (line[a] + x * x)) / (2.0 * (y - x));
    };
    for (std::size_t i = 0; i < n; ++i) {
      while (!hull_.empty() && starts_.back() >= meet(hull_.back(), i)) {
        hull_.pop_back();
        starts_.pop_back();
      }
      starts_.push_back(hull_.empty() ? -std::numeric_limits<double>::infinity() : meet(hull_.back(), i));
      hull_.push_back(i);
    }
    const std::vector<double> in = line;
    for (std::size_t i = 0, k = 0; i < n; ++i) {
      const double x = static_cast<double>(i) * step;
      while (k + 1 < hull_.size() && starts_[k + 1] < x)
        ++k;
      const double way = x - static_cast<double>(hull_[k]) * step;
      line[i] = in[hull_[k]] + way * way;
    }
  }

 private:
  std::vector<std::size_t> hull_;
  std::vector<double> starts_;
};

constexpr double kFar2 = 1e30;  ///< squared metres; not infinite, so that differences stay numbers

std::size_t cell(int col, int row) {
  return static_cast<std::size_t>(row) * kSide + static_cast<std::size_t>(col);
}

/// From each cell's middle to the middle of the nearest cell without data, squared.
std::vector<double> squaredWays(std::vector<double> map, double cellWidth_m, double cellHeight_m) {
  LineTransform transform;
  std::vector<double> line(kSide);
  const auto along = [&](double step, const auto& at) {
    for (int i = 0; i < kSide; ++i) {
      for (int k = 0; k < kSide; ++k)
        line[static_cast<std::size_t>(k)] = map[at(i, k)];
      transform.run(line, step);
      for (int k = 0; k < kSide; ++k)
        map[at(i, k)] = line[static_cast<std::size_t>(k)];
    }
  };
  along(cellWidth_m, [](int row, int col) { return cell(col, row); });
  along(cellHeight_m, [](int col, int row) { return cell(col, row); });
  return map;
}

}  // namespace

std::shared_ptr<const Seam> Seam::around(const geo::GeoRect& bounds, const geo::Ellipsoid& ellipsoid, double width_m,
                                         const std::function<bool(const geo::Direction&)>& hasData) {
  const geo::Angle lat = (bounds.south + bounds.north) * 0.5;
  const geo::Angle lon = bounds.west + bounds.width * 0.5;
  const bool aroundAPole = bounds.width.degrees() >= 360.0;
  const geo::Angle middleLat = !aroundAPole ? lat : geo::Angle::degrees(lat.degrees() > 0.0 ? 90.0 : -90.0);
  const geo::LocalFrame frame = geo::localFrameAt(ellipsoid, {.lat = middleLat, .lon = lon, .height_m = 0.0});
  std::shared_ptr<Seam> seam(new Seam);
  seam->middle_ = frame.up;
  seam->east_ = frame.east;
  seam->north_ = frame.north;
  seam->radius_m_ = ellipsoid.semiMajorAxis_m();
  double halfWidth = 0.0;
  double halfHeight = 0.0;
  constexpr int kSteps = 64;
  for (int i = 0; i <= kSteps; ++i) {
    for (int k = 0; k <= kSteps; ++k) {
      const geo::Direction d =
          geo::directionFromLatLon(bounds.south + (bounds.north - bounds.south) * (double(i) / kSteps),
                                   bounds.west + bounds.width * (double(k) / kSteps));
      if (geo::dot(d.n, frame.up) < std::cos(geo::Angle::degrees(kLargest_degrees).radians())) return nullptr;
      halfWidth = std::max(halfWidth, std::abs(geo::dot(d.n, frame.east)));
      halfHeight = std::max(halfHeight, std::abs(geo::dot(d.n, frame.north)));
    }
  }
  seam->cellWidth_m_ = 2.0 * halfWidth * seam->radius_m_ / kMapSide;
  seam->cellHeight_m_ = 2.0 * halfHeight * seam->radius_m_ / kMapSide;
  if (!(std::min(seam->cellWidth_m_, seam->cellHeight_m_) > 0.0)) return nullptr;
  seam->left_m_ = -halfWidth * seam->radius_m_ - seam->cellWidth_m_;
  seam->low_m_ = -halfHeight * seam->radius_m_ - seam->cellHeight_m_;
  seam->width_m_ = width_m > 0.0 ? width_m : kUsualShare * kMapSide * std::min(seam->cellWidth_m_, seam->cellHeight_m_);

  std::vector<double> map(static_cast<std::size_t>(kSide) * kSide, 0.0);
  for (int row = 1; row <= kMapSide; ++row) {
    for (int col = 1; col <= kMapSide; ++col) {
      const double x = (seam->left_m_ + (col + 0.5) * seam->cellWidth_m_) / seam->radius_m_;
      const double y = (seam->low_m_ + (row + 0.5) * seam->cellHeight_m_) / seam->radius_m_;
      const double z2 = 1.0 - x * x - y * y;
      if (z2 <= 0.0) continue;
      if (hasData({frame.east * x + frame.north * y + frame.up * std::sqrt(z2)})) map[cell(col, row)] = kFar2;
    }
  }
  // The border lies anywhere between the middles of two cells.
  const double hidden_m = std::hypot(seam->cellWidth_m_, seam->cellHeight_m_);
  const std::vector<double> ways2 = squaredWays(std::move(map), seam->cellWidth_m_, seam->cellHeight_m_);
  seam->inside_m_.reserve(ways2.size());
  for (const double way2 : ways2)
    seam->inside_m_.push_back(static_cast<float>(std::max(std::sqrt(way2) - hidden_m, 0.0)));
  return seam;
}

std::shared_ptr<const Seam> Seam::of(const TileSourceInfo& info, const std::optional<double>& seam_m,
                                     const std::function<bool(int, const geo::Direction&)>& hasData) {
  if (seam_m && *seam_m == 0.0) return nullptr;
  const tiling::Tiling tiling(info.scheme);
  const double wanted = (info.bounds.north - info.bounds.south).radians() / kMapSide;
  int level = 0;
  while (level < info.maxLevel && tiling.metrics(level).meanEdge.radians() / info.tileCells > wanted)
    ++level;
  return around(info.bounds, info.body.ellipsoid, seam_m.value_or(0.0),
                [&](const geo::Direction& place) { return hasData(level, place); });
}

const Seam* LateSeam::get(const TileSourceInfo& info, const std::optional<double>& seam_m, const Told& told,
                          const Nearest& nearest) {
  std::call_once(made_, [&] {
    const tiling::Tiling tiling(info.scheme);
    seam_ = Seam::of(info, seam_m, [&](int level, const geo::Direction& place) {
      const tiling::TileId id = tiling.tileAt(place, level);
      if (const auto has = told(id)) return *has;
      const NearestTiles::Found found = nearest(id);
      return found.tile && hasHeightAt(*found.tile, id.ancestor(found.level), tiling, place);
    });
  });
  return seam_.get();
}

bool hasHeightAt(const SourceTile& tile, const tiling::TileId& id, const tiling::Tiling& tiling,
                 const geo::Direction& place) {
  const auto& samples = std::get<ElevationTile>(tile.payload).samples;
  const tiling::RootPoint p = tiling.rootPoint(place);
  const int cells = samples.width - 3;
  const auto nearest = [&](double u, std::uint32_t index) {
    const double within = (u / tiling::tileSize(id.level) - index) * cells;
    return static_cast<int>(std::lround(std::clamp(within, 0.0, static_cast<double>(cells)))) + 1;
  };
  return !isNoData(samples.at(nearest(p.u, id.x), nearest(p.v, id.y)));
}

double Seam::weight(const geo::Direction& place) const {
  if (geo::dot(place.n, middle_) <= 0.0) return 0.0;
  const double col = (geo::dot(place.n, east_) * radius_m_ - left_m_) / cellWidth_m_ - 0.5;
  const double row = (geo::dot(place.n, north_) * radius_m_ - low_m_) / cellHeight_m_ - 0.5;
  if (!(col >= 0.0 && row >= 0.0 && col <= kSide - 1.0 && row <= kSide - 1.0)) return 0.0;
  const int c = std::min(static_cast<int>(col), kSide - 2);
  const int r = std::min(static_cast<int>(row), kSide - 2);
  const auto at = [&](int dc, int dr) { return static_cast<double>(inside_m_[cell(c + dc, r + dr)]); };
  const double inside_m =
      std::lerp(std::lerp(at(0, 0), at(1, 0), col - c), std::lerp(at(0, 1), at(1, 1), col - c), row - r);
  const double share = std::clamp(inside_m / width_m_, 0.0, 1.0);
  return share * share * (3.0 - 2.0 * share);
}

}  // namespace tellurion::raster
