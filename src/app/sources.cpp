#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <string_view>
#include <unordered_set>

#include "app/scene_entry.h"
#include "app/standard_output.h"
#include "app/subcommands.h"
#include "geo/body.h"
#include "io/resources.h"
#include "raster/grid_geometry.h"
#include "raster/map_reference.h"
#include "raster/near_names.h"
#include "raster/service_exception.h"
#include "raster/service_offers.h"
#include "raster/service_url.h"

namespace tellurion::app {
namespace {

constexpr int kFailed = 1;

struct Options {
  std::string source, layer, type, version, body;
  bool asJson = false;
  bool elevation = false;
};

[[noreturn]] void fail(const std::string& message) {
  fmt::print(stderr, "tellurion sources: {}\n", message);
  throw CLI::RuntimeError(kFailed);
}

std::string told(io::Failure failure) {
  failure.where = raster::withoutSecrets(failure.where);
  return io::describe(failure);
}

std::string dumped(const nlohmann::ordered_json& json) {
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

nlohmann::ordered_json jsonOf(const raster::LayerOffer& layer) {
  nlohmann::ordered_json json;
  json["name"] = layer.name;
  json["title"] = layer.title;
  json["abstract"] = layer.abstract;
  json["depth"] = layer.depth;
  json["kind"] = raster::nameOf(layer.kind);
  json["crs"] = layer.crs;
  json["crs_count"] = layer.crsCount;
  if (const auto body = raster::bodyOfReferences(layer.crs)) json["body"] = body->name;
  json["formats"] = layer.formats;
  json["styles"] = layer.styles;
  json["style_count"] = layer.styleCount;
  json["matrix_sets"] = layer.matrixSets;
  json["times"] = layer.times;
  json["default_time"] = layer.defaultTime;
  if (layer.box_degrees) json["bounds"] = *layer.box_degrees;
  json["attribution"] = layer.attribution;
  if (layer.onlyWhole) json["only_whole"] = true;
  if (layer.fixedWidth > 0) json["fixed_width"] = layer.fixedWidth;
  if (layer.fixedHeight > 0) json["fixed_height"] = layer.fixedHeight;
  if (layer.minScaleDenominator) json["min_scale_denominator"] = *layer.minScaleDenominator;
  if (layer.maxScaleDenominator) json["max_scale_denominator"] = *layer.maxScaleDenominator;
  return json;
}

nlohmann::ordered_json jsonOf(const raster::ServiceOffers& offers) {
  nlohmann::ordered_json json;
  json["type"] = offers.type;
  json["version"] = offers.version;
  json["title"] = offers.title;
  json["abstract"] = offers.abstract;
  json["layers"] = nlohmann::ordered_json::array();
  for (const raster::LayerOffer& layer : offers.layers)
    json["layers"].push_back(jsonOf(layer));
  return json;
}

/// What a server cannot do with a layer; empty: it gives any part at any size.
std::string limitsOf(const raster::LayerOffer& layer) {
  const auto side = [](int pixels) { return pixels > 0 ? std::to_string(pixels) : std::string("any"); };
  const bool isFixed = layer.fixedWidth > 0 || layer.fixedHeight > 0;
  std::vector<std::string> limits;
  if (layer.onlyWhole || isFixed) limits.emplace_back(layer.onlyWhole ? "one map of all of it, no parts" : "any part");
  if (isFixed) limits.push_back(fmt::format("{} x {} pixels", side(layer.fixedWidth), side(layer.fixedHeight)));
  if (layer.minScaleDenominator) limits.push_back(fmt::format("no finer than 1:{:.6g}", *layer.minScaleDenominator));
  if (layer.maxScaleDenominator) limits.push_back(fmt::format("no coarser than 1:{:.6g}", *layer.maxScaleDenominator));
  return fmt::format("{}", fmt::join(limits, ", "));
}

/// The first few of a list, and how many more.
std::string someOf(const std::vector<std::string>& names, std::size_t most, std::size_t count) {
  const std::size_t shown = std::min(most, names.size());
  std::string text =
      fmt::format("{}", fmt::join(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(shown), ", "));
  if (count > shown) text += fmt::format(" +{}", count - shown);
  return text;
}

std::string boxText(const raster::LayerOffer& layer) {
  if (!layer.box_degrees) return {};
  const auto& [west, south, east, north] = *layer.box_degrees;
  return fmt::format("{:.6g} {:.6g} {:.6g} {:.6g}", west, south, east, north);
}

/// Names and titles of the outside: one line, and not wider than `most` letters.
std::string cell(const std::string& text, std::size_t most) {
  std::string line = raster::onOneLine(text);
  std::size_t letters = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if ((static_cast<unsigned char>(line[i]) & 0xC0) == 0x80) continue;
    if (++letters > most) return line.substr(0, i) + "...";
  }
  return line;
}

std::vector<std::string> rowOf(const raster::LayerOffer& layer) {
  constexpr std::size_t kWidestTitle = 40;
  constexpr std::size_t kWidestName = 60;
  const std::string indent(static_cast<std::size_t>(std::min(layer.depth, 8)) * 2, ' ');
  const std::string name = layer.name.empty() ? "-" : cell(layer.name, kWidestName);
  if (layer.name.empty() && layer.depth == 0 && layer.crs.empty())
    return {indent + name, cell(layer.title, kWidestTitle)};
  return {indent + name,
          cell(layer.title, kWidestTitle),
          boxText(layer),
          someOf(layer.crs, 3, layer.crsCount),
          cell(someOf(layer.styles, 3, layer.styleCount), kWidestTitle),
          cell(layer.times, kWidestName),
          limitsOf(layer)};
}

std::size_t lettersOf(const std::string& text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::string tableOf(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i)
      widths[i] = std::max(widths[i], lettersOf(row[i]));
  }
  std::string table;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i)
      line += row[i] + std::string(widths[i] - lettersOf(row[i]) + 2, ' ');
    line.erase(line.find_last_not_of(' ') + 1);
    table += line + '\n';
  }
  return table;
}

std::string textOf(const raster::ServiceOffers& offers, const std::string& source) {
  std::string text;
  auto out = std::back_inserter(text);
  fmt::format_to(out, "{}: {}{}{}{}\n", raster::withoutSecrets(source), offers.type, offers.version.empty() ? "" : " ",
                 raster::onOneLine(offers.version), offers.title.empty() ? "" : ", " + offers.title);
  std::vector<std::string> formats;
  std::unordered_set<std::string_view> known;
  for (const raster::LayerOffer& layer : offers.layers)
    for (const std::string& format : layer.formats)
      if (!format.empty() && known.insert(format).second) formats.push_back(format);
  constexpr std::size_t kMostFormats = 12;
  if (!formats.empty())
    fmt::format_to(out, "formats: {}\n", raster::onOneLine(someOf(formats, kMostFormats, formats.size())));
  std::vector<std::vector<std::string>> rows = {{"layer", "title", "west south east north", "crs", "styles", "times"}};
  for (const raster::LayerOffer& layer : offers.layers)
    rows.push_back(rowOf(layer));
  return text + tableOf(rows);
}

const raster::LayerOffer& findOffer(const raster::ServiceOffers& offers, const std::string& wanted) {
  std::vector<std::string> names;
  for (const raster::LayerOffer& layer : offers.layers) {
    if (layer.name == wanted && !wanted.empty()) return layer;
    if (!layer.name.empty()) names.push_back(layer.name);
  }
  const bool nameless = names.empty() && offers.layers.size() == 1;  // a tile map, a template
  for (const raster::LayerOffer& layer : offers.layers)
    if (nameless || (layer.title == wanted && !layer.name.empty())) return layer;
  fail(fmt::format("there is no layer '{}'{}", wanted, raster::whatElseThereIs(wanted, names)));
}

/// The option's; else what the layer's references say; else the Earth, on which most servers' maps lie.
geo::Body bodyOf(const raster::LayerOffer& layer, const Options& options) {
  const auto told = raster::bodyOfReferences(layer.crs);
  const auto named = geo::bodyByName(options.body);
  if (told && named && !(*told == *named)) {
    fail(fmt::format("layer '{}' lies on {} by its references ({}), not on {}; leave --body out", layer.name,
                     told->name, someOf(layer.crs, 3, layer.crsCount), named->name));
  }
  return named ? *named : told.value_or(geo::earth());
}

/// The entry with what the server leaves open made plain, once it is known to open.
void printEntry(const raster::LayerOffer& layer, const Options& options, io::Resources& resources) {
  const raster::Kind kind = options.elevation ? raster::Kind::elevation : layer.kind;
  raster::ServiceLayer entry = layer.entry;
  const geo::Body body = bodyOf(layer, options);
  const auto service = raster::openService(entry, kind, body, resources);
  if (!service) fail(told(service.error()));
  if (const auto grid = raster::GridGeometry::make(*service); !grid) fail(told(grid.error()));
  entry.attribution = service->attribution;
  const raster::GridLevel& coarsest = service->levels.front();
  const std::string firstImage =
      raster::withoutSecrets(service->request({0, coarsest.firstColumn, coarsest.firstRow}).url);
  if (options.asJson) {
    nlohmann::ordered_json json;
    json["kind"] = raster::nameOf(kind);
    json["body"] = body.name;
    json["entry"] = entryJson(entry);
    json["levels"] = service->levels.size();
    json["first_image"] = firstImage;
    printAnswer("sources", dumped(json));
    return;
  }
  std::string text;
  auto out = std::back_inserter(text);
  const std::string title = raster::onOneLine(layer.title);
  if (!title.empty()) fmt::format_to(out, "# {}\n", title);
  if (!(body == geo::earth())) fmt::format_to(out, "# for a scene with body = \"{}\"\n", body.name);
  text += tomlOf(entry, kind);
  const auto choice = [&](const char* key, const std::vector<std::string>& some, std::size_t count) {
    constexpr std::size_t kMost = 12;
    if (count > 1) fmt::format_to(out, "# {} may be one of: {}\n", key, raster::onOneLine(someOf(some, kMost, count)));
  };
  choice("style", layer.styles, layer.styleCount);
  choice("format", layer.formats, layer.formats.size());
  choice("matrix_set", layer.matrixSets, layer.matrixSets.size());
  choice("crs", layer.crs, layer.crsCount);
  if (!layer.times.empty()) {
    fmt::format_to(out, "# time: {}{}\n", raster::onOneLine(layer.times),
                   layer.defaultTime.empty() ? "" : "; without it " + raster::onOneLine(layer.defaultTime));
  }
  const std::string limits = limitsOf(layer);
  if (!limits.empty()) fmt::format_to(out, "# the server gives {}\n", limits);
  fmt::format_to(out, "# {} levels, the first image: {}\n", service->levels.size(), firstImage);
  printAnswer("sources", text);
}

void run(const Options& options) {
  io::Resources resources{io::ResourceOptions{}};
  raster::ServiceLayer entry;
  entry.source = options.source;
  entry.type = options.type;
  entry.version = options.version;
  const auto offers = raster::listService(entry, resources);
  if (!offers) fail(told(offers.error()));
  if (!options.layer.empty()) {
    printEntry(findOffer(*offers, options.layer), options, resources);
  } else {
    printAnswer("sources", options.asJson ? dumped(jsonOf(*offers)) : textOf(*offers, options.source));
  }
}

}  // namespace

void addSources(CLI::App& program) {
  auto* command = program.add_subcommand("sources", "List what a map server offers, and write scene entries for it");
  auto options = std::make_shared<Options>();
  command
      ->add_option("URL", options->source,
                   "Where the service is: WMS, WMTS, TMS, a tile template, a World Wind configuration; or a file or "
                   "folder of such")
      ->required();
  auto* layer =
      command->add_option("--layer", options->layer, "Write the scene entry of this layer (its name, or its title)");
  command->add_flag("--elevation", options->elevation, "The entry is for heights: [[elevation]], not [[imagery]]")
      ->needs(layer);
  command->add_option("--type", options->type, "wms, wmts, tms, xyz or worldwind, where it is not told from the URL");
  command->add_option("--wms-version", options->version, "Ask a WMS in this version: 1.1.1, 1.3.0");
  command
      ->add_option(
          "--body", options->body,
          "earth, mars or moon: whose map it is, where the layer's references do not say (those of the IAU do)")
      ->check(CLI::IsMember({"earth", "mars", "moon"}))
      ->needs(layer);
  command->add_flag("--json", options->asJson, "As JSON");
  command->footer(
      "Prints a line a layer: name, title, box in degrees, coordinate references, styles, times. A layer whose name is "
      "'-' is a heading. With --layer it opens the layer as a scene would and prints the entry, for you to paste into "
      "a "
      "scene file (docs/scene-file.md), followed by what else could be chosen and the address of its first image.\n\n"
      "Examples: what is there, and the entry of one layer added to a scene\n"
      "  tellurion sources http://127.0.0.1:8080/wms\n"
      "  tellurion sources http://127.0.0.1:8080/wms --layer bluemarble >> scene.toml\n"
      "Heights from a tile server; a capabilities document that lies here; only the names of layers\n"
      "  tellurion sources http://127.0.0.1:8080/wms --layer dem --elevation >> scene.toml\n"
      "  tellurion sources capabilities.xml\n"
      "A layer of a server of Mars, whose scene says body = \"mars\"\n"
      "  tellurion sources http://127.0.0.1:8080/mars --layer viking --body mars\n"
      "  tellurion sources http://127.0.0.1:8080/wmts --json | jq -r '.layers[].name'");
  command->callback([options] { run(*options); });
}

}  // namespace tellurion::app
