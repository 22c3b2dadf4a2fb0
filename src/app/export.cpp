#include "pyramid/export.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "app/output_names.h"
#include "app/progress.h"
#include "app/region_option.h"
#include "app/subcommands.h"
#include "pyramid/tile_objects.h"

namespace tellurion::app {
namespace {

constexpr int kFailed = 1;
constexpr int kWrongUse = 2;

struct Arguments {
  std::string input;
  std::string output;
  std::string format;
  std::vector<int> levels;
  std::vector<double> region;
  std::string pixels;
  int quality = 85;
  std::string scheme = "mercator";
  int jobs = 0;
  bool replace = false;
};

[[noreturn]] void end(int status, const std::string& message) {
  fmt::print(stderr, "tellurion export: {}\n", message);
  throw CLI::RuntimeError(status);
}

/// What --format says, else what the output's name does.
pyramid::ExportFormat formatOf(const Arguments& arguments) {
  if (!arguments.format.empty()) return *pyramid::exportFormatByName(arguments.format);
  const std::string ending = endingOf(arguments.output);
  if (ending == ".tif" || ending == ".tiff") return pyramid::ExportFormat::geotiff;
  if (ending == ".gpkg") return pyramid::ExportFormat::geopackage;
  if (ending == ".mbtiles") return pyramid::ExportFormat::mbtiles;
  end(kWrongUse, fmt::format("the name {} does not tell the format; give it with --format", arguments.output));
}

raster::ImageFormat pixelsOf(const Arguments& arguments) {
  if (arguments.pixels == "jpeg") return raster::ImageFormat::jpeg;
  if (arguments.pixels == "webp") return raster::ImageFormat::webp;
  return raster::ImageFormat::png;
}

pyramid::ExportOptions optionsFrom(const Arguments& arguments) {
  pyramid::ExportOptions options;
  options.input = arguments.input;
  options.output = arguments.output;
  options.format = formatOf(arguments);
  if (arguments.levels.size() == 1) options.maxLevel = arguments.levels[0];
  if (arguments.levels.size() == 2) {
    options.minLevel = arguments.levels[0];
    options.maxLevel = arguments.levels[1];
  }
  if (!arguments.region.empty()) {
    options.region = regionFrom(arguments.region);
    if (!options.region) end(kWrongUse, kNoRegion);
  }
  options.pixels = pixelsOf(arguments);
  options.quality = arguments.quality;
  options.scheme = arguments.scheme == "geodetic" ? pyramid::MapScheme::geodetic : pyramid::MapScheme::mercator;
  options.replace = arguments.replace;
  options.jobs = arguments.jobs;
  return options;
}

void report(const Arguments& arguments, const pyramid::ExportReport& report, double seconds) {
  const double mebibytes = static_cast<double>(report.bytes) / (1 << 20);
  const std::string what =
      report.width > 0
          ? fmt::format("{} x {} pixels of {:.6g} degrees", report.width, report.height, report.step_degrees)
          : fmt::format("{} tiles of the zooms {} to {}", report.tiles, report.minZoom, report.maxZoom);
  fmt::print(stderr, "{}: {}, {:.1f} MiB, {:.1f} s\n", arguments.output, what, mebibytes, seconds);
}

/// Nothing is resampled: the tiles themselves, for a server.
void runObjects(const Arguments& arguments) {
  const bool asksForMore =
      !arguments.levels.empty() || !arguments.region.empty() || !arguments.pixels.empty() || arguments.replace;
  if (asksForMore)
    end(kWrongUse,
        "objects are the database's own tiles, and an earlier export of them is always replaced: --levels, --region, "
        "--tile-format and --force mean nothing to them");
  const InterruptStop interrupt;
  ProgressLine line("exporting " + arguments.output);
  const auto sink = [&](std::uint64_t done, std::uint64_t total) { line.show(done, total, "tiles"); };
  const auto made = pyramid::exportObjects(arguments.input, arguments.output, sink, interrupt.token());
  line.clear();
  if (!made) end(kFailed, io::describe(made.error()));
  fmt::print(stderr, "{}: {} tiles, {:.1f} MiB, revision {}; put the folder on a server or into a bucket as it is\n",
             arguments.output, made->tiles, static_cast<double>(made->bytes) / (1 << 20), made->revision);
}

void run(const Arguments& arguments) {
  if (arguments.format == "objects") return runObjects(arguments);
  const auto start = std::chrono::steady_clock::now();
  const pyramid::ExportOptions options = optionsFrom(arguments);
  const InterruptStop interrupt;
  ProgressLine line("exporting " + arguments.output);
  std::optional<ProgressLine> finishing;
  const auto sink = [&](const pyramid::ExportProgress& progress) {
    if (!progress.isFinishing) return line.show(progress.done, progress.total, "pieces");
    line.clear();
    if (!finishing) finishing.emplace("finishing " + arguments.output);
    finishing->show(progress.done, progress.total, "thousandths");
  };
  const auto made = pyramid::exportPyramid(options, sink, interrupt.token());
  finishing.reset();
  line.clear();
  if (!made) end(kFailed, io::describe(made.error()));
  report(arguments, *made, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
}

}  // namespace

void addExport(CLI::App& program) {
  auto* command = program.add_subcommand("export", "Write a tile database in a format of others, or for a server");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("X.tdb", arguments->input, "The tile database")->required();
  command->add_option("OUT", arguments->output, "The file, or for xyz, quantized-mesh and objects the folder, to write")
      ->required();
  command
      ->add_option("--format", arguments->format,
                   "geotiff, cog (cloud-optimised GeoTIFF), geopackage, mbtiles, xyz (a folder Z/X/Y of pictures), "
                   "quantized-mesh (a folder of terrain) or objects (a folder to put on a web server or into a bucket, "
                   "which scenes then name by its URL); left out: what the name's ending says (.tif, .gpkg, .mbtiles)")
      ->check(CLI::IsMember({"geotiff", "cog", "geopackage", "mbtiles", "xyz", "quantized-mesh", "objects"}));
  command
      ->add_option("--levels", arguments->levels,
                   "mbtiles, xyz, quantized-mesh: MIN,MAX, the zooms to write (one number: from 0 to it); the others: "
                   "the level of the "
                   "database that pixels are as fine as. Left out: as fine as the database")
      ->delimiter(',')
      ->expected(1, 2)
      ->check(CLI::Range(0, pyramid::kMostZoom));
  command
      ->add_option("--region", arguments->region,
                   "W,S,E,N in degrees: only what lies in there (map tiles: all that touch it); E less than W crosses "
                   "the date line. Left out: all that has data")
      ->delimiter(',')
      ->expected(4);
  command
      ->add_option("--tile-format", arguments->pixels,
                   "Imagery: png, jpeg or webp; in a cog png stands for without loss, and a geotiff always is. JPEG "
                   "tiles are black where nothing is covered [png]")
      ->check(CLI::IsMember({"png", "jpeg", "webp"}));
  command->add_option("--quality", arguments->quality, "Of JPEG and WebP [85]")->check(CLI::Range(1, 100));
  command
      ->add_option("--scheme", arguments->scheme,
                   "xyz: mercator (EPSG:3857, Earth alone) or geodetic (EPSG:4326, two tiles at zoom 0) [mercator]")
      ->check(CLI::IsMember({"mercator", "geodetic"}));
  command->add_flag("--force", arguments->replace, "Replace what is there under that name");
  command->add_option("--jobs", arguments->jobs, "Threads; left out: one for each core")->check(CLI::Range(1, 1024));
  command->footer(
      "Whatever the database's tiling, its data are resampled to the grid of the format: each pixel is what 'tellurion "
      "query'\n"
      "says at its centre, from the level that pixels of that size ask for. Heights become 32-bit floating point, in\n"
      "metres; rasters lie in longitude and latitude (EPSG:4326; on Mars and the Moon IAU_2015).\n\n"
      "The work is done in OUT.part, a folder, and takes OUT's name at the end: a run that was killed leaves no half "
      "file;\nobjects go into the folder itself, tile by tile, and are named by 'contents' at the end.\n\n"
      "Examples:\n"
      "  tellurion export ground.tdb ground.tif\n"
      "  tellurion export colour.tdb alps.tif --format cog --tile-format jpeg --region 5,44,17,48\n"
      "  tellurion export colour.tdb map.mbtiles --levels 0,6 --tile-format jpeg\n"
      "  tellurion export mars_colour.tdb tiles --format xyz --scheme geodetic\n"
      "  tellurion export ground.tdb terrain --format quantized-mesh --levels 7\n"
      "  tellurion export earth.tdb www/earth.tdb --format objects   (then: tellurion view https://HOST/earth.tdb)");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace tellurion::app
