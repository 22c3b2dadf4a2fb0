#include <fmt/format.h>

#include <array>
#include <fstream>
#include <memory>
#include <string_view>

#include "app/output_names.h"
#include "app/progress.h"
#include "app/region_option.h"
#include "app/subcommands.h"
#include "pyramid/database_file.h"
#include "pyramid/pyramid_builder.h"
#include "raster/raster_kind.h"

namespace tellurion::app {
namespace {

constexpr int kFailed = 1;
constexpr int kWrongUse = 2;

struct Arguments {
  std::string input;
  std::string output;
  std::string kind;
  std::string tiling = "cube";
  std::string format = "jpeg";
  std::vector<double> region;
  std::optional<int> maxLevel;
  double memory_MiB = 1024.0;
  int jobs = 0;
};

[[noreturn]] void end(int status, const std::string& message) {
  fmt::print(stderr, "tellurion import: {}\n", message);
  throw CLI::RuntimeError(status);
}

/// MBTiles and GeoPackages are SQLite files; a tile database is one too, and needs no import.
void checkInput(const std::string& path) {
  constexpr std::string_view kMagic = "SQLite format 3";
  std::array<char, kMagic.size()> start{};
  std::ifstream file(path, std::ios::binary);
  if (!file) end(kFailed, fmt::format("{}: cannot be opened", path));
  file.read(start.data(), start.size());
  if (std::string_view(start.data(), start.size()) != kMagic) {
    end(kFailed, fmt::format("{}: is neither MBTiles nor a GeoPackage; rasters that GDAL reads go into a tile database "
                             "with 'tellurion build'",
                             path));
  }
  if (pyramid::isTileDatabaseFile(path)) end(kFailed, fmt::format("{}: is a tile database already", path));
}

pyramid::BuildOptions optionsFrom(const Arguments& arguments) {
  checkInput(arguments.input);
  pyramid::BuildOptions options;
  options.output = arguments.output;
  options.inputs = {arguments.input};
  if (arguments.kind.empty()) {
    const auto told = raster::kindOfRaster(arguments.input);
    if (!told) end(kFailed, io::describe(told.error()));
    options.kind = *told;
  } else {
    options.kind = *raster::kindByName(arguments.kind);
  }
  options.scheme = *tiling::schemeByName(arguments.tiling);
  if (options.kind == raster::Kind::imagery) options.format = *pyramid::tileFormatByName(arguments.format);
  options.maxLevel = arguments.maxLevel;
  if (!arguments.region.empty()) {
    options.region = regionFrom(arguments.region);
    if (!options.region) end(kWrongUse, kNoRegion);
  }
  options.memoryBytes = static_cast<std::uint64_t>(arguments.memory_MiB * (1 << 20));
  options.jobs = arguments.jobs;
  return options;
}

void run(const Arguments& arguments) {
  if (isSameFile(arguments.input, arguments.output)) end(kWrongUse, "IN and OUT.tdb are the same file");
  const pyramid::BuildOptions options = optionsFrom(arguments);
  const InterruptStop interrupt;
  ProgressLine line("importing " + arguments.input);
  const auto sink = [&](const pyramid::BuildProgress& progress) {
    line.show(progress.done, progress.total, "tiles", progress.doneBefore);
  };
  const auto built = pyramid::buildPyramid(options, sink, interrupt.token());
  line.clear();
  if (!built) end(kFailed, io::describe(built.error()));
  for (const std::string& warning : built->warnings)
    fmt::print(stderr, "warning: {}\n", warning);
  fmt::print(stderr, "{}{}: {}, {} tiles, deepest level {}, {:.1f} MiB\n", arguments.output,
             built->alreadyComplete ? " is complete already" : "", raster::nameOf(options.kind), built->tiles,
             built->maxLevel, static_cast<double>(built->bytes) / (1 << 20));
}

}  // namespace

void addImport(CLI::App& program) {
  auto* command = program.add_subcommand("import", "Make a tile database of MBTiles or a GeoPackage");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("IN", arguments->input, "MBTiles of pictures, or a GeoPackage with one raster")->required();
  command->add_option("OUT.tdb", arguments->output, "The tile database to write")->required();
  command
      ->add_option("--kind", arguments->kind,
                   "elevation or imagery; left out: what the file says (a tiled gridded coverage holds elevation)")
      ->check(CLI::IsMember({"elevation", "imagery"}));
  command->add_option("--tiling", arguments->tiling, "How the surface is cut: geographic, cube or healpix [cube]")
      ->check(CLI::IsMember({"geographic", "cube", "healpix"}));
  command
      ->add_option("--max-level", arguments->maxLevel,
                   "No tile deeper than this; finer data is averaged. Left out: as deep as the finest zoom")
      ->check(CLI::Range(0, tiling::kMaxLevel));
  command
      ->add_option("--region", arguments->region,
                   "W,S,E,N in degrees: only what lies in there; E less than W crosses the date line")
      ->delimiter(',')
      ->expected(4);
  command->add_option("--format", arguments->format, "Imagery: jpeg, png or webp, as of 'tellurion build' [jpeg]")
      ->check(CLI::IsMember({"jpeg", "png", "webp"}));
  command->add_option("--memory", arguments->memory_MiB, "MiB of memory that the import may take in all [1024]")
      ->check(CLI::Range(static_cast<double>(pyramid::kLeastMemory >> 20u), 1048576.0));
  command->add_option("--jobs", arguments->jobs, "Threads; left out: one for each core")->check(CLI::Range(1, 1024));
  command->footer(
      "The file's finest zoom is resampled to the tiling, as an input of 'tellurion build' is, which takes such files "
      "too, also\n"
      "several, over others, or with other options. A run that was interrupted goes on where it was when the same "
      "command is\n"
      "given again.\n\n"
      "Examples:\n"
      "  tellurion import city.mbtiles city.tdb\n"
      "  tellurion import survey.gpkg survey.tdb --tiling geographic && tellurion verify survey.tdb");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace tellurion::app
