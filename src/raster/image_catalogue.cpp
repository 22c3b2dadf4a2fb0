#include "raster/image_catalogue.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <optional>
#include <utility>

#include "io/executor.h"
#include "raster/colour.h"
#include "raster/image_tree.h"
#include "raster/live_tiles.h"
#include "raster/open_files.h"
#include "raster/tile_places.h"

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;

constexpr std::size_t kMostImages = 1'000'000;
constexpr std::size_t kMostWarnings = 100;
/// Across a tile; smaller images are not drawn.
constexpr int kLeastShare = 16;

/// Files that lie beside rasters and are read with them.
bool isSideFile(const std::filesystem::path& path) {
  static constexpr std::array kEndings{".xml", ".ovr", ".msk", ".prj", ".tfw", ".jgw", ".pgw",
                                       ".wld", ".gfw", ".txt", ".md",  ".hdr", ".tdb", ".toml"};
  return std::ranges::find(kEndings, path.extension()) != kEndings.end();
}

io::Result<std::vector<std::string>> filesIn(const std::filesystem::path& folder) {
  std::vector<std::string> files;
  std::error_code error;
  const auto skip = std::filesystem::directory_options::skip_permission_denied;
  for (std::filesystem::recursive_directory_iterator at(folder, skip, error), end; !error && at != end;
       at.increment(error)) {
    if (!at->is_regular_file(error) || isSideFile(at->path())) continue;
    if (files.size() >= kMostImages) {
      return io::fail(Code::unsupported, fmt::format("holds more than {} files", kMostImages), folder.string());
    }
    files.push_back(at->path().string());
  }
  if (error) return io::fail(Code::ioError, "cannot be read (" + error.message() + ")", folder.string());
  std::ranges::sort(files);
  return files;
}

io::Result<std::vector<std::string>> filesNamedBy(const std::filesystem::path& list) {
  std::ifstream text(list);
  if (!text) return io::fail(Code::notFound, "there is no such file or folder", list.string());
  std::vector<std::string> files;
  for (std::string line; std::getline(text, line);) {
    line.erase(std::min(line.find('#'), line.size()));
    const std::size_t last = line.find_last_not_of(" \t\r");
    if (last == std::string::npos) continue;
    line.erase(last + 1);
    line.erase(0, line.find_first_not_of(" \t"));
    if (files.size() >= kMostImages) {
      return io::fail(Code::unsupported, fmt::format("names more than {} files", kMostImages), list.string());
    }
    files.push_back((list.parent_path() / line).string());
  }
  return files;
}

/// What is known of a file from its header.
struct Entry {
  std::string path;
  geo::Angle spacing;
};

struct Header {
  std::optional<RasterInfo> info;
  io::Failure failure;
};

/// All headers, in the order of the files.
std::vector<Header> readHeaders(const std::vector<std::string>& files, Kind kind, const CatalogueOptions& options) {
  std::vector<Header> headers(files.size());
  std::mutex mutex;
  std::condition_variable done;
  std::size_t left = files.size();
  io::Executor executor(options.threads);
  for (std::size_t i = 0; i < files.size(); ++i) {
    executor.submit(0.0, [&, i] {
      const auto file = RasterFile::open(files[i], kind, options.raster);
      if (file) {
        headers[i].info = file->info();
      } else {
        headers[i].failure = file.error();
      }
      const std::scoped_lock lock(mutex);
      if (--left == 0) done.notify_all();
    });
  }
  std::unique_lock lock(mutex);
  done.wait(lock, [&] { return left == 0; });
  return headers;
}

/// How samples of images that lie on each other become one, from the finest down.
bool isDone(float height) {
  return !isNoData(height);
}
bool isDone(const Rgba8& pixel) {
  return pixel.a == 255;
}
bool hasData(float height) {
  return !isNoData(height);
}
bool hasData(const Rgba8& pixel) {
  return pixel.a != 0;
}
float laidOver(float above, float below) {
  return isNoData(above) ? below : above;
}
Rgba8 laidOver(const Rgba8& above, const Rgba8& below) {
  return above.a == 0 ? below : over(above, below);
}
io::Result<void> sampleFile(RasterFile& file, std::span<const geo::Direction> places, geo::Angle footprint,
                            std::span<float> out) {
  return file.sampleHeights(places, footprint, out);
}
io::Result<void> sampleFile(RasterFile& file, std::span<const geo::Direction> places, geo::Angle footprint,
                            std::span<Rgba8> out) {
  return file.sampleColours(places, footprint, out);
}

class CatalogueTiles final : public TileSource {
 public:
  CatalogueTiles(TileSourceInfo info, std::vector<Entry> entries, ImageTree tree, const CatalogueOptions& options)
      : info_(std::move(info)),
        tiling_(info_.scheme),
        entries_(std::move(entries)),
        tree_(std::move(tree)),
        raster_(options.raster),
        files_(std::max<std::size_t>(options.openFiles, 1)) {
    raster_.cacheBytes /= std::max<std::size_t>(options.openFiles, 1);
  }

  const TileSourceInfo& info() const override { return info_; }

  std::optional<TilePresence> presence(const tiling::TileId& id) const override {
    return livePresence(
        id, [this](const tiling::TileId& tile) { return tree_.isTouched(tile, tile.level); },
        [](const tiling::TileId& tile) { return tile.level < tiling::kMaxLevel; });
  }

  io::Result<std::optional<SourceTile>> load(const tiling::TileId& id) const override {
    const TilePresence presence = *this->presence(id);
    if (!presence.stored) return std::optional<SourceTile>{};
    if (info_.kind == Kind::elevation) {
      return made<float>(id, presence, kNoData, [&](Raster<float> samples) {
        return liveTile(std::move(samples), presence.childMask, id, info_);
      });
    }
    return made<Rgba8>(id, presence, Rgba8{},
                       [&](Raster<Rgba8> pixels) { return liveTile(std::move(pixels), presence.childMask); });
  }

 private:
  /// Images that may be seen in a tile, the finest first, of equally fine ones the later first.
  std::vector<int> imagesOf(const tiling::TileId& id) const {
    std::vector<int> images = tree_.touching(id, tiling_.metrics(id.level).meanEdge / kLeastShare);
    std::ranges::sort(images, [this](int a, int b) {
      const geo::Angle fineA = entries_[static_cast<std::size_t>(a)].spacing;
      const geo::Angle fineB = entries_[static_cast<std::size_t>(b)].spacing;
      return fineA < fineB || (fineA == fineB && a > b);
    });
    return images;
  }

  /// Of the samples that are still open, lays those that an image has under what is there.
  template <class T>
  io::Result<void> layUnder(int image, geo::Angle side, std::vector<std::size_t>& open, const OpenPlaces& places,
                            std::vector<T>& values, T empty) const {
    const Entry& entry = entries_[static_cast<std::size_t>(image)];
    const tiling::Cap& cap = tree_.image(image).cap;
    const double farthest = std::cos(std::min(cap.radius.radians() + 1e-9, geo::kPi));
    std::vector<std::size_t> within;
    std::vector<geo::Direction> directions;
    for (const std::size_t i : open) {
      // Too rough for small images, but those lie within one tile.
      if (geo::dot(places.places[i].n, cap.centre.n) < farthest - 1e-12) continue;
      within.push_back(i);
      directions.push_back(places.places[i]);
    }
    if (within.empty()) return {};
    std::vector<T> found(within.size(), empty);
    auto done = files_.with(
        image, [&] { return RasterFile::open(entry.path, info_.kind, raster_); },
        [&](RasterFile& file) {
          return sampleFile(file, directions, side > entry.spacing ? side : geo::Angle(), found);
        });
    if (!done) return done;
    for (std::size_t i = 0; i < within.size(); ++i)
      values[within[i]] = laidOver(values[within[i]], found[i]);
    std::erase_if(open, [&](std::size_t i) { return isDone(values[i]); });
    return {};
  }

  template <class T, class Finish>
  io::Result<std::optional<SourceTile>> made(const tiling::TileId& id, const TilePresence& presence, T empty,
                                             const Finish& finish) const {
    const int side = sideOf(info_.kind, info_.tileCells);
    Raster<T> samples(side, side, empty);
    const OpenPlaces places =
        openPlaces(tiling_, id, info_.kind, info_.tileCells, std::vector<bool>(samples.samples.size(), false));
    std::vector<T> values(places.places.size(), empty);
    std::vector<std::size_t> open(values.size());
    for (std::size_t i = 0; i < open.size(); ++i)
      open[i] = i;
    const geo::Angle spacing = tiling_.metrics(id.level).meanEdge / info_.tileCells;
    bool addsDetail = false;
    for (const int image : imagesOf(id)) {
      if (open.empty()) break;
      const std::size_t before = open.size();
      const auto laid = layUnder(image, spacing, open, places, values, empty);
      if (!laid) return tl::unexpected(laid.error());
      addsDetail = addsDetail || (open.size() < before && tree_.image(image).deepestLevel >= id.level);
    }
    const bool hasPart = std::ranges::any_of(open, [&](std::size_t i) { return hasData(values[i]); });
    if (id.level > 0 && presence.childMask == 0 && !addsDetail && !hasPart) return std::optional<SourceTile>{};
    for (std::size_t i = 0; i < values.size(); ++i)
      samples.samples[places.indices[i]] = values[i];
    return std::optional(finish(std::move(samples)));
  }

  TileSourceInfo info_;
  tiling::Tiling tiling_;
  std::vector<Entry> entries_;
  ImageTree tree_;
  RasterOptions raster_;
  mutable OpenFiles files_;
};

}  // namespace

io::Result<ImageCatalogue> openCatalogue(const std::string& source, Kind kind, tiling::Scheme scheme,
                                         const CatalogueOptions& options) {
  std::error_code error;
  const auto files = std::filesystem::is_directory(source, error) ? filesIn(source) : filesNamedBy(source);
  if (!files) return tl::unexpected(files.error());
  ImageCatalogue catalogue;
  const auto warn = [&](const std::string& path, const std::string& message) {
    if (catalogue.warnings.size() < kMostWarnings) catalogue.warnings.push_back(path + ": " + message);
  };
  TileSourceInfo info{.name = source,
                      .kind = kind,
                      .scheme = scheme,
                      .tileCells = options.tileCells > 0 ? options.tileCells : usualCells(kind)};
  info.isNested = false;
  const tiling::Tiling tiling(scheme);
  std::vector<Entry> entries;
  ImageTree tree(scheme);
  for (const Header& header : readHeaders(*files, kind, options)) {
    if (!header.info) {
      warn(header.failure.where, header.failure.message);
      continue;
    }
    const RasterInfo& raster = *header.info;
    if (!entries.empty() && raster.body != info.body) {
      warn(raster.path, fmt::format("lies on {} and not on {}", raster.body.name, info.body.name));
      continue;
    }
    info.body = raster.body;
    info.bounds = entries.empty() ? raster.bounds : info.bounds.united(raster.bounds);
    const int deepest = levelOfSpacing(tiling, info.tileCells, raster.finestSpacing, kind);
    info.maxLevel = std::max(info.maxLevel, deepest);
    tree.insert({.bounds = raster.bounds, .cap = capAround(raster.bounds), .deepestLevel = deepest});
    entries.push_back({raster.path, raster.finestSpacing});
  }
  if (entries.empty()) {
    return io::fail(
        Code::notFound,
        catalogue.warnings.empty() ? "names no files" : "no raster in it can be opened; " + catalogue.warnings.front(),
        source);
  }
  catalogue.images = entries.size();
  catalogue.tiles =
      std::make_shared<const CatalogueTiles>(std::move(info), std::move(entries), std::move(tree), options);
  return catalogue;
}

}  // namespace tellurion::raster
