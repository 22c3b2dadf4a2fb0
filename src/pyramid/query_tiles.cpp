#include "pyramid/query_tiles.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pyramid/tile_record.h"

namespace tellurion::pyramid {
namespace {

using raster::kGutter;
using tiling::TileId;

constexpr int kHintLevel = 5;
constexpr std::uint64_t kShareOfPresences = 4;  ///< of the budget one in so many bytes

std::uint32_t cellOf(double u, int level) {
  const auto count = static_cast<double>(std::int64_t{1} << level);
  return static_cast<std::uint32_t>(std::max(0.0, std::min(u * count, count - 1.0)));
}

TileId tileOver(const tiling::RootPoint& p, int level) {
  return {.level = static_cast<std::uint8_t>(level),
          .root = static_cast<std::uint8_t>(p.root),
          .x = cellOf(p.u, level),
          .y = cellOf(p.v, level)};
}

raster::Raster<float> withoutGutter(const raster::Raster<float>& samples) {
  raster::Raster<float> inner(samples.width - 2 * kGutter, samples.height - 2 * kGutter);
  for (int row = 0; row < inner.height; ++row) {
    const auto from = samples.row(row + kGutter).subspan(kGutter, static_cast<std::size_t>(inner.width));
    std::ranges::copy(from, &inner.at(0, row));
  }
  return inner;
}

/// What touches a tile of which something is not stored: there its samples have to lie on the level above.
struct OpenBorder {
  std::array<bool, 4> edges{};
  std::array<bool, 4> corners{};

  bool any() const {
    const auto isOpen = [](bool open) { return open; };
    return std::ranges::any_of(edges, isOpen) || std::ranges::any_of(corners, isOpen);
  }
  bool isAt(int col, int row, int cells) const {
    const bool top = row == 0;
    const bool right = col == cells;
    const bool bottom = row == cells;
    const bool left = col == 0;
    return (top && edges[0]) || (right && edges[1]) || (bottom && edges[2]) || (left && edges[3]) ||
           (top && left && corners[0]) || (top && right && corners[1]) || (bottom && right && corners[2]) ||
           (bottom && left && corners[3]);
  }
};

/// Where the border is open, samples of a tile lie between those of its parent, so that there is no step to the coarser
/// tile beside it. NODATA stays, and where the parent has some nothing is moved.
raster::Raster<float> joinedHeights(const QueryTile& tile, const raster::Raster<float>& parent,
                                    const OpenBorder& border) {
  raster::Raster<float> joined = tile.heights;
  const int cells = joined.width - 1;
  const int firstCol = static_cast<int>(tile.id.x & 1u) * cells;  // in half cells of the parent
  const int firstRow = static_cast<int>(tile.id.y & 1u) * cells;
  for (int row = 0; row <= cells; ++row) {
    for (int col = 0; col <= cells; ++col) {
      if (!border.isAt(col, row, cells)) continue;
      const int c = firstCol + col;
      const int r = firstRow + row;
      const float between = (parent.at(c / 2, r / 2) + parent.at((c + 1) / 2, r / 2) + parent.at(c / 2, (r + 1) / 2) +
                             parent.at((c + 1) / 2, (r + 1) / 2)) /
                            4.0f;
      float& height = joined.at(col, row);
      if (!raster::isNoData(between) && !raster::isNoData(height)) height = between;
    }
  }
  return joined;
}

double largestDifference(const raster::Raster<float>& a, const raster::Raster<float>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.samples.size(); ++i) {
    const double difference = std::abs(static_cast<double>(a.samples[i]) - static_cast<double>(b.samples[i]));
    if (difference > largest) largest = difference;  // not for NaN
  }
  return largest;
}

std::uint64_t bytesOf(const QueryTile& tile) {
  return sizeof(tile) + sizeof(float) * (tile.heights.samples.size() + tile.joined.samples.size()) +
         sizeof(raster::Rgba8) * tile.pixels.samples.size();
}

}  // namespace

bool QueryTile::hasFiner(const tiling::RootPoint& p) const {
  if (childMask == 0) return false;
  const TilePlace place = placeIn(id, p);
  const unsigned quadrant = (place.s >= 0.5 ? 1u : 0u) + (place.t >= 0.5 ? 2u : 0u);
  return ((childMask >> quadrant) & 1u) != 0;
}

bool QueryTile::answers(const tiling::RootPoint& p, int level) const {
  if (p.root != id.root || id.level > level) return false;
  const TilePlace place = placeIn(id, p);
  // What lies on the last edge of a root is on the last tile; else an edge belongs to the tile that it begins.
  const auto holds = [](double at, double unit) { return at >= 0.0 && (at < 1.0 || (at == 1.0 && unit == 1.0)); };
  if (!holds(place.s, p.u) || !holds(place.t, p.v)) return false;
  return id.level == level || !hasFiner(p);
}

QueryTiles::QueryTiles(std::shared_ptr<const raster::TileSource> source, std::uint64_t cacheBytes)
    : source_(std::move(source)),
      tiling_(source_->info().scheme),
      hints_(static_cast<std::size_t>(tiling_.rootCount()) << (2 * kHintLevel)) {
  const raster::TileSourceInfo& info = source_->info();
  for (int level = 0; level <= tiling::kMaxLevel; ++level) {
    const double edge = tiling_.metrics(level).meanEdge.radians() * info.body.ellipsoid.meanRadius_m();
    spacing_m_[static_cast<std::size_t>(level)] = edge / info.tileCells;
  }
  const std::uint64_t presences = cacheBytes / kShareOfPresences;
  for (std::size_t i = 0; i < kShards; ++i)
    shards_.push_back(std::make_unique<Shard>((cacheBytes - presences) / kShards, presences / kShards));
  const auto deepest = static_cast<std::uint8_t>(std::clamp(info.maxLevel, 0, tiling::kMaxLevel));
  for (std::atomic<std::uint8_t>& hint : hints_)
    hint.store(deepest, std::memory_order_relaxed);
}

QueryTiles::Shard& QueryTiles::shardOf(const TileId& id) {
  return *shards_[(tiling::TileIdHash{}(id) >> 40u) % kShards];
}

std::atomic<std::uint8_t>& QueryTiles::hintAt(const tiling::RootPoint& p) {
  const std::size_t across = std::size_t{1} << kHintLevel;
  const std::size_t root = static_cast<std::size_t>(p.root);
  return hints_[(root * across + cellOf(p.v, kHintLevel)) * across + cellOf(p.u, kHintLevel)];
}

io::Result<QueryTiles::Pointer> QueryTiles::finest(const tiling::RootPoint& p, int level) {
  if (std::isnan(p.u) || std::isnan(p.v)) return nullptr;
  level = std::min(level, source_->info().maxLevel);
  std::atomic<std::uint8_t>& hint = hintAt(p);
  const TileId likely = tileOver(p, std::min<int>(level, hint.load(std::memory_order_relaxed)));
  const auto kept = shardOf(likely).tiles.use(likely);
  if (kept && *kept != nullptr && (*kept)->answers(p, level)) return *kept;

  TileId id = tileOver(p, 0);
  for (;;) {
    // No need to know what is below the last: it is wanted whole.
    if (id.level == level) break;
    const auto presence = presenceOf(id);
    if (!presence) return tl::unexpected(presence.error());
    if (!presence->stored && id.level == 0) return nullptr;
    const TileId below = tileOver(p, id.level + 1);
    if ((presence->childMask & (1u << below.quadrant())) == 0) break;
    id = below;
  }
  auto found = tile(id);
  if (!found) return found;
  if (*found == nullptr) {
    if (id.level == 0) return nullptr;
    return io::fail(io::Failure::Code::corrupt, fmt::format("{} is missing", nameOf(id)), source_->info().name);
  }
  hint.store(id.level, std::memory_order_relaxed);
  return found;
}

io::Result<QueryTiles::Pointer> QueryTiles::tile(const TileId& id) {
  return shardOf(id).tiles.get(
      id, [&] { return loaded(id); }, bytesOf);
}

io::Result<QueryTiles::Pointer> QueryTiles::loaded(const TileId& id) {
  auto source = source_->load(id);
  if (!source) return tl::unexpected(source.error());
  if (!*source) return nullptr;
  raster::SourceTile& found = **source;
  auto tile = std::make_shared<QueryTile>();
  tile->id = id;
  tile->childMask = found.childMask;
  if (auto* imagery = std::get_if<raster::ImageryTile>(&found.payload)) {
    tile->pixels = std::move(imagery->pixels);
    return Pointer(std::move(tile));
  }
  tile->error_m = static_cast<double>(found.statistics.error_m);
  tile->heights = withoutGutter(std::get<raster::ElevationTile>(found.payload).samples);
  if (auto ok = join(*tile); !ok) return tl::unexpected(ok.error());
  return Pointer(std::move(tile));
}

io::Result<raster::TilePresence> QueryTiles::presenceOf(const TileId& id) {
  const auto make = [&]() -> io::Result<PresenceCache::Pointer> {
    const auto told = source_->lookUp(id);
    if (!told) return tl::unexpected(told.error());
    return std::make_shared<const raster::TilePresence>(*told);
  };
  const auto found = shardOf(id).presences.get(id, make, [](const raster::TilePresence& p) { return sizeof(p); });
  if (!found) return tl::unexpected(found.error());
  return **found;
}

io::Result<bool> QueryTiles::isStored(const TileId& id) {
  if (id.level == 0) {
    const auto presence = presenceOf(id);
    if (!presence) return tl::unexpected(presence.error());
    return presence->stored;
  }
  const auto parent = presenceOf(id.parent());
  if (!parent) return tl::unexpected(parent.error());
  return (parent->childMask & (1u << id.quadrant())) != 0;
}

io::Result<void> QueryTiles::join(QueryTile& tile) {
  if (tile.id.level == 0 || !source_->info().isNested) return {};
  OpenBorder border;
  for (std::size_t k = 0; k < 4; ++k) {
    const auto beside = isStored(tiling_.edgeNeighbour(tile.id, tiling::kEdges[k]).tile);
    if (!beside) return tl::unexpected(beside.error());
    border.edges[k] = !*beside;
    const auto across = tiling_.cornerNeighbour(tile.id, tiling::kCorners[k]);
    if (!across) continue;
    const auto beyond = isStored(*across);
    if (!beyond) return tl::unexpected(beyond.error());
    border.corners[k] = !*beyond;
  }
  if (!border.any()) return {};
  const auto parent = this->tile(tile.id.parent());
  if (!parent) return tl::unexpected(parent.error());
  if (*parent == nullptr) {
    return io::fail(io::Failure::Code::corrupt, fmt::format("{} is missing", nameOf(tile.id.parent())),
                    source_->info().name);
  }
  const raster::Raster<float>& above = (*parent)->joined.samples.empty() ? (*parent)->heights : (*parent)->joined;
  raster::Raster<float> joined = joinedHeights(tile, above, border);
  tile.joinShift_m = largestDifference(joined, tile.heights);
  if (tile.joinShift_m > 0.0) tile.joined = std::move(joined);
  return {};
}

}  // namespace tellurion::pyramid
