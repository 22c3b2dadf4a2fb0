#include "raster/worldwind_service.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "raster/doubling_grid.h"
#include "raster/service_entry.h"
#include "raster/service_url.h"

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;

constexpr int kUsualPixels = 512;
constexpr int kUsualFinest = 9;

struct Plan {
  std::string base;   ///< with the data set when it is asked for by query, else a folder with a slash at the end
  std::string query;  ///< of a folder's files, with its question mark
  std::string extension;
  bool asksByQuery = false;
  int firstLevel = 0;
  std::vector<GridLevel> levels;
  std::string dataset;
  ExpectedImage expected;
};

io::ResourceRequest requestFor(const Plan& plan, const GridImageId& id) {
  const int level = plan.firstLevel + id.level;
  const std::int64_t row = plan.levels[static_cast<std::size_t>(id.level)].rows - 1 - id.row;
  std::string url = plan.asksByQuery ? fmt::format("{}&L={}&X={}&Y={}", plan.base, level, id.column, row)
                                     : fmt::format("{0}{1}/{2:04}/{2:04}_{3:04}.{4}{5}", plan.base, level, row,
                                                   id.column, plan.extension, plan.query);
  return imageRequest(std::move(url), plan.dataset, plan.expected);
}

GridLevel levelOf(double levelZero_degrees, int level, int pixels) {
  constexpr double kAlmost = 1e-9;  // of a tile: 180 / 2.25 may come out a little above 80
  const double side = std::ldexp(levelZero_degrees, -level);
  GridLevel made;
  made.pixelWidth = made.pixelHeight = side / pixels;
  made.imageWidth = made.imageHeight = pixels;
  made.endColumn = made.columns = static_cast<std::int64_t>(std::ceil(360.0 / side - kAlmost));
  made.endRow = made.rows = static_cast<std::int64_t>(std::ceil(180.0 / side - kAlmost));
  made.left = -180.0;
  made.top = -90.0 + static_cast<double>(made.rows) * side;
  return made;
}

/// The data set of a configuration may carry more of the query behind it: "name&version=1".
QueryItems dataSetItems(std::string_view dataSet) {
  QueryItems items;
  std::string_view key = "T";
  while (true) {
    const std::size_t end = dataSet.find('&');
    std::string_view item = dataSet.substr(0, end);
    if (!items.empty()) {
      key = item.substr(0, item.find('='));
      item = item.find('=') == item.npos ? std::string_view{} : item.substr(item.find('=') + 1);
    }
    items.emplace_back(std::string(key), std::string(item));
    if (end == dataSet.npos) return items;
    dataSet.remove_prefix(end + 1);
  }
}

void placeTiles(const ServiceLayer& entry, Plan& plan) {
  plan.asksByQuery = !entry.layer.empty() || queryValue(entry.source, "T").has_value();
  const auto path = localPath(entry.source);
  const std::string source = path ? fileUrl(*path) : entry.source;
  if (plan.asksByQuery) {
    plan.base = entry.layer.empty() ? source : withQuery(source, dataSetItems(entry.layer));
    return;
  }
  const std::size_t question = std::min(source.find('?'), source.size());
  plan.base = source.substr(0, question);
  plan.query = source.substr(question);
  if (!plan.base.ends_with('/')) plan.base += '/';
}

}  // namespace

io::Result<GridService> worldWindService(const ServiceLayer& entry, Kind kind, const geo::Body& body) {
  if (!entry.levelZero_degrees) {
    return io::fail(Code::invalidArgument,
                    "a World Wind tile server needs level_zero_degrees, the side of a tile of level 0 in degrees (36, "
                    "20, 2.25, ...)");
  }
  const double side = *entry.levelZero_degrees;
  if (!(side >= 1e-3 && side <= 360.0))
    return io::fail(Code::invalidArgument, fmt::format("level_zero_degrees = {} is not within 0.001 to 360", side));
  auto heights = heightEncoding(entry);
  if (!heights) return tl::unexpected(heights.error());

  GridService service;
  service.name = withoutSecrets(entry.source) + (entry.layer.empty() ? "" : ' ' + entry.layer);
  service.kind = kind;
  service.body = body;
  service.heights = *heights;
  service.attribution = entry.attribution;
  service.bounds = boundsOf(entry, std::nullopt);
  Plan plan;
  placeTiles(entry, plan);
  const std::string format = !entry.format.empty() ? entry.format
                             : kind == Kind::elevation && service.heights.kind == HeightEncoding::Kind::band
                                 ? "application/bil16"
                                 : "image/png";
  plan.extension = extensionOf(format);
  plan.dataset = service.name;
  plan.firstLevel = entry.minLevel.value_or(0);
  const int pixels = entry.tilePixels.value_or(kUsualPixels);
  plan.expected = {kind, pixels, pixels, rawSampleBytes(format), true};
  const auto box = planeBox(service.plane, service.bounds, body);
  for (int i = plan.firstLevel; i <= entry.maxLevel.value_or(std::max(kUsualFinest, plan.firstLevel)); ++i) {
    GridLevel level = levelOf(side, i, pixels);
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
