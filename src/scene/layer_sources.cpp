#include "scene/layer_sources.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <iterator>
#include <optional>
#include <string_view>
#include <thread>

#include "io/file_lock.h"
#include "pyramid/database_file.h"
#include "pyramid/pyramid_builder.h"
#include "pyramid/pyramid_reader.h"
#include "pyramid/remote_database.h"
#include "raster/grid_tile_source.h"
#include "raster/image_catalogue.h"
#include "raster/live_raster.h"
#include "raster/raster_file.h"
#include "raster/service.h"
#include "raster/service_url.h"
#include "raster/time_extent.h"
#include "scene/derived_layer.h"
#include "scene/layer_entry.h"

namespace tellurion::scene {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;
using SourcePointer = std::shared_ptr<const raster::TileSource>;

/// A raster as a layer of the scene: what is built of it, when it is not there yet.
io::Result<pyramid::BuildOptions> buildFor(const std::string& path, raster::Kind kind, const Scene& scene) {
  const auto file = raster::RasterFile::open(path, kind);
  if (!file) return tl::unexpected(file.error());
  const raster::RasterInfo& info = file->info();
  if (!info.bodyIsAssumed && !(info.body.ellipsoid == scene.body.ellipsoid)) {
    return io::fail(
        Code::invalidArgument,
        fmt::format("lies on {} by its spatial reference, the scene on {}; set the scene's body, or take the "
                    "layer out",
                    info.body.name, scene.body.name),
        path);
  }
  std::error_code error;
  const fs::path whole = fs::canonical(path, error);
  if (error) return io::fail(Code::notFound, "there is no such file", path);
  pyramid::BuildOptions options{
      .output = {}, .inputs = {whole.string()}, .kind = kind, .scheme = scene.tiling, .body = scene.body};
  const auto key = pyramid::keyOfBuild(options);
  if (!key) return tl::unexpected(key.error());
  const fs::path folder = cacheFolder();
  fs::create_directories(folder, error);
  if (error) return io::fail(Code::ioError, "cannot make the cache folder; set XDG_CACHE_HOME", folder.string());
  options.output = folder / fmt::format("{}_{}.tdb", whole.stem().string(), *key);
  return options;
}

fs::path withSuffix(const fs::path& path, const char* suffix) {
  fs::path result = path;
  result += suffix;
  return result;
}

/// Keeps other programs from building the same database while it is held. Waits while another program holds it, unless
/// a stop is asked for; `waiting` is called now and then meanwhile. Nothing where the file system knows no locks: the
/// builder itself then still notices another one.
std::optional<io::FileLock> buildLock(const fs::path& path, const std::function<void()>& waiting,
                                      const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    auto lock = io::FileLock::tryTake(path);
    if (!lock) return std::nullopt;
    if (*lock) return std::move(*lock);
    waiting();
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return std::nullopt;
}

io::Result<SourcePointer> openDatabase(const fs::path& path) {
  auto reader = pyramid::PyramidReader::open(path);
  if (!reader) return tl::unexpected(std::move(reader.error()));
  return SourcePointer(std::move(*reader));
}

tl::unexpected<io::Failure> stopped(const std::string& path) {
  return io::fail(Code::cancelled,
                  "stopped before its tile database in the cache was finished; the next run goes on where it was",
                  path);
}

/// Builds the database; what an earlier run left and does not open is built anew.
io::Result<void> build(const std::string& path, const pyramid::BuildOptions& options, const BuildSink& progress,
                       const std::stop_token& stop) {
  const auto sink = [&](const pyramid::BuildProgress& p) {
    if (progress && p.total > 0) progress(path, static_cast<double>(p.done) / static_cast<double>(p.total));
  };
  std::error_code error;
  fs::remove(options.output, error);
  auto report = pyramid::buildPyramid(options, sink, stop);
  if (!report && report.error().code == Code::corrupt && fs::remove(withSuffix(options.output, ".part"), error)) {
    report = pyramid::buildPyramid(options, sink, stop);
  }
  if (!report && report.error().code == Code::cancelled) return stopped(path);
  if (!report) return tl::unexpected(report.error());
  if (!progress) return {};
  for (const std::string& warning : report->warnings)
    progress(warning, kWarningShare);
  return {};
}

io::Result<SourcePointer> openSource(const std::string& path, raster::Kind kind, const Scene& scene,
                                     const BuildSink& progress, const std::stop_token& stop) {
  if (isTileDatabase(path)) return openDatabase(path);
  const auto options = buildFor(path, kind, scene);
  if (!options) return tl::unexpected(options.error());
  if (fs::exists(options->output)) {
    if (auto cached = openDatabase(options->output)) return cached;
  }
  const auto waiting = [&] {
    if (progress) progress(path + ", which another program builds", 0.0);
  };
  const auto lock = buildLock(withSuffix(options->output, ".lock"), waiting, stop);
  if (stop.stop_requested()) return stopped(path);
  if (fs::exists(options->output)) {  // the other program's, or one that does not open
    if (auto cached = openDatabase(options->output)) return cached;
  }
  if (auto ok = build(path, *options, progress, stop); !ok) return tl::unexpected(ok.error());
  return openDatabase(options->output);
}

/// What the services of a scene share.
struct ServiceUse {
  std::shared_ptr<io::Resources> resources;
  std::uint64_t imageBytes = 0;  ///< for each
};

LayerSource serviceSource(const raster::ServiceLayer& service, raster::Kind kind, const Scene& scene,
                          const ServiceUse& use) {
  if (pyramid::isRemoteDatabase(service.source) && service.type.empty()) {
    const auto known = std::ranges::find(scene.remoteContents, service.source,
                                         [](const auto& contents) { return contents->info().name; });
    const auto contents = known != scene.remoteContents.end() ? *known : nullptr;
    return {[url = service.source, contents, resources = use.resources]() -> io::Result<LayerSource::Pointer> {
              if (contents) return pyramid::remoteDatabase(contents, resources);
              return pyramid::openRemoteDatabase(url, resources);
            },
            raster::withoutSecrets(service.source)};
  }
  const auto opening = [service, kind, body = scene.body, scheme = scene.tiling,
                        use]() -> io::Result<LayerSource::Pointer> {
    auto grid = kind == raster::Kind::elevation ? raster::openHeights(service, body, *use.resources)
                                                : raster::openService(service, kind, body, *use.resources);
    if (!grid) return tl::unexpected(std::move(grid.error()));
    return raster::gridTileSource(std::move(*grid), scheme, use.resources, {.memoryBytes = use.imageBytes});
  };
  return {opening, raster::withoutSecrets(service.source)};
}

/// The latest that count of a server with more.
constexpr std::size_t kMostSteps = 20000;

/// The steps of a layer that follows the clock; its capabilities are asked for again by each, and found in the cache.
auto serviceSteps(const raster::ServiceLayer& service, const Scene& scene, const ServiceUse& use) {
  return [service, scene, use]() -> io::Result<std::vector<TimedSource>> {
    raster::ServiceLayer each = service;
    each.time.clear();
    const auto grid = raster::openService(each, raster::Kind::imagery, scene.body, *use.resources);
    if (!grid) return tl::unexpected(grid.error());
    std::vector<TimedSource> out;
    for (raster::TimeStep& step : raster::timeSteps(grid->times, kMostSteps)) {
      each.time = std::move(step.name);
      out.push_back({.time_s = step.time_s, .source = serviceSource(each, raster::Kind::imagery, scene, use)});
    }
    if (out.empty())
      return io::fail(Code::invalidArgument, "the layer has no times; take time = \"clock\" out",
                      raster::withoutSecrets(service.source));
    return out;
  };
}

io::Result<SourcePointer> openCatalogue(const std::string& path, raster::Kind kind, const Scene& scene,
                                        const BuildSink& progress) {
  auto catalogue = raster::openCatalogue(path, kind, scene.tiling);
  if (!catalogue) return tl::unexpected(std::move(catalogue.error()));
  for (const std::string& warning : catalogue->warnings) {
    if (progress) progress(warning, kWarningShare);
  }
  return std::move(catalogue->tiles);
}

template <class Layer>
io::Result<LayerSource> openLayer(const Layer& layer, raster::Kind kind, const Scene& scene, const ServiceUse& use,
                                  const BuildSink& progress, const std::stop_token& stop) {
  if constexpr (requires { layer.service; }) {
    if (layer.from == SourceKind::service) return serviceSource(layer.service, kind, scene, use);
  }
  auto source = [&]() -> io::Result<SourcePointer> {
    if (layer.from == SourceKind::live) return raster::liveRaster(layer.source, kind, scene.tiling);
    if (layer.from == SourceKind::catalogue) return openCatalogue(layer.source, kind, scene, progress);
    return openSource(layer.source, kind, scene, progress, stop);
  }();
  if (!source) return tl::unexpected(std::move(source.error()));
  return LayerSource(std::move(*source));
}

io::Result<std::vector<TimedSource>> openTimes(const ImageryLayer& layer, const Scene& scene, const ServiceUse& use,
                                               const BuildSink& progress, const std::stop_token& stop) {
  std::vector<TimedSource> steps;
  for (const TimedFile& file : layer.times) {
    auto source = openLayer(file, raster::Kind::imagery, scene, use, progress, stop);
    if (!source) return tl::unexpected(std::move(source.error()));
    steps.push_back({.time_s = file.time_s, .source = std::move(*source)});
  }
  return steps;
}

}  // namespace

bool isTileDatabase(const std::string& path) {
  return fs::path(path).extension() == ".tdb" || pyramid::isTileDatabaseFile(path);
}

fs::path cacheFolder() {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing in this program changes the environment.
  const auto variable = [](const char* name) -> std::string_view {
    return std::getenv(name) != nullptr ? std::getenv(name) : "";
  };
  if (const auto cache = variable("XDG_CACHE_HOME"); !cache.empty()) return fs::path(cache) / "tellurion";
  if (const auto home = variable("HOME"); !home.empty()) return fs::path(home) / ".cache" / "tellurion";
  return fs::temp_directory_path() / "tellurion";
}

io::ResourceOptions withCacheFile(io::ResourceOptions options) {
  if (!options.cacheFile.empty() || options.cacheBytes == 0) return options;
  std::error_code error;
  fs::create_directories(cacheFolder(), error);  // where that fails, the cache says so
  options.cacheFile = cacheFolder() / "online.db";
  return options;
}

io::Result<GlobeLayers> openLayers(const Scene& scene, const BuildSink& progress, const std::stop_token& stop,
                                   const io::ResourceOptions& online, std::uint64_t imageBytes,
                                   std::shared_ptr<io::Resources> resources) {
  GlobeLayers layers;
  layers.resources = std::move(resources);
  const auto isService = [](const auto& layer) { return layer.from == SourceKind::service; };
  const auto services =
      std::count_if(scene.elevation.begin(), scene.elevation.end(), isService) +
      std::count_if(scene.imagery.begin(), scene.imagery.end(), [&](const ImageryLayer& layer) {
        return isService(layer) || (layer.derived && layer.derived->of && isService(*layer.derived->of));
      });
  if (services > 0 && !layers.resources) layers.resources = std::make_shared<io::Resources>(withCacheFile(online));
  const ServiceUse use{.resources = layers.resources,
                       .imageBytes = imageBytes / static_cast<std::uint64_t>(std::max<std::ptrdiff_t>(services, 1))};
  const auto openImagery = [&](const ImageryLayer& layer,
                               const SharedSources& heights) -> io::Result<std::vector<LayerSource>> {
    if (layer.derived && !layer.derived->of)
      return derivedLayer(heights, layer.derived->colours, SharedSource::OpenedBy::layersOfItsOwn);
    auto own = layer.derived ? openLayer(*layer.derived->of, raster::Kind::elevation, scene, use, progress, stop)
                             : openLayer(layer, raster::Kind::imagery, scene, use, progress, stop);
    if (!own) return tl::unexpected(std::move(own.error()));
    if (!layer.derived) return std::vector{std::move(*own)};
    return derivedLayer({std::make_shared<SharedSource>(std::move(*own), 0.0)}, layer.derived->colours,
                        SharedSource::OpenedBy::thisLayer);
  };
  SharedSources heights;
  for (const ElevationLayer& layer : scene.elevation) {
    auto source = openLayer(layer, raster::Kind::elevation, scene, use, progress, stop);
    if (!source) return tl::unexpected(std::move(source.error()));
    heights.push_back(std::make_shared<SharedSource>(std::move(*source), layer.seam_m));
    layers.elevation.push_back(layerOf(heights.back()));
    layers.elevation.back().seam_m = layer.seam_m;
  }
  for (const ImageryLayer& layer : scene.imagery) {
    if (!layer.times.empty()) {
      auto steps = openTimes(layer, scene, use, progress, stop);
      if (!steps) return tl::unexpected(std::move(steps.error()));
      layers.imagery.push_back({.steps = std::move(*steps), .look = layer.look, .name = layer.name});
      continue;
    }
    if (layer.from == SourceKind::service && layer.service.time == kClockTime) {
      layers.imagery.push_back({.source = serviceSource(layer.service, raster::Kind::imagery, scene, use),
                                .openSteps = serviceSteps(layer.service, scene, use),
                                .look = layer.look,
                                .name = layer.name});
      continue;
    }
    auto sources = openImagery(layer, heights);
    if (!sources) return tl::unexpected(std::move(sources.error()));
    layers.imagery.push_back({.source = std::move(sources->front()), .look = layer.look, .name = layer.name});
    std::move(sources->begin() + 1, sources->end(), std::back_inserter(layers.imagery.back().alsoFrom));
    for (const std::string& path : layer.alsoFrom) {
      auto further = openSource(path, raster::Kind::imagery, scene, progress, stop);
      if (!further) return tl::unexpected(std::move(further.error()));
      layers.imagery.back().alsoFrom.push_back(std::move(*further));
    }
  }
  return layers;
}

}  // namespace tellurion::scene
