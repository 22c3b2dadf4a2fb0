#include "pyramid/height_query.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "geo/local_frame.h"
#include "pyramid/query_tiles.h"
#include "raster/bilinear.h"

namespace tellurion::pyramid {
namespace {

/// Half the step of the numerical derivative of a place, as a share of a root's side: some 100 m on Earth, where both
/// the curvature's error and cancellation are below 1e-9.
constexpr double kHalfStep = 1e-5;

/// The bilinear patch between four samples.
struct Patch {
  std::array<double, 4> heights{};  ///< top left, top right, bottom left, bottom right; NaN is NODATA
  double s = 0.0;                   ///< 0..1 inside
  double t = 0.0;

  /// NaN where the nearest corner has no data.
  double height() const {
    const auto mix = [](double a, double b, double share) { return a + (b - a) * share; };
    const double whole = mix(mix(heights[0], heights[1], s), mix(heights[2], heights[3], s), t);
    if (!std::isnan(whole)) return whole;
    return raster::bilinearHeight(heights, s, t) ? heightOverData() : whole;
  }
  double nearest() const { return heights[(s >= 0.5 ? 1u : 0u) + (t >= 0.5 ? 2u : 0u)]; }
  /// How far the bilinear surface may be from `height_m`: it lies between the corners.
  double relief_m(double height_m) const {
    double most = 0.0;
    for (const double h : heights) {
      if (std::abs(h - height_m) > most) most = std::abs(h - height_m);  // not for NaN
    }
    return most;
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

struct CellOfTile {
  Patch patch;
  bool isAtBorder = false;  ///< one of its corners is on the tile's border
};

CellOfTile cellAt(const raster::Raster<float>& heights, const TilePlace& place) {
  const int cells = heights.width - 1;
  const double s = std::max(0.0, std::min(place.s * cells, static_cast<double>(cells)));
  const double t = std::max(0.0, std::min(place.t * cells, static_cast<double>(cells)));
  const int column = std::min(static_cast<int>(s), cells - 1);
  const int row = std::min(static_cast<int>(t), cells - 1);
  const float* top = &heights.at(column, row);
  const float* bottom = top + heights.width;
  const auto metres = [](float height) { return static_cast<double>(height); };
  return {.patch = {.heights = {metres(top[0]), metres(top[1]), metres(bottom[0]), metres(bottom[1])},
                    .s = s - column,
                    .t = t - row},
          .isAtBorder = column == 0 || row == 0 || column == cells - 1 || row == cells - 1};
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
  QueryTiles tiles;

  geo::Vec3 normal(const tiling::RootPoint& p, const QueryTile& tile, const Patch& patch, double height_m) const {
    const geo::Ellipsoid& ellipsoid = tiles.source().info().body.ellipsoid;
    const tiling::Tiling& tiling = tiles.tiling();
    const double patches = static_cast<double>(std::int64_t{1} << tile.id.level) * (tile.heights.width - 1);
    const geo::Vec3 up = tiling.direction(p).n;
    const geo::Vec3 alongU =
        tangent(tiling, ellipsoid, p, &tiling::RootPoint::u, height_m) + up * (patch.slopeAlongS() * patches);
    const geo::Vec3 alongV =
        tangent(tiling, ellipsoid, p, &tiling::RootPoint::v, height_m) + up * (patch.slopeAlongT() * patches);
    const geo::Vec3 normal = geo::normalize(geo::cross(alongV, alongU));
    const geo::LocalFrame frame = geo::localFrameAt(ellipsoid, geo::geodeticFromDirection({up}));
    return {geo::dot(normal, frame.east), geo::dot(normal, frame.north), geo::dot(normal, frame.up)};
  }

  std::optional<HeightAnswer> answer(const tiling::RootPoint& p, const QueryTile* tile,
                                     const HeightQuestion& question) const {
    if (tile == nullptr) return std::nullopt;
    const bool isNearest = question.sampling == Sampling::nearest;
    const bool isJoined = !isNearest && !tile->joined.samples.empty();
    const CellOfTile cell = cellAt(isJoined ? tile->joined : tile->heights, placeIn(tile->id, p));
    HeightAnswer answer{.height_m = isNearest ? cell.patch.nearest() : cell.patch.height(),
                        .level = tile->id.level,
                        .spacing_m = tiles.spacing_m(tile->id.level),
                        .errorBound_m = tile->error_m,
                        .hasFiner = tile->hasFiner(p)};
    if (std::isnan(answer.height_m)) return std::nullopt;
    if (isNearest) answer.errorBound_m += cell.patch.relief_m(answer.height_m);
    if (cell.isAtBorder) answer.errorBound_m += tile->joinShift_m;
    if (question.withNormals) answer.normal_enu = normal(p, *tile, cell.patch, answer.height_m);
    return answer;
  }

  auto answering(const HeightQuestion& question) const {
    return [this, &question](const tiling::RootPoint& p, const QueryTile* tile) { return answer(p, tile, question); };
  }
};

HeightQuery::HeightQuery(std::unique_ptr<State> state) : state_(std::move(state)) {}
HeightQuery::~HeightQuery() = default;
HeightQuery::HeightQuery(HeightQuery&&) noexcept = default;
HeightQuery& HeightQuery::operator=(HeightQuery&&) noexcept = default;

io::Result<HeightQuery> HeightQuery::create(std::shared_ptr<const raster::TileSource> source,
                                            std::uint64_t cacheBytes) {
  if (source->info().kind != raster::Kind::elevation) {
    return io::fail(io::Failure::Code::invalidArgument, "holds imagery; heights are asked of a database of elevation",
                    source->info().name);
  }
  return HeightQuery(std::make_unique<State>(State{.tiles = QueryTiles(std::move(source), cacheBytes)}));
}

io::Result<std::optional<HeightAnswer>> HeightQuery::at(const geo::Direction& place,
                                                        const HeightQuestion& question) const {
  return state_->tiles.ask<HeightAnswer>(place, question.level.value_or(tiling::kMaxLevel),
                                         state_->answering(question));
}

io::Result<void> HeightQuery::at(std::span<const geo::Direction> places, std::span<std::optional<HeightAnswer>> answers,
                                 const HeightQuestion& question) const {
  return state_->tiles.ask(places, answers, question.level.value_or(tiling::kMaxLevel), state_->answering(question));
}

}  // namespace tellurion::pyramid
