#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include "pyramid/pyramid_reader.h"
#include "pyramid/remote_database.h"
#include "raster/raster_file.h"
#include "raster/raster_kind.h"
#include "raster/service_url.h"
#include "scene/layer_entry.h"
#include "scene/layer_sources.h"
#include "scene/scene_file.h"
#include "scene/scene_setting.h"

namespace tellurion::scene {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;

constexpr std::uintmax_t kLargestSceneFile = 1u << 20;

io::Result<Scene> readSceneFile(const std::string& path, std::span<const std::string> settings) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) return io::fail(Code::notFound, "there is no such scene file", path);
  if (size > kLargestSceneFile) return io::fail(Code::invalidArgument, "a scene file has at most 1 MiB", path);
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) return io::fail(Code::ioError, "the scene file cannot be read", path);
  return parseScene(text.str(), path, settings);
}

/// What a single source says about itself.
struct SourceFacts {
  std::string path;
  raster::Kind kind = raster::Kind::elevation;
  std::optional<geo::Body> body;         ///< nothing: any (a raster without a spatial reference)
  std::optional<tiling::Scheme> tiling;  ///< nothing: any (a raster)
  std::shared_ptr<const pyramid::RemoteContents> remote;
};

io::Result<SourceFacts> remoteFacts(const std::string& url, const io::ResourceOptions& online) {
  io::Resources resources(withCacheFile(online));
  auto contents = pyramid::askRemoteContents(url, resources);
  if (!contents)
    return io::fail(contents.error().code, contents.error().message, raster::withoutSecrets(contents.error().where));
  const raster::TileSourceInfo& info = (*contents)->info();
  return SourceFacts{
      .path = url, .kind = info.kind, .body = info.body, .tiling = info.scheme, .remote = std::move(*contents)};
}

io::Result<SourceFacts> factsOf(const std::string& path, const io::ResourceOptions& online) {
  if (pyramid::isRemoteDatabase(path)) return remoteFacts(path, online);
  if (isTileDatabase(path)) {
    const auto reader = pyramid::PyramidReader::open(path);
    if (!reader) return tl::unexpected(reader.error());
    const raster::TileSourceInfo& info = (*reader)->info();
    return SourceFacts{.path = path, .kind = info.kind, .body = info.body, .tiling = info.scheme};
  }
  std::error_code error;
  if (!fs::exists(path, error)) return io::fail(Code::notFound, "there is no such file", path);
  const auto kind = raster::kindOfRaster(path);
  if (!kind) return tl::unexpected(kind.error());
  const auto file = raster::RasterFile::open(path, *kind);
  if (!file) return tl::unexpected(file.error());
  SourceFacts facts{.path = path, .kind = *kind};
  if (!file->info().bodyIsAssumed) facts.body = file->info().body;
  return facts;
}

std::vector<std::string> splitAtCommas(std::string_view text) {
  std::vector<std::string> parts;
  for (;;) {
    const auto comma = text.find(',');
    parts.emplace_back(text.substr(0, comma));
    if (comma == std::string_view::npos) return parts;
    text.remove_prefix(comma + 1);
  }
}

/// Body and tiling that all layers agree on.
io::Result<void> settle(const std::vector<SourceFacts>& layers, Scene& scene) {
  std::optional<geo::Body> body;
  std::optional<tiling::Scheme> scheme;
  for (const SourceFacts& layer : layers) {
    if (body && layer.body && !(layer.body->ellipsoid == body->ellipsoid)) {
      return io::fail(Code::invalidArgument,
                      fmt::format("is of the body {}, the layers before it of {}", layer.body->name, body->name),
                      raster::withoutSecrets(layer.path));
    }
    if (scheme && layer.tiling && *layer.tiling != *scheme) {
      return io::fail(Code::invalidArgument,
                      fmt::format("is tiled as {}, the layers before it as {}; build it again with --tiling {}",
                                  tiling::nameOf(*layer.tiling), tiling::nameOf(*scheme), tiling::nameOf(*scheme)),
                      raster::withoutSecrets(layer.path));
    }
    if (!body) body = layer.body;
    if (!scheme) scheme = layer.tiling;
  }
  scene.body = body.value_or(scene.body);
  scene.tiling = scheme.value_or(scene.tiling);
  return {};
}

Scene sceneOf(const raster::ServiceLayer& service) {
  Scene scene{.name = raster::withoutSecrets(service.source)};
  if (!service.layer.empty()) scene.name += "#" + service.layer;
  scene.imagery.push_back({.source = service.source, .from = SourceKind::service, .service = service});
  return scene;
}

/// The layers as a scene file has them, and what is set of them.
io::Result<Scene> withSettings(Scene scene, std::span<const std::string> settings) {
  if (settings.empty()) return scene;
  std::string text;
  for (const ElevationLayer& layer : scene.elevation)
    text += fmt::format("[[elevation]]\nsource = {}\n", tomlText(layer.source));
  for (const ImageryLayer& layer : scene.imagery) {
    text += fmt::format("[[imagery]]\nsource = {}\n", tomlText(layer.source));
    if (!layer.service.layer.empty()) text += fmt::format("layer = {}\n", tomlText(layer.service.layer));
  }
  scene.elevation.clear();
  scene.imagery.clear();
  return parseScene(text, {}, settings, std::move(scene));
}

}  // namespace

io::Result<Scene> openScene(std::string_view argument, std::span<const std::string> settings,
                            const io::ResourceOptions& online) {
  if (argument.empty()) return io::fail(Code::invalidArgument, "the scene has no name");
  const bool beginsWithDatabase = pyramid::isRemoteDatabase(splitAtCommas(argument).front());
  if (isServiceUrl(argument) && !beginsWithDatabase) return withSettings(sceneOf(serviceFromUrl(argument)), settings);
  if (argument.ends_with(".toml")) return readSceneFile(std::string(argument), settings);
  std::error_code error;
  const bool isOneFile = fs::exists(fs::path(argument), error);
  std::vector<SourceFacts> layers;
  for (const std::string& path : isOneFile ? std::vector{std::string(argument)} : splitAtCommas(argument)) {
    if (path.empty()) {
      return io::fail(Code::invalidArgument, "a name is missing before or after a comma; add it, or take the comma out",
                      std::string(argument));
    }
    auto facts = factsOf(path, online);
    if (!facts) return tl::unexpected(std::move(facts.error()));
    layers.push_back(std::move(*facts));
  }
  Scene scene{.name = raster::withoutSecrets(argument)};
  const auto settled = settle(layers, scene);
  if (!settled) return tl::unexpected(settled.error());
  for (const SourceFacts& layer : layers) {
    const bool isRemote = layer.remote != nullptr;
    if (isRemote) scene.remoteContents.push_back(layer.remote);
    const SourceKind from = isRemote ? SourceKind::service : SourceKind::file;
    const raster::ServiceLayer service{.source = isRemote ? layer.path : std::string()};
    if (layer.kind == raster::Kind::elevation) {
      scene.elevation.push_back({.source = layer.path, .from = from, .service = service});
    } else {
      scene.imagery.push_back({.source = layer.path, .from = from, .service = service});
    }
  }
  return withSettings(std::move(scene), settings);
}

}  // namespace tellurion::scene
