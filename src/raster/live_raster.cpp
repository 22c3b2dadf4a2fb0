#include "raster/live_raster.h"

#include <algorithm>
#include <mutex>
#include <utility>
#include <vector>

#include "raster/live_tiles.h"
#include "raster/pool.h"
#include "raster/tile_places.h"

namespace tellurion::raster {
namespace {

constexpr std::size_t kMostIdle = 4;

class LiveRaster final : public TileSource {
 public:
  LiveRaster(RasterFile file, Kind kind, tiling::Scheme scheme, const LiveOptions& options)
      : options_(options),
        tiling_(scheme),
        spacing_(file.info().finestSpacing),
        idle_(kMostIdle),
        map_(std::move(file)) {
    const RasterInfo& raster = map_.info();
    info_ = {.name = raster.path,
             .kind = kind,
             .scheme = scheme,
             .body = raster.body,
             .tileCells = options.tileCells > 0 ? options.tileCells : usualCells(kind),
             .maxLevel = 0,
             .bounds = raster.bounds};
    info_.isNested = false;
    info_.maxLevel = levelOfSpacing(tiling_, info_.tileCells, spacing_, kind);
    options_.raster.cacheBytes /= kMostIdle;
  }

  const TileSourceInfo& info() const override { return info_; }

  std::optional<TilePresence> presence(const tiling::TileId& id) const override {
    const std::scoped_lock lock(mapMutex_);
    return livePresence(
        id, [this](const tiling::TileId& tile) { return map_.mayTouch(tiling_, tile); },
        [this](const tiling::TileId& tile) { return tile.level < info_.maxLevel; });
  }

  io::Result<std::optional<SourceTile>> load(const tiling::TileId& id) const override {
    const TilePresence presence = *this->presence(id);
    if (!presence.stored) return std::optional<SourceTile>{};
    return idle_.with([this] { return RasterFile::open(info_.name, info_.kind, options_.raster); },
                      [&](RasterFile& file) {
                        return info_.kind == Kind::elevation ? heights(file, id, presence)
                                                             : colours(file, id, presence);
                      });
  }

 private:
  /// Points where the raster's pixels are as large as samples.
  geo::Angle footprint(int level) const {
    const geo::Angle side = tiling_.metrics(level).meanEdge / info_.tileCells;
    return side > spacing_ ? side : geo::Angle();
  }

  template <class T>
  Raster<T> laidOut(std::span<const std::size_t> indices, std::span<const T> values, T empty) const {
    const int side = sideOf(info_.kind, info_.tileCells);
    Raster<T> samples(side, side, empty);
    for (std::size_t i = 0; i < values.size(); ++i)
      samples.samples[indices[i]] = values[i];
    return samples;
  }
  /// All samples, as what is not known yet.
  std::vector<bool> nothingKnown() const {
    const auto side = static_cast<std::size_t>(sideOf(info_.kind, info_.tileCells));
    return std::vector<bool>(side * side, false);
  }

  io::Result<std::optional<SourceTile>> heights(RasterFile& file, const tiling::TileId& id,
                                                const TilePresence& presence) const {
    auto samples = sampledHeights(file, id);
    if (!samples) return tl::unexpected(std::move(samples.error()));
    const bool hasData = std::ranges::any_of(samples->samples, [](float h) { return !isNoData(h); });
    if (!isNeeded(id, presence, hasData)) return std::optional<SourceTile>{};
    const auto departure_m = departure(file, id, presence, *samples);
    if (!departure_m) return tl::unexpected(departure_m.error());
    return std::optional(liveTile(std::move(*samples), presence.childMask, id, info_, *departure_m));
  }

  io::Result<Raster<float>> sampledHeights(RasterFile& file, const tiling::TileId& id) const {
    const OpenPlaces open = openPlaces(tiling_, id, info_.kind, info_.tileCells, nothingKnown());
    std::vector<float> heights(open.places.size(), kNoData);
    if (auto done = file.sampleHeights(open.places, footprint(id.level), heights); !done) {
      return tl::unexpected(std::move(done.error()));
    }
    return laidOut<float>(open.indices, heights, kNoData);
  }

  /// How far the next level departs from the tile; nothing where no place has data on both.
  io::Result<std::optional<double>> departure(RasterFile& file, const tiling::TileId& id, const TilePresence& presence,
                                              const Raster<float>& samples) const {
    double largest = -1.0;
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      if (((presence.childMask >> quadrant) & 1) == 0) continue;
      const auto child = sampledHeights(file, id.child(quadrant));
      if (!child) return tl::unexpected(child.error());
      largest = std::max(largest, departureOfChild(samples, quadrant, *child));
    }
    return largest >= 0.0 ? std::optional(largest) : std::nullopt;
  }

  io::Result<std::optional<SourceTile>> colours(RasterFile& file, const tiling::TileId& id,
                                                const TilePresence& presence) const {
    const auto open = openSamples(tiling_, id, info_.kind, info_.tileCells, nothingKnown());
    std::vector<Rgba8> pixels(open.size());
    auto done = file.sampleTile(tiling_, id, info_.tileCells, open, footprint(id.level), pixels);
    if (!done) return tl::unexpected(std::move(done.error()));
    if (!isNeeded(id, presence, std::ranges::any_of(pixels, [](const Rgba8& p) { return p.a != 0; }))) {
      return std::optional<SourceTile>{};
    }
    return std::optional(liveTile(laidOut<Rgba8>(open, pixels, Rgba8{}), presence.childMask));
  }

  /// presence() is conservative; a tile without data is there only for what is below it.
  static bool isNeeded(const tiling::TileId& id, const TilePresence& presence, bool hasData) {
    return id.level == 0 || presence.childMask != 0 || hasData;
  }

  LiveOptions options_;
  tiling::Tiling tiling_;
  geo::Angle spacing_;
  TileSourceInfo info_;
  mutable Pool<RasterFile> idle_;
  mutable std::mutex mapMutex_;
  RasterFile map_;  ///< for where it lies, which is asked while others load
};

}  // namespace

io::Result<std::shared_ptr<const TileSource>> liveRaster(const std::string& path, Kind kind, tiling::Scheme scheme,
                                                         const LiveOptions& options) {
  auto file = RasterFile::open(path, kind, options.raster);
  if (!file) return tl::unexpected(std::move(file.error()));
  return std::make_shared<const LiveRaster>(std::move(*file), kind, scheme, options);
}

}  // namespace tellurion::raster
