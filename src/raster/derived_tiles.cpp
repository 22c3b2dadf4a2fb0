#include "raster/derived_tiles.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "raster/height_block.h"
#include "raster/joint_preparation.h"
#include "raster/live_tiles.h"
#include "raster/nearest_tiles.h"
#include "raster/seam.h"
#include "raster/tile_places.h"

namespace tellurion::raster {
namespace {

using Source = std::shared_ptr<const TileSource>;

const Raster<float>& samplesOf(const SourceTile& tile) {
  return std::get<ElevationTile>(tile.payload).samples;
}

/// weightOf(column, row): how much a sample above counts over one below.
template <class WeightOf>
void layOver(Raster<float>& below, const Raster<float>& above, const WeightOf& weightOf) {
  for (int row = 0; row < below.height; ++row) {
    for (int column = 0; column < below.width; ++column) {
      const float height_m = above.at(column, row);
      if (isNoData(height_m)) continue;
      float& out_m = below.at(column, row);
      const double weight = isNoData(out_m) ? 1.0 : weightOf(column, row);
      out_m = weight >= 1.0
                  ? height_m
                  : static_cast<float>(std::lerp(static_cast<double>(out_m), static_cast<double>(height_m), weight));
    }
  }
}

/// The heights for one derived tile: for each of the elevation tiles that it has the pixels of, the deepest that is
/// there.
struct Ground {
  int across = 1;                                          ///< such tiles a side
  std::vector<std::shared_ptr<const HeightBlock>> blocks;  ///< of each, row by row; null: no heights
  std::vector<tiling::TileId> ids;                         ///< of the blocks
  std::uint8_t childMask = 0;
  bool hasOwn = false;  ///< one of them is there itself
};

class DerivedTiles final : public TileSource {
 public:
  DerivedTiles(const std::vector<DerivedHeights>& heights, HeightColours colours)
      : heights_(sourcesOf(heights)),
        seams_(heights.size()),
        colours_(std::move(colours)),
        tiling_(heights_.front()->info().scheme),
        cells_(heights_.front()->info().tileCells),
        deeper_(std::countr_zero(static_cast<unsigned>(kImageryPixels / cells_))) {
    for (std::size_t i = 0; i < heights.size(); ++i)
      widths_m_.push_back(heights[i].seam_m);
    info_ = heights_.front()->info();
    info_.kind = Kind::imagery;
    info_.tileCells = kImageryPixels;
    for (const Source& source : heights_) {
      info_.maxLevel = std::max(info_.maxLevel, source->info().maxLevel);
      info_.bounds = info_.bounds.united(source->info().bounds);
      tells_ = tells_ || source->presence({}).has_value();
    }
    info_.maxLevel = std::max(0, info_.maxLevel - deeper_);
    if (const auto* hillshade = std::get_if<Hillshade>(&colours_)) sun_ = sunOf(*hillshade);
  }

  const TileSourceInfo& info() const override { return info_; }

  std::optional<TilePresence> presence(const tiling::TileId& id) const override {
    if (!tells_) return std::nullopt;
    TilePresence out{.stored = id.level == 0 || holdsBelow(id, deeper_), .childMask = 0};
    for (int q = 0; q < 4 && out.stored && id.level < info_.maxLevel; ++q) {
      if (holdsBelow(id.child(q), deeper_)) out.childMask |= static_cast<std::uint8_t>(1u << q);
    }
    return out;
  }

  std::unique_ptr<Preparation> prepare(const tiling::TileId& id, double priority,
                                       std::function<void()> ready) const override {
    std::vector<JointPreparation::Part> parts;
    for (const Source& source : heights_) {
      std::unordered_set<tiling::TileId, tiling::TileIdHash> needed;
      for (const tiling::TileId& part : partsOf(id))
        addNeeds(*source, part, needed);
      for (const tiling::TileId& tile : needed) {
        parts.push_back([&source = *source, tile](double asked, std::function<void()> done) {
          return source.prepare(tile, asked, std::move(done));
        });
      }
    }
    return JointPreparation::begin(parts, priority, std::move(ready));
  }

  std::optional<io::Failure> complaint() const override {
    for (const Source& source : heights_)
      if (auto told = source->complaint()) return told;
    return std::nullopt;
  }

  io::Result<std::optional<SourceTile>> load(const tiling::TileId& id) const override {
    if (id.level > info_.maxLevel) return std::optional<SourceTile>{};
    auto ground = groundOf(id);
    if (!ground) return tl::unexpected(std::move(ground.error()));
    if (id.level > 0 && !ground->hasOwn) return std::optional<SourceTile>{};
    const int side = sideOf(Kind::imagery, kImageryPixels);
    Raster<Rgba8> pixels(side, side);
    for (int row = 0; row < side; ++row) {
      for (int column = 0; column < side; ++column)
        pixels.at(column, row) = pixel(*ground, id, column, row);
    }
    return std::optional(liveTile(std::move(pixels), ground->childMask));
  }

 private:
  TilePresence presenceIn(const TileSource& source, const tiling::TileId& id) const {
    if (auto told = source.presence(id)) return *told;
    const bool mayBe = id.level <= source.info().maxLevel && source.info().bounds.intersects(tiling_.bounds(id));
    return {.stored = mayBe, .childMask = static_cast<std::uint8_t>(id.level < source.info().maxLevel ? 15 : 0)};
  }

  /// Whether a source has a tile so many levels (1 or more: 0 as well) below this one.
  bool holdsBelow(const TileSource& source, const tiling::TileId& id, int levels) const {
    const TilePresence here = presenceIn(source, id);
    if (!here.stored || levels == 0) return here.stored;
    for (int q = 0; q < 4; ++q) {
      if (((here.childMask >> q) & 1u) == 0) continue;
      if (levels == 1 || holdsBelow(source, id.child(q), levels - 1)) return true;
    }
    return false;
  }
  bool holdsBelow(const tiling::TileId& id, int levels) const {
    return std::ranges::any_of(heights_, [&](const Source& source) { return holdsBelow(*source, id, levels); });
  }

  /// The elevation tiles whose cells are the pixels of a tile, row by row.
  std::vector<tiling::TileId> partsOf(const tiling::TileId& id) const {
    std::vector<tiling::TileId> out;
    const std::uint32_t across = 1u << deeper_;
    for (std::uint32_t row = 0; row < across; ++row) {
      for (std::uint32_t column = 0; column < across; ++column) {
        out.push_back(
            {static_cast<std::uint8_t>(id.level + deeper_), id.root, id.x * across + column, id.y * across + row});
      }
    }
    return out;
  }

  /// As far as a source tells: the tile that is looked at for a part, and the one that is when it turns out to be none.
  void addNeeds(const TileSource& source, const tiling::TileId& part,
                std::unordered_set<tiling::TileId, tiling::TileIdHash>& needed) const {
    int level = std::min<int>(part.level, source.info().maxLevel);
    for (; level >= 0; --level) {
      const auto told = source.presence(part.ancestor(level));
      if (!told) return;
      if (told->stored) break;
    }
    for (int each = level; each >= std::max(level - 1, 0); --each)
      needed.insert(part.ancestor(each));
  }

  io::Result<Ground> groundOf(const tiling::TileId& id) const {
    std::vector<NearestTiles> lookups;
    for (const Source& source : heights_)
      lookups.emplace_back(*source);
    std::unordered_map<tiling::TileId, std::shared_ptr<const HeightBlock>, tiling::TileIdHash> made;
    Ground out{.across = 1 << deeper_};
    const std::vector<tiling::TileId> parts = partsOf(id);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      std::vector<NearestTiles::Found> found;
      int level = -1;
      for (NearestTiles& lookup : lookups) {
        auto nearest = lookup.find(parts[i]);
        if (!nearest) return tl::unexpected(std::move(nearest.error()));
        level = std::max(level, nearest->level);
        if (nearest->level == parts[i].level && nearest->tile->childMask != 0) out.childMask |= childBit(i);
        found.push_back(std::move(*nearest));
      }
      out.hasOwn = out.hasOwn || level == parts[i].level;
      out.ids.push_back(parts[i].ancestor(std::max(level, 0)));
      auto& block = made[out.ids.back()];
      if (!block && level >= 0) block = blockOf(out.ids.back(), found);
      out.blocks.push_back(block);
    }
    return out;
  }

  /// Of the tile's child that holds a part.
  std::uint8_t childBit(std::size_t part) const {
    const std::size_t across = std::size_t{1} << deeper_;
    const std::size_t right = 2 * (part % across) / across;
    const std::size_t below = 2 * (part / across) / across;
    return static_cast<std::uint8_t>(1u << (right + 2 * below));
  }

  std::shared_ptr<const HeightBlock> blockOf(const tiling::TileId& id,
                                             const std::vector<NearestTiles::Found>& found) const {
    const int side = sideOf(Kind::elevation, cells_);
    Raster<float> heights(side, side, kNoData);
    for (std::size_t i = 0; i < found.size(); ++i) {
      const NearestTiles::Found& f = found[i];
      if (!f.tile) continue;
      const Raster<float>& samples = samplesOf(*f.tile);
      const Seam* seam = seamOf(i);
      layOver(heights, f.level == id.level ? samples : enlargedHeights(samples, id.ancestor(f.level), id),
              [&](int column, int row) {
                const auto place =
                    seam != nullptr ? placeOf(tiling_, id, Kind::elevation, cells_, column, row) : std::nullopt;
                return place ? seam->weight(*place) : 1.0;
              });
    }
    return std::make_shared<const HeightBlock>(tiling_, info_.body.ellipsoid, id, std::move(heights));
  }

  static std::vector<Source> sourcesOf(const std::vector<DerivedHeights>& heights) {
    std::vector<Source> sources;
    for (const DerivedHeights& each : heights)
      sources.push_back(each.source);
    return sources;
  }

  /// Null: it ends with a step, or nothing lies below it.
  const Seam* seamOf(std::size_t source) const {
    if (source == 0) return nullptr;
    const TileSource& own = *heights_[source];
    NearestTiles tiles(own);
    const auto told = [&](const tiling::TileId& id) {
      const auto presence = own.presence(id);
      return presence ? std::optional(presence->stored) : std::nullopt;
    };
    const auto nearest = [&](const tiling::TileId& id) { return tiles.find(id).value_or(NearestTiles::Found{}); };
    return seams_[source].get(own.info(), widths_m_[source], told, nearest);
  }

  Rgba8 pixel(const Ground& ground, const tiling::TileId& id, int column, int row) const {
    const auto partAt = [&](int i) {
      return std::clamp((i - kGutter) * ground.across / kImageryPixels, 0, ground.across - 1);
    };
    const auto part = static_cast<std::size_t>(partAt(row) * ground.across + partAt(column));
    const HeightBlock* block = ground.blocks[part].get();
    if (block == nullptr) return {};
    const tiling::TileId& at = ground.ids[part];
    const auto sample = [&](std::uint32_t tile, std::uint32_t within, int i) {
      const double place = tile + (i - kGutter + 0.5) / kImageryPixels;
      return (std::ldexp(place, at.level - id.level) - within) * cells_;
    };
    const double sampleColumn = sample(id.x, at.x, column);
    const double sampleRow = sample(id.y, at.y, row);
    if (const auto* palette = std::get_if<Palette>(&colours_)) {
      const auto height = block->height_m(sampleColumn, sampleRow);
      return height ? colourAt(palette->stops, *height) : Rgba8{};
    }
    const auto gradient = block->gradient(sampleColumn, sampleRow);
    const auto place = placeOf(tiling_, id, Kind::imagery, kImageryPixels, column, row);
    if (!gradient || !place) return {};
    const Rise rise = riseOf(*gradient, *place);
    if (const auto* hillshade = std::get_if<Hillshade>(&colours_)) return shadeOf(sun_, hillshade->exaggeration, rise);
    const auto& slope = std::get<SlopeColours>(colours_);
    return colourAt(slope.stops, slopeOf(rise, slope.exaggeration).degrees());
  }

  static Rise riseOf(const geo::Vec3& gradient, const geo::Direction& place) {
    const geo::Vec3 along(-place.n.y, place.n.x, 0.0);
    const double away = geo::length(along);
    const geo::Vec3 east = away > 0.0 ? along / away : geo::Vec3(0.0, 1.0, 0.0);
    return {.east = geo::dot(gradient, east), .north = geo::dot(gradient, geo::cross(place.n, east))};
  }

  std::vector<Source> heights_;
  std::vector<std::optional<double>> widths_m_;  ///< of the sources' seams
  mutable std::vector<LateSeam> seams_;          ///< a source each
  HeightColours colours_;
  tiling::Tiling tiling_;
  int cells_;
  int deeper_;  ///< levels from a tile to the elevation tiles whose cells are its pixels
  TileSourceInfo info_;
  bool tells_ = false;
  geo::Vec3 sun_{0.0};  ///< of a hillshade
};

/// Why a source cannot stand beside the first; nothing when it can.
std::optional<std::string> misfit(const TileSourceInfo& info, const TileSourceInfo& first) {
  if (info.kind != Kind::elevation) return "holds imagery; hillshade, slope and palette are made of heights";
  if (info.scheme != first.scheme)
    return fmt::format("is tiled as {}, the one before it as {}", tiling::nameOf(info.scheme),
                       tiling::nameOf(first.scheme));
  if (!(info.body.ellipsoid == first.body.ellipsoid))
    return fmt::format("is of the body {}, the one before it of {}", info.body.name, first.body.name);
  if (info.tileCells != first.tileCells)
    return fmt::format("has {} cells a side of a tile, the one before it {}", info.tileCells, first.tileCells);
  if (info.tileCells < 1 || info.tileCells > kImageryPixels ||
      !std::has_single_bit(static_cast<unsigned>(info.tileCells)))
    return fmt::format("has {} cells a side of a tile; a power of two up to {} is needed", info.tileCells,
                       kImageryPixels);
  return std::nullopt;
}

}  // namespace

io::Result<std::shared_ptr<const TileSource>> derivedTileSource(const std::vector<DerivedHeights>& heights,
                                                                HeightColours colours) {
  if (heights.empty()) return io::fail(io::Failure::Code::invalidArgument, "there are no heights to make colours of");
  for (const DerivedHeights& each : heights) {
    if (auto wrong = misfit(each.source->info(), heights.front().source->info()))
      return io::fail(io::Failure::Code::invalidArgument, std::move(*wrong), each.source->info().name);
  }
  return std::make_shared<const DerivedTiles>(heights, std::move(colours));
}

}  // namespace tellurion::raster
