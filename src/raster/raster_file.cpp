#include "raster/raster_file.h"

#include <fmt/format.h>
#include <gdal_priv.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "raster/colour_bands.h"
#include "raster/footprint.h"
#include "raster/gdal_session.h"
#include "raster/height_band.h"
#include "raster/line_sampling.h"
#include "raster/raster_places.h"
#include "raster/sampling.h"
#include "raster/tile_lines.h"
#include "raster/tile_places.h"

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;

constexpr int kMaxSide = 1 << 30;
/// Directions handled at a time: bounds the memory of a call.
constexpr std::size_t kBatch = 4096;

template <class Bands>
std::vector<GridTopology> topologies(const Bands& bands, const GridTopology& full) {
  std::vector<GridTopology> levels;
  for (const BandLevel& level : bands.levels()) {
    levels.push_back(levels.empty() ? full : full.scaledTo(level.width, level.height));
  }
  return levels;
}

io::Result<void> checkSize(GDALDataset& dataset, const std::string& path) {
  const int width = dataset.GetRasterXSize();
  const int height = dataset.GetRasterYSize();
  if (width >= 1 && height >= 1 && width <= kMaxSide && height <= kMaxSide) return {};
  return io::fail(Code::unsupported,
                  fmt::format("says that it has {} x {} pixels; at most 2^30 a side are read", width, height), path);
}

/// A kind of samples: the bands, and their pixels. The bands must not move once the store reads them.
template <class Bands, class T>
struct Samples {
  Bands bands;
  PixelStore<T> store;

  Samples(Bands b, const GridTopology& full, std::size_t cacheBytes)
      : bands(std::move(b)), store(topologies(bands, full), cacheBytes, [this](const Window& window, T* block) {
          return bands.read(window, block);
        }) {}
  Samples(const Samples&) = delete;
  Samples& operator=(const Samples&) = delete;
};

/// Some samples of a tile.
struct TileSamples {
  const tiling::Tiling& tiling;
  const tiling::TileId& id;
  Kind kind;
  int cells;
  std::span<const std::size_t> indices;
};

}  // namespace

struct RasterFile::State {
  DatasetPtr dataset;
  RasterInfo info;
  Placement placement;
  Footprint footprint;
  std::optional<Samples<HeightBand, float>> heights;
  std::optional<Samples<ColourBands, Rgba8>> colours;
  PixelPlaces places;
  bool toldOfImpossibleHeights = false;

  State(DatasetPtr d, RasterInfo i, Placement p)
      : dataset(std::move(d)), info(std::move(i)), placement(std::move(p)), footprint(placement) {
    info.bounds = footprint.bounds();
    info.finestSpacing = footprint.finestSpacing();
  }
  ~State() {
    const GdalMessages quiet;
    dataset.reset();
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  /// Runs one of the sampling rules over batches of directions.
  template <class T, class Rule>
  io::Result<void> sample(PixelStore<T>& store, std::span<const geo::Direction> directions, geo::Angle footprintSide,
                          std::span<T> out, const Rule& bilinear, const Rule& mean) {
    if (out.size() != directions.size()) {
      return io::fail(Code::invalidArgument, "as many samples as directions are needed", info.path);
    }
    for (std::size_t first = 0; first < directions.size(); first += kBatch) {
      const std::size_t count = std::min(kBatch, directions.size() - first);
      const auto batch = directions.subspan(first, count);
      const bool points = !(footprintSide.radians() > 0.0);
      if (points) {
        placement.pixels(batch, places);
      } else {
        placement.squares(batch, footprintSide, places);
      }
      if (!(points ? bilinear : mean)(store, places, out.subspan(first, count))) {
        return tl::unexpected(store.failure().value());
      }
    }
    return {};
  }

  io::Result<void> sampleTile(const PixelPlaces& tile, std::span<const std::size_t> indices, std::span<Rgba8> out) {
    const bool points = tile.width.empty();
    for (std::size_t first = 0; first < indices.size(); first += kBatch) {
      const auto batch = indices.subspan(first, std::min(kBatch, indices.size() - first));
      gather(tile.col, batch, places.col);
      gather(tile.row, batch, places.row);
      if (!points) {
        gather(tile.width, batch, places.width);
        gather(tile.height, batch, places.height);
      }
      if (!(points ? bilinearColours : meanColours)(colours->store, places, out.subspan(first, batch.size()))) {
        return tl::unexpected(colours->store.failure().value());
      }
    }
    return {};
  }

  /// Samples of a tile for which isOfLonLat() holds, those on lines first and then the others.
  template <class T>
  io::Result<void> sampleLines(PixelStore<T>& store, const TileSamples& tile, std::span<T> out) {
    if (!isOfLines(tile.id)) return samplePixels(store, tile, tile.indices, out);
    const PixelLines lines = pixelLines(placement, tile.tiling, tile.id, tile.kind, tile.cells);
    const std::size_t side = lines.col.size();
    const auto isLine = [&](std::size_t index) { return !std::isnan(lines.row[index / side]); };
    const auto first = std::ranges::find_if(tile.indices, isLine);
    const auto last = std::ranges::find_if_not(first, tile.indices.end(), isLine);
    const auto before = static_cast<std::size_t>(first - tile.indices.begin());
    const auto count = static_cast<std::size_t>(last - first);
    if (auto ok = samplePixels(store, tile, tile.indices.first(before), out.first(before)); !ok) return ok;
    if (!onLines(store, lines, tile.indices.subspan(before, count), out.subspan(before, count))) {
      return tl::unexpected(store.failure().value());
    }
    return samplePixels(store, tile, tile.indices.subspan(before + count), out.subspan(before + count));
  }

  template <class T>
  io::Result<void> samplePixels(PixelStore<T>& store, const TileSamples& tile, std::span<const std::size_t> indices,
                                std::span<T> out) {
    pixelsOfSamples(placement, tile.tiling, tile.id, tile.kind, tile.cells, indices, places);
    if (!atPlaces(store, places, out)) return tl::unexpected(store.failure().value());
    return {};
  }

  static bool onLines(PixelStore<float>& store, const PixelLines& lines, std::span<const std::size_t> indices,
                      std::span<float> out) {
    return bilinearHeightsOnLines(store, lines, indices, out);
  }
  static bool onLines(PixelStore<Rgba8>& store, const PixelLines& lines, std::span<const std::size_t> indices,
                      std::span<Rgba8> out) {
    return bilinearColoursOnLines(store, lines, indices, out);
  }
  static bool atPlaces(PixelStore<float>& store, const PixelPlaces& at, std::span<float> out) {
    return bilinearHeights(store, at, out);
  }
  static bool atPlaces(PixelStore<Rgba8>& store, const PixelPlaces& at, std::span<Rgba8> out) {
    return bilinearColours(store, at, out);
  }

  static void gather(const std::vector<double>& from, std::span<const std::size_t> indices, std::vector<double>& to) {
    to.resize(indices.size());
    std::ranges::transform(indices, to.begin(), [&](std::size_t i) { return from[i]; });
  }

  void tellOfImpossibleHeights() {
    if (toldOfImpossibleHeights || !heights->bands.metImpossibleHeights()) return;
    toldOfImpossibleHeights = true;
    info.warnings.emplace_back(
        "holds heights that its body cannot have: taken as NODATA; name the value with --nodata");
  }
};

RasterFile::RasterFile(std::unique_ptr<State> state) : state_(std::move(state)) {}
RasterFile::RasterFile(RasterFile&&) noexcept = default;
RasterFile& RasterFile::operator=(RasterFile&&) noexcept = default;
RasterFile::~RasterFile() = default;

io::Result<RasterFile> RasterFile::open(const std::string& path, Kind kind, const RasterOptions& options) {
  const GdalMessages messages;
  RasterInfo info;
  auto dataset = gdalOpen(path, info.warnings, options.sourcesAnywhere);
  if (!dataset) return tl::unexpected(std::move(dataset.error()));
  GDALDataset& data = **dataset;
  if (auto fit = checkSize(data, path); !fit) return tl::unexpected(std::move(fit.error()));
  info.path = path;
  info.files = filesOf(data);
  info.width = data.GetRasterXSize();
  info.height = data.GetRasterYSize();
  info.bands = data.GetRasterCount();
  auto reference = readGeoreference(data, path, options.body, info.warnings);
  if (!reference) return tl::unexpected(std::move(reference.error()));
  info.body = reference->body;
  info.bodyIsAssumed = reference->bodyIsAssumed;
  auto state = std::make_unique<State>(std::move(*dataset), std::move(info),
                                       Placement(std::move(*reference), data.GetRasterXSize(), data.GetRasterYSize()));
  if (!(state->info.finestSpacing.radians() > 0.0)) {
    return io::fail(Code::unsupported, "none of its pixels has a place on the body; is its spatial reference right?",
                    path);
  }
  const GridTopology& grid = state->placement.topology();
  std::vector<std::string>& warnings = state->info.warnings;
  if (kind == Kind::elevation) {
    auto band = HeightBand::open(data, path, options.nodata, state->info.body, warnings);
    if (!band) return tl::unexpected(std::move(band.error()));
    state->info.heightQuantum_m = band->quantum_m();
    state->heights.emplace(std::move(*band), grid, options.cacheBytes);
  } else {
    auto bands = ColourBands::open(data, path, options.nodata, warnings);
    if (!bands) return tl::unexpected(std::move(bands.error()));
    state->colours.emplace(std::move(*bands), grid, options.cacheBytes);
  }
  warnings.insert(warnings.end(), messages.warnings().begin(), messages.warnings().end());
  return RasterFile(std::move(state));
}

const RasterInfo& RasterFile::info() const {
  return state_->info;
}

bool RasterFile::mayTouch(const tiling::Tiling& tiling, const tiling::TileId& id, geo::Angle within) const {
  return state_->footprint.mayTouch(tiling, id, within);
}

io::Result<void> RasterFile::sampleHeights(std::span<const geo::Direction> directions, geo::Angle footprint,
                                           std::span<float> out) {
  if (!state_->heights) return io::fail(Code::invalidArgument, "was opened as imagery", state_->info.path);
  auto done = state_->sample(state_->heights->store, directions, footprint, out, bilinearHeights, meanHeights);
  state_->tellOfImpossibleHeights();
  return done;
}

io::Result<void> RasterFile::sampleColours(std::span<const geo::Direction> directions, geo::Angle footprint,
                                           std::span<Rgba8> out) {
  if (!state_->colours) return io::fail(Code::invalidArgument, "was opened as elevation", state_->info.path);
  return state_->sample(state_->colours->store, directions, footprint, out, bilinearColours, meanColours);
}

io::Result<void> RasterFile::sampleTile(const tiling::Tiling& tiling, const tiling::TileId& id, int cells,
                                        std::span<const std::size_t> indices, geo::Angle footprint,
                                        std::span<Rgba8> out) {
  if (!state_->colours) return io::fail(Code::invalidArgument, "was opened as elevation", state_->info.path);
  if (out.size() != indices.size()) {
    return io::fail(Code::invalidArgument, "as many samples as indices are needed", state_->info.path);
  }
  if (!(footprint.radians() > 0.0) && isOfLonLat(state_->placement, tiling) && isOfLines(id)) {
    return state_->sampleLines(state_->colours->store, {tiling, id, Kind::imagery, cells, indices}, out);
  }
  return state_->sampleTile(tilePixels(state_->placement, tiling, id, cells, footprint), indices, out);
}

io::Result<void> RasterFile::sampleTile(const tiling::Tiling& tiling, const tiling::TileId& id, int cells,
                                        std::span<const std::size_t> indices, geo::Angle footprint,
                                        std::span<float> out) {
  if (!state_->heights) return io::fail(Code::invalidArgument, "was opened as imagery", state_->info.path);
  if (out.size() != indices.size()) {
    return io::fail(Code::invalidArgument, "as many samples as indices are needed", state_->info.path);
  }
  if (!(footprint.radians() > 0.0) && isOfLonLat(state_->placement, tiling)) {
    auto done = state_->sampleLines(state_->heights->store, {tiling, id, Kind::elevation, cells, indices}, out);
    state_->tellOfImpossibleHeights();
    return done;
  }
  const int side = sideOf(Kind::elevation, cells);
  std::vector<geo::Direction> directions;
  directions.reserve(indices.size());
  for (const std::size_t index : indices) {
    const auto i = static_cast<int>(index);
    directions.push_back(*placeOf(tiling, id, Kind::elevation, cells, i % side, i / side));
  }
  return sampleHeights(directions, footprint, out);
}

}  // namespace tellurion::raster
