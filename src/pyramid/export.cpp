#include "pyramid/export.h"

#include <fmt/format.h>

#include <array>
#include <limits>
#include <utility>

#include "pyramid/export_run.h"

namespace tellurion::pyramid {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;

constexpr std::array<std::pair<std::string_view, ExportFormat>, 6> kFormats{
    {{"geotiff", ExportFormat::geotiff},
     {"cog", ExportFormat::cog},
     {"geopackage", ExportFormat::geopackage},
     {"mbtiles", ExportFormat::mbtiles},
     {"xyz", ExportFormat::xyz},
     {"quantized-mesh", ExportFormat::quantizedMesh}}};

bool isTileSet(ExportFormat format) {
  return format == ExportFormat::mbtiles || format == ExportFormat::xyz;
}

io::Result<void> checkRaster(const ExportOptions& options) {
  if (options.minLevel) {
    return io::fail(Code::invalidArgument,
                    fmt::format("{} has one size of pixels; give the level that they are as fine as alone",
                                nameOf(options.format)));
  }
  if (options.format == ExportFormat::geotiff && options.pixels != raster::ImageFormat::png) {
    return io::fail(Code::invalidArgument, "a GeoTIFF is written without loss; the format cog takes jpeg and webp");
  }
  return {};
}

io::Result<void> checkTileSet(const ExportOptions& options, const raster::TileSourceInfo& info) {
  if (info.kind == raster::Kind::elevation) {
    return io::fail(Code::unsupported,
                    fmt::format("holds elevation, and {} holds pictures; heights are exported as geotiff, cog, "
                                "geopackage or quantized-mesh",
                                nameOf(options.format)),
                    info.name);
  }
  const bool isMercator = options.format == ExportFormat::mbtiles || options.scheme == MapScheme::mercator;
  if (isMercator && !(info.body == geo::earth())) {
    return io::fail(Code::unsupported,
                    fmt::format("lies on {}, and Web Mercator is a map of Earth alone; export it as xyz with the "
                                "scheme geodetic, as cog or as geopackage",
                                info.body.name),
                    info.name);
  }
  return {};
}

io::Result<void> checkTerrain(const ExportOptions& options, const raster::TileSourceInfo& info) {
  if (info.kind == raster::Kind::imagery) {
    return io::fail(Code::unsupported, "holds imagery, and quantized-mesh holds heights; export it as mbtiles or xyz",
                    info.name);
  }
  if (!(info.body == geo::earth())) {
    return io::fail(
        Code::unsupported,
        fmt::format("lies on {}, and quantized-mesh is of Earth's ellipsoid alone; export it as geotiff, cog "
                    "or geopackage",
                    info.body.name),
        info.name);
  }
  if (options.minLevel.value_or(0) == 0) return {};
  return io::fail(Code::invalidArgument, "quantized-mesh begins at zoom 0; give the last zoom alone");
}

io::Result<ExportReport> exportAs(const ExportRun& run, ExportPlace& place) {
  switch (run.options.format) {
    case ExportFormat::geotiff:
    case ExportFormat::cog:
    case ExportFormat::geopackage:
      return exportRaster(run, place);
    case ExportFormat::mbtiles:
    case ExportFormat::xyz:
      return exportTiles(run, place);
    case ExportFormat::quantizedMesh:
      return exportTerrain(run, place);
  }
  return {};
}

io::Result<void> check(const ExportOptions& options, const raster::TileSourceInfo& info) {
  const bool isAscending = options.minLevel.value_or(0) >= 0 && options.maxLevel.value_or(kMostZoom) <= kMostZoom &&
                           options.minLevel.value_or(0) <= options.maxLevel.value_or(kMostZoom);
  if (!isAscending) {
    return io::fail(Code::invalidArgument, fmt::format("levels run from 0 to {}, the coarser one first", kMostZoom));
  }
  if (options.format == ExportFormat::quantizedMesh) return checkTerrain(options, info);
  return isTileSet(options.format) ? checkTileSet(options, info) : checkRaster(options);
}

std::uint64_t bytesUnder(const fs::path& path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) return fs::file_size(path, error);
  std::uint64_t bytes = 0;
  for (fs::recursive_directory_iterator it(path, error), end; !error && it != end; it.increment(error))
    if (it->is_regular_file(error)) bytes += it->file_size(error);
  return bytes;
}

}  // namespace

io::Result<std::uint64_t> mostUnasked(const ExportRun& run) {
  // Evenly deep data takes up to 6 tiles for one: Mercator's poles, a step between two zooms, tiles cut by edges.
  constexpr std::uint64_t kMostForOne = 64;
  constexpr std::uint64_t kMostForFew = 1024;
  if (run.options.maxLevel) return std::numeric_limits<std::uint64_t>::max();
  const auto stored = run.samples.storedTiles();
  if (!stored) return tl::unexpected(stored.error());
  return kMostForFew + kMostForOne * *stored;
}

io::Failure tooMagnified(const ExportRun& run, std::uint64_t most) {
  return {
      Code::invalidArgument,
      fmt::format("as fine as its finest part, all of it would take more than {} tiles, most of them magnified; give "
                  "the depth with --levels, or export the fine part with --region",
                  most),
      run.samples.info().name};
}

std::optional<ExportFormat> exportFormatByName(std::string_view name) {
  for (const auto& [known, format] : kFormats)
    if (known == name) return format;
  return std::nullopt;
}

std::string_view nameOf(ExportFormat format) {
  for (const auto& [name, known] : kFormats)
    if (known == format) return name;
  return {};
}

io::Result<ExportReport> exportPyramid(const ExportOptions& options, const ExportProgressSink& progress,
                                       std::stop_token stop) {
  auto samples = ExportSamples::open(options.input);
  if (!samples) return tl::unexpected(samples.error());
  if (auto ok = check(options, (*samples)->info()); !ok) return tl::unexpected(ok.error());
  std::error_code error;
  if (fs::equivalent(options.input, options.output, error) && !error) {
    return io::fail(Code::invalidArgument, "is the database itself; choose another name for the export",
                    options.output.string());
  }
  const bool isFolder = options.format == ExportFormat::xyz || options.format == ExportFormat::quantizedMesh;
  auto place = ExportPlace::prepare(options.output, isFolder ? ExportPlace::Shape::folder : ExportPlace::Shape::file,
                                    options.replace);
  if (!place) return tl::unexpected(place.error());
  const ExportRun run{.options = options, .samples = **samples, .progress = progress, .stop = std::move(stop)};
  auto report = exportAs(run, *place);
  if (report) report->bytes = bytesUnder(options.output);
  return report;
}

}  // namespace tellurion::pyramid
