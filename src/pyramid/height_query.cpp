#include "pyramid/height_query.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <list>
#include <unordered_map>

#include "geo/local_frame.h"
#include "pyramid/tile_record.h"
#include "raster/bilinear.h"

namespace tellurion::pyramid {
namespace {

using raster::isNoData;
using raster::kGutter;
using tiling::TileId;

/// Half the step of the numerical derivative of a place, as a share of a root's side: some 100 m on Earth, where both
/// the curvature's error and cancellation are below 1e-9.
constexpr double kHalfStep = 1e-5;

struct CachedTile {
  TileId id;
  std::uint8_t childMask = 0;
  raster::Raster<float> samples;
};

/// The tiles that were used last.
class TileCache {
 public:
  explicit TileCache(std::size_t capacity) : capacity_(std::max<std::size_t>(capacity, 1)) {}

  const CachedTile* find(const TileId& id) {
    const auto found = index_.find(id);
    if (found == index_.end()) return nullptr;
    tiles_.splice(tiles_.begin(), tiles_, found->second);
    return &tiles_.front();
  }
  const CachedTile& insert(CachedTile tile) {
    tiles_.push_front(std::move(tile));
    index_[tiles_.front().id] = tiles_.begin();
    if (tiles_.size() > capacity_) {
      index_.erase(tiles_.back().id);
      tiles_.pop_back();
    }
    return tiles_.front();
  }

 private:
  std::size_t capacity_;
  std::list<CachedTile> tiles_;  ///< used last first
  std::unordered_map<TileId, std::list<CachedTile>::iterator, tiling::TileIdHash> index_;
};

std::uint32_t cellOf(double u, int level) {
  const double count = static_cast<double>(std::uint64_t{1} << static_cast<unsigned>(level));
  return static_cast<std::uint32_t>(std::clamp(std::floor(u * count), 0.0, count - 1.0));
}

TileId tileOver(const tiling::RootPoint& p, int level) {
  return {.level = static_cast<std::uint8_t>(level),
          .root = static_cast<std::uint8_t>(p.root),
          .x = cellOf(p.u, level),
          .y = cellOf(p.v, level)};
}

/// The bilinear patch between four samples.
struct Patch {
  std::array<double, 4> heights{};  ///< top left, top right, bottom left, bottom right; NaN is NODATA
  double s = 0.0;                   ///< 0..1 inside
  double t = 0.0;

  bool isNoData() const { return !raster::bilinearHeight(heights, s, t); }
  double height() const {
    const auto mix = [](double a, double b, double share) { return a + (b - a) * share; };
    const double whole = mix(mix(heights[0], heights[1], s), mix(heights[2], heights[3], s), t);
    return std::isnan(whole) ? heightOverData() : whole;
  }
  double slopeAlongS() const { return slope(heights[1] - heights[0], heights[3] - heights[2], t); }
  double slopeAlongT() const { return slope(heights[2] - heights[0], heights[3] - heights[1], s); }

 private:
  double heightOverData() const {
    const std::array<double, 4> weights = {(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t};
    double sum = 0.0;
    double total = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      if (std::isnan(heights[i])) continue;
      sum += weights[i] * heights[i];
      total += weights[i];
    }
    return sum / total;
  }
  static double slope(double first, double second, double share) {
    if (std::isnan(first) && std::isnan(second)) return 0.0;
    if (std::isnan(first)) return second;
    if (std::isnan(second)) return first;
    return first * (1 - share) + second * share;
  }
};

Patch patchAt(const CachedTile& tile, const tiling::RootPoint& p) {
  const int cells = tile.samples.width - 1 - 2 * kGutter;
  const double scale = static_cast<double>(std::uint64_t{1} << tile.id.level);
  const double s = std::clamp((p.u * scale - tile.id.x) * cells, 0.0, static_cast<double>(cells));
  const double t = std::clamp((p.v * scale - tile.id.y) * cells, 0.0, static_cast<double>(cells));
  const int column = std::min(static_cast<int>(s), cells - 1);
  const int row = std::min(static_cast<int>(t), cells - 1);
  const auto sample = [&](int c, int r) {
    return static_cast<double>(tile.samples.at(column + c + kGutter, row + r + kGutter));
  };
  return {.heights = {sample(0, 0), sample(1, 0), sample(0, 1), sample(1, 1)}, .s = s - column, .t = t - row};
}

/// How the place moves with u (or v), metres for a whole root's side, at constant height.
geo::Vec3 tangent(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const tiling::RootPoint& p,
                  double tiling::RootPoint::*axis, double height_m) {
  tiling::RootPoint before = p;
  tiling::RootPoint after = p;
  before.*axis = std::max(0.0, p.*axis - kHalfStep);
  after.*axis = std::min(1.0, p.*axis + kHalfStep);
  const geo::BodyPosition a = ellipsoid.bodyFromDirection(tiling.direction(before), height_m);
  const geo::BodyPosition b = ellipsoid.bodyFromDirection(tiling.direction(after), height_m);
  const geo::Vec3 along = (b - a) / (after.*axis - before.*axis);
  const geo::Vec3 up = tiling.direction(p).n;
  return along - up * geo::dot(along, up);  // level, also where the step is one-sided
}

}  // namespace

struct HeightQuery::State {
  std::shared_ptr<const raster::TileSource> source;
  tiling::Tiling tiling;
  TileCache cache;

  io::Result<const CachedTile*> tile(const TileId& id) {
    if (const CachedTile* cached = cache.find(id)) return cached;
    auto loaded = source->load(id);
    if (!loaded) return tl::unexpected(loaded.error());
    if (!*loaded) return nullptr;
    raster::SourceTile& found = **loaded;
    auto& elevation = std::get<raster::ElevationTile>(found.payload);
    return &cache.insert({.id = id, .childMask = found.childMask, .samples = std::move(elevation.samples)});
  }

  /// The deepest stored tile over a place, no deeper than `level`; null where there is none.
  io::Result<const CachedTile*> finest(const tiling::RootPoint& p, int level) {
    auto current = tile(tileOver(p, 0));
    while (current && *current != nullptr && (*current)->id.level < level) {
      const TileId below = tileOver(p, (*current)->id.level + 1);
      if (((*current)->childMask & (1u << below.quadrant())) == 0) break;
      current = tile(below);
      if (current && *current == nullptr) {
        return io::fail(io::Failure::Code::corrupt, fmt::format("{} is missing", nameOf(below)), source->info().name);
      }
    }
    return current;
  }

  geo::Vec3 normal(const tiling::RootPoint& p, const CachedTile& tile) const {
    const geo::Ellipsoid& ellipsoid = source->info().body.ellipsoid;
    const double patches = static_cast<double>(std::uint64_t{1} << tile.id.level) * source->info().tileCells;
    const Patch patch = patchAt(tile, p);
    const geo::Vec3 up = tiling.direction(p).n;
    const double height = patch.height();
    const geo::Vec3 alongU =
        tangent(tiling, ellipsoid, p, &tiling::RootPoint::u, height) + up * (patch.slopeAlongS() * patches);
    const geo::Vec3 alongV =
        tangent(tiling, ellipsoid, p, &tiling::RootPoint::v, height) + up * (patch.slopeAlongT() * patches);
    const geo::Vec3 normal = geo::normalize(geo::cross(alongV, alongU));
    const geo::LocalFrame frame = geo::localFrameAt(ellipsoid, geo::geodeticFromDirection({up}));
    return {geo::dot(normal, frame.east), geo::dot(normal, frame.north), geo::dot(normal, frame.up)};
  }
};

HeightQuery::HeightQuery(std::unique_ptr<State> state) : state_(std::move(state)) {}
HeightQuery::~HeightQuery() = default;
HeightQuery::HeightQuery(HeightQuery&&) noexcept = default;
HeightQuery& HeightQuery::operator=(HeightQuery&&) noexcept = default;

io::Result<HeightQuery> HeightQuery::create(std::shared_ptr<const raster::TileSource> source, std::size_t cachedTiles) {
  if (source->info().kind != raster::Kind::elevation) {
    return io::fail(io::Failure::Code::invalidArgument, "holds imagery; heights are asked of a database of elevation",
                    source->info().name);
  }
  const tiling::Tiling tiling(source->info().scheme);
  auto state =
      std::make_unique<State>(State{.source = std::move(source), .tiling = tiling, .cache = TileCache(cachedTiles)});
  return HeightQuery(std::move(state));
}

io::Result<std::optional<HeightAnswer>> HeightQuery::at(const geo::Direction& place, std::optional<int> level) {
  if (std::isnan(place.n.x) || std::isnan(place.n.y) || std::isnan(place.n.z)) return std::optional<HeightAnswer>{};
  const tiling::RootPoint point = state_->tiling.rootPoint(place);
  const auto tile = state_->finest(point, level.value_or(tiling::kMaxLevel));
  if (!tile) return tl::unexpected(tile.error());
  if (*tile == nullptr) return std::optional<HeightAnswer>{};
  const Patch patch = patchAt(**tile, point);
  if (patch.isNoData()) return std::optional<HeightAnswer>{};
  return std::optional(HeightAnswer{
      .height_m = patch.height(), .normal_enu = state_->normal(point, **tile), .level = (*tile)->id.level});
}

}  // namespace tellurion::pyramid
