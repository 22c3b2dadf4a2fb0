#include <fmt/format.h>

#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/standard_output.h"
#include "app/subcommands.h"
#include "pyramid/fill_plan.h"
#include "pyramid/pyramid_reader.h"

namespace tellurion::app {
namespace {

constexpr int kFailed = 1;

double spacingInMetres(const raster::TileSourceInfo& info, const pyramid::LevelSummary& level) {
  return level.spacing.radians() * info.body.ellipsoid.meanRadius_m();
}

std::string filled(double fillVoids_m) {
  if (fillVoids_m == 0.0) return "as they were, coarser data shows in them";
  if (fillVoids_m >= pyramid::kFillWithoutLimit_m) return "filled from coarser data";
  return fmt::format("filled from coarser data over {:g} m at most", fillVoids_m);
}

nlohmann::ordered_json jsonOf(const raster::TileSourceInfo& info, const pyramid::PyramidSummary& summary) {
  nlohmann::ordered_json json;
  json["file"] = info.name;
  json["kind"] = raster::nameOf(info.kind);
  json["tiling"] = tiling::nameOf(info.scheme);
  json["body"] = {{"name", info.body.name},
                  {"semi_major_axis_m", info.body.ellipsoid.semiMajorAxis_m()},
                  {"flattening", info.body.ellipsoid.flattening()}};
  json["tile_cells"] = info.tileCells;
  json["max_level"] = info.maxLevel;
  json["height_step_m"] = summary.heightStep_m;
  if (info.kind == raster::Kind::elevation) json["fill_voids_m"] = summary.fillVoids_m;
  if (info.kind == raster::Kind::elevation) json["max_error_m"] = summary.maxError_m;
  json["bounds"] = {{"south", info.bounds.south.degrees()},
                    {"west", info.bounds.west.degrees()},
                    {"north", info.bounds.north.degrees()},
                    {"width", info.bounds.width.degrees()}};
  json["bytes"] = summary.fileBytes;
  json["levels"] = nlohmann::ordered_json::array();
  for (const pyramid::LevelSummary& level : summary.levels) {
    json["levels"].push_back({{"level", level.level},
                              {"tiles", level.tiles},
                              {"payload_bytes", level.payloadBytes},
                              {"spacing_m", spacingInMetres(info, level)}});
  }
  json["sources"] = summary.sources;
  return json;
}

std::string textOf(const raster::TileSourceInfo& info, const pyramid::PyramidSummary& summary) {
  std::string text;
  auto out = std::back_inserter(text);
  fmt::format_to(out, "{}: {}, {} tiling, {} ({} m, flattening {:.9g})\n", info.name, raster::nameOf(info.kind),
                 tiling::nameOf(info.scheme), info.body.name, info.body.ellipsoid.semiMajorAxis_m(),
                 info.body.ellipsoid.flattening());
  fmt::format_to(out, "bounds     latitude {:.6g} to {:.6g}, longitude {:.6g} to {:.6g}\n", info.bounds.south.degrees(),
                 info.bounds.north.degrees(), info.bounds.west.degrees(), info.bounds.east().degrees());
  if (info.kind == raster::Kind::elevation) {
    fmt::format_to(out, "tiles      {} cells a side, heights {}{}\n", info.tileCells,
                   summary.heightStep_m == 0.0 ? "in 32-bit floating point"
                                               : fmt::format("in steps of {:.6g} m", summary.heightStep_m),
                   summary.maxError_m == 0.0 ? "" : fmt::format(", rounded by at most {:g} m", summary.maxError_m));
    fmt::format_to(out, "voids      {}\n", filled(summary.fillVoids_m));
  } else {
    fmt::format_to(out, "tiles      {} pixels a side\n", info.tileCells);
  }
  fmt::format_to(out, "file       {:.2f} MiB\n", static_cast<double>(summary.fileBytes) / (1 << 20));
  fmt::format_to(out, "{:>5} {:>12} {:>14} {:>14}\n", "level", "tiles", "bytes", "spacing");
  for (const pyramid::LevelSummary& level : summary.levels) {
    fmt::format_to(out, "{:>5} {:>12} {:>14} {:>12.5g} m\n", level.level, level.tiles, level.payloadBytes,
                   spacingInMetres(info, level));
  }
  for (const std::string& source : summary.sources)
    fmt::format_to(out, "source     {}\n", source);
  return text;
}

void run(const std::string& path, bool asJson) {
  const auto reader = pyramid::PyramidReader::open(path);
  const auto summary = reader ? (*reader)->summary() : tl::unexpected(reader.error());
  if (!summary) {
    fmt::print(stderr, "tellurion info: {}\n", io::describe(summary.error()));
    throw CLI::RuntimeError(kFailed);
  }
  const raster::TileSourceInfo& info = (*reader)->info();
  printAnswer("info", asJson
                          ? jsonOf(info, *summary).dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n"
                          : textOf(info, *summary));
}

}  // namespace

void addInfo(CLI::App& program) {
  auto* command = program.add_subcommand("info", "Describe a tile database");
  auto path = std::make_shared<std::string>();
  auto asJson = std::make_shared<bool>(false);
  command->add_option("X.tdb", *path, "The tile database")->required();
  command->add_flag("--json", *asJson, "As JSON");
  command->footer(
      "Prints kind, tiling, body, extent, and for each level its tiles, their bytes and the mean distance between "
      "samples.\n\n"
      "Example: how fine is it?\n"
      "  tellurion info earth.tdb\n"
      "  tellurion info earth.tdb --json | jq '.levels[-1].spacing_m'");
  command->callback([path, asJson] { run(*path, *asJson); });
}

}  // namespace tellurion::app
