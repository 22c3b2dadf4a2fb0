#include "raster/service_offers.h"

#include <fmt/format.h>

#include <algorithm>
#include <unordered_set>

#include "raster/map_reference.h"
#include "raster/service_discovery.h"
#include "raster/service_exception.h"

namespace tellurion::raster {
namespace {

int rankOf(const std::string& crs) {
  return crs == "EPSG:4326" || crs == "CRS:84" ? 0 : crs == "EPSG:3857" ? 1 : 2;
}

void setReferences(const std::vector<std::string>& offered, LayerOffer& layer) {
  constexpr std::size_t kMost = 64;
  std::unordered_set<std::string> known;
  for (const std::string& crs : offered)
    if (const std::string name = referenceName(crs); !name.empty() && known.insert(name).second)
      layer.crs.push_back(name);
  layer.crsCount = layer.crs.size();
  std::ranges::stable_sort(layer.crs, {}, rankOf);
  layer.crs.resize(std::min(kMost, layer.crs.size()));
}

template <class T>
std::vector<std::string> namesOf(const std::vector<T>& all) {
  std::vector<std::string> names;
  for (const T& one : all)
    names.push_back(one.name);
  return names;
}

LayerOffer offerOf(const WmsCapabilities& capabilities, const WmsLayer& own) {
  const WmsLayer layer = capabilities.withInherited(own);
  LayerOffer offer;
  offer.name = layer.name;
  offer.title = layer.title;
  offer.abstract = layer.abstract;
  offer.depth = layer.depth;
  setReferences(layer.crs, offer);
  offer.formats = capabilities.formats;
  offer.styles = namesOf(layer.styles);
  if (const WmsDimension* time = layer.dimension("time")) {
    offer.times = describeTimes(parseTimeExtent(time->values));
    offer.defaultTime = time->defaultValue;
    if (offer.times.empty()) offer.times = offer.defaultTime;
  }
  offer.box_degrees = layer.lonLatBox_degrees;
  offer.attribution = layer.attribution;
  offer.onlyWhole = layer.noSubsets;
  offer.fixedWidth = layer.fixedWidth;
  offer.fixedHeight = layer.fixedHeight;
  return offer;
}

LayerOffer offerOf(const WmtsCapabilities& capabilities, const WmtsLayer& layer) {
  LayerOffer offer;
  offer.name = layer.name;
  offer.title = layer.title;
  offer.abstract = layer.abstract;
  std::vector<std::string> references;
  for (const WmtsLink& link : layer.links) {
    offer.matrixSets.push_back(link.matrixSet);
    if (const WmtsMatrixSet* set = capabilities.matrixSet(link.matrixSet)) references.push_back(set->crs);
  }
  setReferences(references, offer);
  offer.formats = layer.formats;
  offer.styles = namesOf(layer.styles);
  if (const WmtsDimension* time = layer.dimension("time")) {
    offer.times = describeTimes(parseTimeExtent(fmt::format("{}", fmt::join(time->values, ","))));
    offer.defaultTime = time->defaultValue;
  }
  offer.box_degrees = layer.lonLatBox_degrees;
  offer.attribution = capabilities.attribution;
  return offer;
}

LayerOffer offerOf(const TileMap& map) {
  LayerOffer offer;
  offer.title = map.title;
  offer.abstract = map.abstract;
  setReferences({map.crs}, offer);
  offer.formats = {map.format};
  if (rankOf(offer.crs.empty() ? "" : offer.crs[0]) == 0) offer.box_degrees = map.box;
  return offer;
}

LayerOffer offerOf(const WorldWindLayer& layer) {
  LayerOffer offer;
  offer.name = layer.title;
  offer.title = layer.entry.layer;
  offer.kind = layer.kind;
  if (layer.entry.type == "worldwind") setReferences({"EPSG:4326"}, offer);
  offer.formats = {layer.entry.format};
  offer.box_degrees = layer.entry.bounds_degrees;
  offer.entry = layer.entry;
  return offer;
}

/// The last two parts of a path: "layer/grid".
std::string lastParts(const std::string& href) {
  const std::size_t last = href.rfind('/');
  const std::size_t before = last == 0 || last == href.npos ? href.npos : href.rfind('/', last - 1);
  return before == href.npos ? href : href.substr(before + 1);
}

void describe(const FoundService& found, ServiceOffers& offers) {
  if (const auto* wms = std::get_if<WmsCapabilities>(&found.description)) {
    offers.version = wms->version;
    offers.title = onOneLine(wms->title);
    offers.abstract = wms->abstract;
    for (const WmsLayer& layer : wms->layers)
      offers.layers.push_back(offerOf(*wms, layer));
  } else if (const auto* wmts = std::get_if<WmtsCapabilities>(&found.description)) {
    offers.version = wmts->version;
    offers.title = wmts->title;
    offers.abstract = wmts->abstract;
    for (const WmtsLayer& layer : wmts->layers)
      offers.layers.push_back(offerOf(*wmts, layer));
  } else if (const auto* map = std::get_if<TileMap>(&found.description)) {
    offers.title = map->title;
    offers.layers.push_back(offerOf(*map));
  } else if (const auto* maps = std::get_if<std::vector<TileMapReference>>(&found.description)) {
    for (const TileMapReference& one : *maps) {
      LayerOffer& offer = offers.layers.emplace_back();
      // Services list a map once for each of its grids, under one title.
      const bool unique = std::ranges::count(*maps, one.title, &TileMapReference::title) == 1 && !one.title.empty();
      offer.name = unique ? one.title : lastParts(one.href);
      offer.title = one.title;
      setReferences({one.crs}, offer);
    }
  } else if (const auto* layers = std::get_if<std::vector<WorldWindLayer>>(&found.description)) {
    for (const WorldWindLayer& layer : *layers)
      offers.layers.push_back(offerOf(layer));
  } else {
    offers.layers.emplace_back().crs = {found.type == "xyz" ? "EPSG:3857" : "EPSG:4326"};
    offers.layers.back().crsCount = 1;
  }
}

}  // namespace

io::Result<ServiceOffers> listService(const ServiceLayer& entry, io::Resources& resources) {
  const auto found = findService(entry, resources);
  if (!found) return tl::unexpected(found.error());
  ServiceOffers offers;
  offers.type = found->type;
  describe(*found, offers);
  for (LayerOffer& layer : offers.layers) {
    if (!layer.entry.type.empty()) continue;
    layer.entry.source = entry.source;
    layer.entry.type = found->type;
    layer.entry.version = entry.version;
    layer.entry.layer = layer.name;
  }
  return offers;
}

}  // namespace tellurion::raster
