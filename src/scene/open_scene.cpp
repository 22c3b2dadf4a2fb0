#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "pyramid/pyramid_reader.h"
#include "raster/raster_file.h"
#include "raster/raster_kind.h"
#include "scene/layer_sources.h"
#include "scene/scene_file.h"

namespace tellurion::scene {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;

constexpr std::uintmax_t kLargestSceneFile = 1u << 20;

io::Result<Scene> readSceneFile(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) return io::fail(Code::notFound, "there is no such scene file", path);
  if (size > kLargestSceneFile) return io::fail(Code::invalidArgument, "a scene file has at most 1 MiB", path);
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) return io::fail(Code::ioError, "the scene file cannot be read", path);
  return parseScene(text.str(), path);
}

/// What a single source says about itself.
struct SourceFacts {
  raster::Kind kind = raster::Kind::elevation;
  geo::Body body = geo::earth();
  std::optional<tiling::Scheme> tiling;  ///< nothing: any (a raster)
};

io::Result<SourceFacts> factsOf(const std::string& path) {
  std::error_code error;
  if (!fs::exists(path, error)) return io::fail(Code::notFound, "there is no such file", path);
  if (isTileDatabase(path)) {
    const auto reader = pyramid::PyramidReader::open(path);
    if (!reader) return tl::unexpected(reader.error());
    const raster::TileSourceInfo& info = (*reader)->info();
    return SourceFacts{.kind = info.kind, .body = info.body, .tiling = info.scheme};
  }
  const auto kind = raster::kindOfRaster(path);
  if (!kind) return tl::unexpected(kind.error());
  const auto file = raster::RasterFile::open(path, *kind);
  if (!file) return tl::unexpected(file.error());
  return SourceFacts{.kind = *kind, .body = file->info().body};
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

}  // namespace

io::Result<Scene> openScene(std::string_view argument) {
  if (argument.ends_with(".toml")) return readSceneFile(std::string(argument));
  std::error_code error;
  const bool isOneFile = fs::exists(fs::path(argument), error);
  Scene scene{.name = std::string(argument)};
  bool hasBody = false;
  bool hasTiling = false;
  for (const std::string& path : isOneFile ? std::vector{std::string(argument)} : splitAtCommas(argument)) {
    const auto facts = factsOf(path);
    if (!facts) return tl::unexpected(facts.error());
    if (hasBody && !(facts->body.ellipsoid == scene.body.ellipsoid)) {
      return io::fail(Code::invalidArgument,
                      fmt::format("is of the body {}, the layers before it of {}", facts->body.name, scene.body.name),
                      path);
    }
    if (hasTiling && facts->tiling && *facts->tiling != scene.tiling) {
      return io::fail(
          Code::invalidArgument,
          fmt::format("is tiled as {}, the layers before it as {}; build it again with --tiling {}",
                      tiling::nameOf(*facts->tiling), tiling::nameOf(scene.tiling), tiling::nameOf(scene.tiling)),
          path);
    }
    scene.body = facts->body;
    hasBody = true;
    scene.tiling = facts->tiling.value_or(scene.tiling);
    hasTiling = hasTiling || facts->tiling.has_value();
    if (facts->kind == raster::Kind::elevation) {
      scene.elevation.push_back({.source = path});
    } else {
      scene.imagery.push_back({.source = path});
    }
  }
  return scene;
}

}  // namespace tellurion::scene
