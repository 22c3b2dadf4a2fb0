#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <memory>
#include <thread>

#include "app/progress.h"
#include "app/region_option.h"
#include "app/subcommands.h"
#include "app/supervisor.h"
#include "pyramid/bounded_heights.h"
#include "pyramid/fill_plan.h"
#include "pyramid/parted_build.h"
#include "scene/scene_file.h"

namespace tellurion::app {
namespace {

constexpr int kFailed = 1;
constexpr int kWrongUse = 2;
constexpr std::size_t kLargestBodyFile = std::size_t{1} << 20u;

struct Arguments {
  std::string output;
  std::vector<std::string> inputs;
  std::string kind;
  std::string tiling = "cube";
  std::string body;
  std::optional<int> maxLevel;
  std::optional<double> nodata;
  std::optional<double> fillVoids_m;
  std::optional<double> maxError_m;
  std::string verticalDatum;
  raster::PointOptions points;
  pyramid::CleaningOptions cleaning;
  std::vector<double> region;
  std::string format = "jpeg";
  double memory_MiB = 1024.0;
  int jobs = 0;
  bool append = false;
  std::string part;
  bool share = false;
};

[[noreturn]] void end(int status, const std::string& message) {
  fmt::print(stderr, "tellurion build: {}\n", message);
  throw CLI::RuntimeError(status);
}

/// earth, mars, moon, or what a TOML file says: body = { semi_major_axis_m = ..., inverse_flattening = ... }.
geo::Body bodyNamed(const std::string& name) {
  if (const auto known = geo::bodyByName(name)) return *known;
  std::ifstream file(name, std::ios::binary);
  if (!file) end(kWrongUse, fmt::format("--body '{}': neither earth, mars, moon nor a file", name));
  std::string text(kLargestBodyFile + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) end(kFailed, fmt::format("{}: cannot be read", name));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > kLargestBodyFile) end(kFailed, fmt::format("{}: a file for --body has at most 1 MiB", name));
  const auto scene = scene::parseScene(text, name);
  if (!scene) end(kFailed, io::describe(scene.error()));
  return scene->body;
}

pyramid::BuildOptions optionsFrom(const Arguments& arguments) {
  pyramid::BuildOptions options;
  options.output = arguments.output;
  options.inputs = arguments.inputs;
  options.kind = *raster::kindByName(arguments.kind);
  options.scheme = *tiling::schemeByName(arguments.tiling);
  if (!arguments.body.empty()) options.body = bodyNamed(arguments.body);
  options.maxLevel = arguments.maxLevel;
  options.nodata = arguments.nodata;
  options.fillVoids_m = arguments.fillVoids_m;
  options.maxError_m = arguments.maxError_m;
  options.verticalDatum = arguments.verticalDatum;
  options.points = arguments.points;
  options.cleaning = arguments.cleaning;
  if (!arguments.region.empty()) {
    options.region = regionFrom(arguments.region);
    if (!options.region) end(kWrongUse, kNoRegion);
  }
  options.format = *pyramid::tileFormatByName(arguments.format);
  options.memoryBytes = static_cast<std::uint64_t>(arguments.memory_MiB * (1 << 20));
  options.jobs = arguments.jobs;
  options.append = arguments.append;
  return options;
}

void report(const Arguments& arguments, const pyramid::BuildReport& report, double seconds) {
  for (const std::string& warning : report.warnings)
    fmt::print(stderr, "warning: {}\n", warning);
  if (report.alreadyComplete) {
    fmt::print(stderr, "{} is complete already: {} tiles, {:.1f} MiB\n", arguments.output, report.tiles,
               static_cast<double>(report.bytes) / (1 << 20));
    return;
  }
  fmt::print(stderr, "{}{}: {} tiles, deepest level {}, {:.1f} MiB, {:.1f} s\n", arguments.output,
             report.resumed ? " finished" : "", report.tiles, report.maxLevel,
             static_cast<double>(report.bytes) / (1 << 20), seconds);
}

/// One of so many shares, from 0.
struct Share {
  std::size_t index = 0;
  std::size_t count = 1;
};

Share shareFrom(const std::string& text) {
  constexpr int kMostShares = 1000000;
  int index = 0;
  int count = 0;
  const char* last = text.data() + text.size();
  const auto first = std::from_chars(text.data(), last, index);
  const bool hasSlash = first.ec == std::errc{} && first.ptr != last && *first.ptr == '/';
  const auto second = hasSlash ? std::from_chars(first.ptr + 1, last, count) : first;
  if (!hasSlash || second.ec != std::errc{} || second.ptr != last || index < 1 || index > count || count > kMostShares)
    end(kWrongUse, fmt::format("--part '{}': it is I/N, I from 1 to N, as 3/16", text));
  return {static_cast<std::size_t>(index - 1), static_cast<std::size_t>(count)};
}

/// Lines that many processes write go out whole.
void tell(const std::string& line) {
  fmt::print(stderr, "{}", fmt::format("tellurion build: {}\n", line));
}

void run(const Arguments& arguments) {
  const auto start = std::chrono::steady_clock::now();
  pyramid::BuildOptions options = optionsFrom(arguments);
  const auto many = launched();
  if (many && options.jobs == 0) {
    options.jobs = std::max(1, static_cast<int>(std::thread::hardware_concurrency()) / many->localSize);
  }
  if (many && arguments.part.empty() && !arguments.append) superviseThis(tell);
  const InterruptStop interrupt;
  ProgressLine line("building " + arguments.output);
  const auto sink = [&](const pyramid::BuildProgress& progress) {
    line.show(progress.done, progress.total, "tiles", progress.doneBefore);
  };
  const pyramid::PartsSink parts{.tell =
                                     [&](const std::string& text) {
                                       line.clear();
                                       tell(text);
                                     },
                                 .progress = [&](std::size_t made, std::size_t all) { line.show(made, all, "parts"); }};
  if (!arguments.part.empty()) {
    const Share share = shareFrom(arguments.part);
    const auto made = pyramid::buildShare(options, share.index, share.count, parts, interrupt.token());
    line.clear();
    if (!made) end(kFailed, io::describe(made.error()));
    fmt::print(stderr, "the parts of share {} are in {}.parts; when all shares are made: tellurion merge {} {}.parts\n",
               arguments.part, arguments.output, arguments.output, arguments.output);
    return;
  }
  const bool isShared = arguments.share || many;
  const auto built = isShared ? pyramid::buildTogether(options, parts, sink, interrupt.token())
                              : pyramid::buildPyramid(options, sink, interrupt.token());
  line.clear();
  if (!built) end(kFailed, io::describe(built.error()));
  if (many && many->rank != 0 && built->alreadyComplete) return;  // another one says so
  report(arguments, *built, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
}

void addPoints(CLI::App& command, raster::PointOptions& points) {
  command
      .add_option("--points-columns", points.columns,
                  "Elevation, of inputs that are layers of points: the columns of X,Y,HEIGHT, or of HEIGHT alone where "
                  "places are the points' geometry. Left out: lon, lat or x, y, and the geometry's z, height, "
                  "elevation, alt or z")
      ->delimiter(',')
      ->allow_extra_args(false);
  command.add_option("--points-srs", points.reference,
                     "What coordinates of points are in (EPSG:CODE, WKT), in place of what the layer, or a .prj beside "
                     "it, says; without any, longitude and latitude in degrees");
}

void addCleaning(CLI::App& command, pyramid::CleaningOptions& cleaning) {
  command.add_flag("--match-colours", cleaning.matchColours,
                   "Imagery: move each input's colours to those of the inputs over it, by what they share, so that a "
                   "hole filled from below does not show");
  command
      .add_option("--feather", cleaning.feather_m,
                  "Imagery: over how many metres an input fades into what is below it, at its border and its holes")
      ->check(CLI::Range(0.0, 1e7));
  command
      .add_option("--cut", cleaning.cutAt,
                  "Imagery: cut all inputs but the first (with --append: all) at the polygons of a vector file (a "
                  "coastline); outside they fade over --feather. May be given several times")
      ->allow_extra_args(false);
  command.add_flag("--clouds", cleaning.clouds,
                   "Imagery: where an input is cloudy, by comparison with the inputs below it, show those");
}

}  // namespace

void addBuild(CLI::App& program) {
  auto* command = program.add_subcommand("build", "Build or extend a tile database from rasters");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("OUT.tdb", arguments->output, "The tile database to write")->required();
  command
      ->add_option("INPUT", arguments->inputs,
                   "Rasters that GDAL reads, and, for elevation, layers of points (CSV, GeoPackage, "
                   "Shapefile, GeoJSON, FlatGeobuf, KML); later ones lie over earlier ones")
      ->required();
  command->add_option("--kind", arguments->kind, "What the inputs hold: elevation or imagery")
      ->required()
      ->check(CLI::IsMember({"elevation", "imagery"}));
  command->add_option("--tiling", arguments->tiling, "How the surface is cut: geographic, cube or healpix [cube]")
      ->check(CLI::IsMember({"geographic", "cube", "healpix"}));
  command->add_option(
      "--body", arguments->body,
      "earth, mars, moon, or a TOML file with body = { semi_major_axis_m = A, inverse_flattening = F }; "
      "left out: what the inputs say. For inputs without a spatial reference, and for those of other bodies that are "
      "labelled as Earth's (WGS 84); an input that is labelled as another body's is refused");
  command
      ->add_option("--max-level", arguments->maxLevel,
                   "No tile deeper than this; finer data is averaged. Left out: as deep as each input is fine")
      ->check(CLI::Range(0, tiling::kMaxLevel));
  command
      ->add_option("--region", arguments->region,
                   "W,S,E,N in degrees: only what lies in there is built, as if all inputs ended at its edges, and "
                   "nothing else is read; E less than W crosses the date line")
      ->delimiter(',')
      ->expected(4);
  command
      ->add_option("--format", arguments->format,
                   "Imagery: jpeg (where a tile is wholly covered, WebP without loss elsewhere), png, or webp (without "
                   "loss) [jpeg]")
      ->check(CLI::IsMember({"jpeg", "png", "webp"}));
  command
      ->add_option("--memory", arguments->memory_MiB,
                   "MiB of memory that the build may take in all, whatever the size of the inputs; the result does not "
                   "depend on it [1024]")
      ->check(CLI::Range(static_cast<double>(pyramid::kLeastMemory >> 20u), 1048576.0));
  command->add_option("--jobs", arguments->jobs, "Threads; left out: one for each core")->check(CLI::Range(1, 1024));
  command->add_option(
      "--nodata", arguments->nodata,
      "The stored value that means 'no data', for all inputs, in place of what they say themselves; a value that an "
      "input cannot hold is refused");
  command
      ->add_option(
          "--fill-voids", arguments->fillVoids_m,
          "Elevation: over how many metres at most finer data moves the coarser around it to meet it; 0: not at "
          "all. Left out: as far as the inputs ask for, or as the database was built")
      ->check(CLI::Range(0.0, pyramid::kFillWithoutLimit_m));
  command
      ->add_option("--max-error", arguments->maxError_m,
                   "Elevation: no stored height is off what the inputs say by more metres than this, but for what "
                   "--fill-voids moves; the files become much smaller. Left out: as exact as the inputs are stored, or "
                   "as the database was built")
      ->check(CLI::Range(1e-6, pyramid::kMostMaxError_m));
  command->add_option(
      "--vertical-datum", arguments->verticalDatum,
      "Elevation: what the inputs' heights are above: egm96, egm2008, EPSG:CODE of a vertical reference (their grids "
      "are "
      "PROJ's), or a file with the geoid's heights in metres (.gtx, .tif, ...). They are stored above the ellipsoid. "
      "Left out: as they are");
  addPoints(*command, arguments->points);
  addCleaning(*command, arguments->cleaning);
  auto* append = command->add_flag("--append", arguments->append, "Lay the inputs over the database that is there");
  auto* part =
      command->add_option("--part", arguments->part,
                          "I/N: make only the I-th of N shares of the work, as parts in OUT.tdb.parts; "
                          "'tellurion merge' joins them. For job "
                          "arrays, and machines that do not see each other's files: the inputs must have the same full "
                          "names and times on all (cp -p, rsync -a)");
  auto* share = command->add_flag(
      "--share", arguments->share,
      "Build together with all processes that are given the same command, on any machines that see the same files; "
      "each takes what is left to do, of those that ended too. 'mpirun tellurion build ...' means this by itself");
  part->excludes(append)->excludes(share);
  share->excludes(append);
  command->footer(
      "No data, in elevation: the file's NODATA value, its mask or alpha at 0, NaN, and heights that the body cannot "
      "have (voids\n"
      "without a tag: on Earth below -12000 or above 9000 m, on Mars and the Moon below -15000 or above 30000 m, "
      "elsewhere beyond the\n"
      "radius), which a warning tells of. In imagery: alpha or mask at 0, or all bands at their NODATA value. Where "
      "finer elevation\n"
      "has a void or ends, what is coarser is moved to meet it, so that there is no step; data itself never moves "
      "(--fill-voids 0:\n"
      "voids stay voids, and what lies below shows as it is).\n\n"
      "Points become flat triangles, as deep as the points are dense at each place; there is no data farther from them "
      "than 2.4 times\n"
      "the distance that they have from each other. A table whose lines are all cells of a regular grid is read as a "
      "raster, unless\n"
      "--points-columns or --points-srs is given.\n\n"
      "A run that was interrupted, or even killed, goes on where it was when the same command is given again, and "
      "ends\n"
      "with the same bytes. Until then the work is in OUT.tdb.part, and 'tellurion info OUT.tdb.part' names the "
      "command.\n"
      "An input that cannot be read ends the build, and leaves no OUT.tdb.part.\n\n"
      "Many processes: 'mpirun -n 16 tellurion build ...' (or srun, or --share by hand) ends with the same bytes as "
      "one. "
      "--jobs is\n"
      "the threads of each (left out: all share the cores), --memory is for each. One that is killed is reported, and "
      "its "
      "part redone.\n\n"
      "Example: the whole Earth, then Mount Everest over it in more detail\n"
      "  tellurion build earth.tdb etopo5_dem_10min.tif --kind elevation\n"
      "  tellurion build earth.tdb srtm3_everest_N27E086.tif --kind elevation --append");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace tellurion::app
