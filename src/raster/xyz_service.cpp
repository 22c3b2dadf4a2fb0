#include "raster/xyz_service.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>

#include "raster/doubling_grid.h"
#include "raster/map_reference.h"
#include "raster/service_entry.h"
#include "raster/service_url.h"
#include "raster/url_template.h"

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;

constexpr int kUsualPixels = 256;
constexpr int kUsualFinest = 19;

enum class Place : std::uint8_t { column, row, rowFromSouth, level, quadkey, server, unknown };

Place placeOf(std::string_view name) {
  struct Known {
    const char* name;
    Place place;
  };
  constexpr std::array<Known, 14> kKnown = {{{"x", Place::column},
                                             {"col", Place::column},
                                             {"tilecol", Place::column},
                                             {"y", Place::row},
                                             {"row", Place::row},
                                             {"tilerow", Place::row},
                                             {"-y", Place::rowFromSouth},
                                             {"z", Place::level},
                                             {"level", Place::level},
                                             {"tilematrix", Place::level},
                                             {"q", Place::quadkey},
                                             {"quadkey", Place::quadkey},
                                             {"s", Place::server},
                                             {"zoom", Place::level}}};
  const auto* const found = std::ranges::find(kKnown, name, [](const Known& k) { return std::string_view(k.name); });
  if (found != kKnown.end()) return found->place;
  return name.starts_with("s:") || name.starts_with("switch:") ? Place::server : Place::unknown;
}

/// A digit a level: 1 for the east half, 2 for the south half.
std::string quadkey(int level, const GridImageId& id) {
  std::string key;
  for (int bit = level - 1; bit >= 0; --bit)
    key += static_cast<char>('0' + ((id.column >> bit) & 1) + 2 * ((id.row >> bit) & 1));
  return key;
}

/// One of "{s:abc}" (a letter each) or "{switch:a,b}", always the same for a tile, so that caches find it again.
std::string server(std::string_view name, const GridImageId& id) {
  std::string_view list = name == "s" ? std::string_view("abc") : name.substr(name.find(':') + 1);
  std::vector<std::string_view> servers;
  const bool commas = list.find(',') != list.npos;
  while (!list.empty()) {
    const std::size_t end = commas ? std::min(list.find(','), list.size()) : 1;
    servers.push_back(list.substr(0, end));
    list.remove_prefix(std::min(end + (commas ? 1 : 0), list.size()));
  }
  if (servers.empty()) return {};
  return std::string(servers[static_cast<std::size_t>(id.column + id.row) % servers.size()]);
}

struct Plan {
  UrlTemplate url{""};
  std::vector<GridLevel> levels;
  int firstLevel = 0;
  std::string dataset;
  ExpectedImage expected;
};

io::ResourceRequest requestFor(const Plan& plan, const GridImageId& id) {
  const int level = plan.firstLevel + id.level;
  const std::int64_t rows = plan.levels[static_cast<std::size_t>(id.level)].rows;
  return imageRequest(plan.url.filled([&](std::string_view name) -> std::string {
    switch (placeOf(name)) {
      case Place::column:
        return std::to_string(id.column);
      case Place::row:
        return std::to_string(id.row);
      case Place::rowFromSouth:
        return std::to_string(rows - 1 - id.row);
      case Place::level:
        return std::to_string(level);
      case Place::quadkey:
        return quadkey(level, id);
      case Place::server:
        return server(name, id);
      case Place::unknown:
        break;
    }
    return {};
  }),
                      plan.dataset, plan.expected);
}

io::Result<UrlTemplate> checkedTemplate(const std::string& source) {
  const auto path = localPath(source);
  UrlTemplate url(path ? fileUrl(*path) : source);
  for (const std::string& name : url.names()) {
    if (placeOf(name) != Place::unknown) continue;
    return io::fail(Code::invalidArgument,
                    fmt::format("'{{{}}}' is not known in a tile template; {{x}}, {{y}} or {{-y}}, {{z}}, {{q}}, {{s}} "
                                "and {{s:abc}} are",
                                name));
  }
  if (!isTileTemplate(source)) {
    return io::fail(Code::invalidArgument,
                    "a tile template needs {x}, {y} (or {-y}) and {z}, or {q}: https://host/{z}/{x}/{y}.png");
  }
  return url;
}

/// "image/png" of ".../{y}.png?key=1"; empty: cannot be told.
std::string formatOfName(std::string_view source) {
  const std::string_view path = withoutQuery(source);
  const std::string extension = lowered(path.substr(std::min(path.rfind('.'), path.size())));
  if (extension == ".bil") return "application/bil16";
  if (extension == ".tif" || extension == ".tiff") return "image/tiff";
  return {};
}

}  // namespace

bool isTileTemplate(std::string_view source) {
  bool column = false;
  bool row = false;
  bool level = false;
  bool key = false;
  const UrlTemplate url(source);
  for (const std::string& name : url.names()) {
    const Place place = placeOf(name);
    column = column || place == Place::column;
    row = row || place == Place::row || place == Place::rowFromSouth;
    level = level || place == Place::level;
    key = key || place == Place::quadkey;
  }
  return key || (column && row && level);
}

io::Result<void> checkTileTemplate(const std::string& source) {
  if (const auto url = checkedTemplate(source); !url) return tl::unexpected(url.error());
  return {};
}

io::Result<GridService> xyzService(const ServiceLayer& entry, Kind kind, const geo::Body& body) {
  auto url = checkedTemplate(entry.source);
  if (!url) return tl::unexpected(url.error());
  const auto reference = mapReference(entry.crs.empty() ? "EPSG:3857" : entry.crs, body);
  if (!reference) return tl::unexpected(reference.error());
  if (reference->plane.kind == MapPlane::Kind::other) {
    return io::fail(Code::unsupported,
                    fmt::format("tile templates are in EPSG:3857 or EPSG:4326, not in '{}'", entry.crs));
  }
  auto heights = heightEncoding(entry);
  if (!heights) return tl::unexpected(heights.error());

  GridService service;
  service.name = withoutSecrets(entry.source);
  service.kind = kind;
  service.body = body;
  service.plane = reference->plane;
  service.heights = *heights;
  service.attribution = entry.attribution;
  service.bounds = boundsOf(entry, std::nullopt);
  Plan plan;
  plan.url = std::move(*url);
  plan.dataset = service.name;
  plan.firstLevel = entry.minLevel.value_or(0);
  const int pixels = entry.tilePixels.value_or(kUsualPixels);
  plan.expected = {kind, pixels, pixels,
                   rawSampleBytes(entry.format.empty() ? formatOfName(entry.source) : entry.format), true};
  const auto box = planeBox(service.plane, service.bounds, body);
  for (int i = plan.firstLevel; i <= entry.maxLevel.value_or(std::max(kUsualFinest, plan.firstLevel)); ++i) {
    GridLevel level = levelOf(doublingGrid(service.plane, *box, body), i, pixels);
    if (!limitTo(*box, level)) return io::fail(Code::invalidArgument, "the bounds hold no tile");
    plan.levels.push_back(level);
  }
  service.levels = plan.levels;
  service.request = [shared = std::make_shared<const Plan>(std::move(plan))](const GridImageId& id) {
    return requestFor(*shared, id);
  };
  return service;
}

}  // namespace tellurion::raster
