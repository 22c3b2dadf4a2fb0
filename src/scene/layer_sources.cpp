#include "scene/layer_sources.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <string_view>

#include "pyramid/pyramid_builder.h"
#include "pyramid/pyramid_reader.h"

namespace tellurion::scene {
namespace {

namespace fs = std::filesystem;
using SourcePointer = std::shared_ptr<const raster::TileSource>;

/// FNV-1a: names the file in the cache folder, keeps no secret.
std::uint64_t fingerprint(std::string_view text) {
  std::uint64_t hash = 14695981039346656037u;
  for (const char c : text)
    hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return hash;
}

/// Where the tile database of a raster is kept: another file, another time of change, another use is another database.
io::Result<fs::path> cachedDatabase(const std::string& path, raster::Kind kind, const Scene& scene) {
  std::error_code error;
  const fs::path whole = fs::canonical(path, error);
  if (error) return io::fail(io::Failure::Code::notFound, "there is no such file", path);
  const auto size = fs::file_size(whole, error);
  const auto changed = fs::last_write_time(whole, error).time_since_epoch().count();
  if (error) return io::fail(io::Failure::Code::ioError, "is not a plain file", path);
  const geo::Ellipsoid& e = scene.body.ellipsoid;
  const std::string key = fmt::format("1|{}|{}|{}|{}|{}|{}|{}", whole.string(), size, changed, raster::nameOf(kind),
                                      tiling::nameOf(scene.tiling), e.semiMajorAxis_m(), e.flattening());
  const fs::path folder = cacheFolder();
  fs::create_directories(folder, error);
  if (error)
    return io::fail(io::Failure::Code::ioError, "cannot make the cache folder; set XDG_CACHE_HOME", folder.string());
  return folder / fmt::format("{}_{:016x}.tdb", whole.stem().string(), fingerprint(key));
}

io::Result<SourcePointer> openDatabase(const fs::path& path) {
  auto reader = pyramid::PyramidReader::open(path);
  if (!reader) return tl::unexpected(std::move(reader.error()));
  return SourcePointer(std::move(*reader));
}

io::Result<SourcePointer> openSource(const std::string& path, raster::Kind kind, const Scene& scene,
                                     const BuildSink& progress) {
  if (isTileDatabase(path)) return openDatabase(path);
  auto database = cachedDatabase(path, kind, scene);
  if (!database) return tl::unexpected(std::move(database.error()));
  if (fs::exists(*database)) {
    if (auto cached = openDatabase(*database)) return cached;
  }
  const pyramid::BuildOptions options{
      .output = *database, .inputs = {path}, .kind = kind, .scheme = scene.tiling, .body = scene.body};
  const auto report = pyramid::buildPyramid(options, [&](const pyramid::BuildProgress& p) {
    if (progress && p.total > 0) progress(path, static_cast<double>(p.done) / static_cast<double>(p.total));
  });
  if (!report) return tl::unexpected(report.error());
  return openDatabase(*database);
}

}  // namespace

bool isTileDatabase(const std::string& path) {
  return fs::path(path).extension() == ".tdb";
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

io::Result<GlobeLayers> openLayers(const Scene& scene, const BuildSink& progress) {
  GlobeLayers layers;
  for (const ElevationLayer& layer : scene.elevation) {
    auto source = openSource(layer.source, raster::Kind::elevation, scene, progress);
    if (!source) return tl::unexpected(std::move(source.error()));
    layers.elevation.push_back(std::move(*source));
  }
  for (const ImageryLayer& layer : scene.imagery) {
    auto source = openSource(layer.source, raster::Kind::imagery, scene, progress);
    if (!source) return tl::unexpected(std::move(source.error()));
    layers.imagery.push_back(
        {.source = std::move(*source), .opacity = layer.opacity, .nightLights = layer.nightLights});
  }
  return layers;
}

}  // namespace tellurion::scene
