#include "raster/service_offers.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <unordered_map>
#include <unordered_set>

#include "raster/map_reference.h"
#include "raster/service_discovery.h"
#include "raster/service_exception.h"
#include "raster/service_url.h"

namespace tellurion::raster {
namespace {

using Names = std::vector<std::string>;
using NameSet = std::unordered_set<std::string>;

constexpr std::size_t kMostListed = 64;    // names of one list of a layer
constexpr std::size_t kMostStyles = 256;   // of a layer; servers of models have 70
constexpr std::size_t kLongestName = 200;  // a longer one is no reference, format or style to choose
constexpr std::size_t kMostListedBytes = std::size_t{64} << 20;

int rankOf(const std::string& crs) {
  return crs == "EPSG:4326" || crs == "CRS:84" ? 0 : crs == "EPSG:3857" ? 1 : 2;
}

/// The first of them, in no more memory than they need: thousands of layers have such a list.
Names firstOf(const Names& all, std::size_t most) {
  return Names(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(std::min(most, all.size())));
}

/// Each once.
Names referencesOf(const Names& offered) {
  Names names;
  NameSet known;
  for (const std::string& crs : offered) {
    if (crs.size() > kLongestName) continue;
    if (std::string name = referenceName(crs); !name.empty() && known.insert(name).second)
      names.push_back(std::move(name));
  }
  return names;
}

void setReferences(const Names& offered, LayerOffer& layer) {
  Names names = referencesOf(offered);
  layer.crsCount = names.size();
  std::ranges::stable_sort(names, {}, rankOf);
  layer.crs = firstOf(names, kMostListed);
}

template <class T>
Names shortNamesOf(const std::vector<T>& all) {
  Names names;
  for (const T& one : all)
    if (one.name.size() <= kLongestName) names.push_back(one.name);
  return names;
}

Names shortOnes(const Names& all) {
  Names names;
  for (const std::string& name : all)
    if (names.size() < kMostListed && name.size() <= kLongestName) names.push_back(name);
  return names;
}

/// Names that a layer has from itself and the layers around it, while the layers are gone through in the order of their
/// document: one set for the whole way down, so that a long list at the root costs no layer anything.
class NamesOnTheWay {
 public:
  /// Leaves the layers that are not around one of this depth, and adds its own names.
  void enter(int depth, const Names& own) {
    while (added_.size() > static_cast<std::size_t>(depth)) {
      for (const std::string& name : added_.back())
        known_.erase(name);
      added_.pop_back();
    }
    Names& added = added_.emplace_back();
    for (const std::string& name : own)
      if (known_.insert(name).second) added.push_back(name);
  }
  std::size_t count() const { return known_.size(); }

 private:
  NameSet known_;
  std::vector<Names> added_;  ///< of each layer on the way
};

/// A layer's own names before those listed of the layer around it.
Names joined(Names own, const Names& outer) {
  const NameSet known(own.begin(), own.end());
  for (const std::string& name : outer)
    if (!known.contains(name)) own.push_back(name);
  return own;
}

/// A layer that says nothing of times has those around it. Described once, where they stand.
void setTimes(const WmsLayer& layer, const LayerOffer& outer, LayerOffer& offer) {
  const WmsDimension* time = layer.dimension("time");
  if (time != nullptr && !time->values.empty()) {
    offer.times = onOneLine(describeTimes(parseTimeExtent(time->values)));
    offer.defaultTime = onOneLine(time->defaultValue);
  } else {
    offer.times = outer.times;
    offer.defaultTime = outer.defaultTime;
    if (time != nullptr && offer.times.empty()) offer.times = offer.defaultTime = onOneLine(time->defaultValue);
  }
  if (offer.times.empty()) offer.times = offer.defaultTime;
}

/// What a layer takes without its own texts: lists that may be another's too.
std::size_t listedBytes(const LayerOffer& layer) {
  std::size_t bytes = sizeof(LayerOffer) + layer.times.size() + layer.attribution.size();
  for (const Names* list : {&layer.crs, &layer.formats, &layer.styles, &layer.matrixSets})
    for (const std::string& name : *list)
      bytes += sizeof(name) + (name.size() > 15 ? name.size() + 1 : 0);  // shorter ones lie in the string itself
  return bytes;
}

/// Ends with the layer from which on they are more than can be listed.
std::vector<LayerOffer> offersOf(const WmsCapabilities& capabilities) {
  std::vector<LayerOffer> offers;
  offers.reserve(capabilities.layers.size());
  const Names formats = shortOnes(capabilities.formats);
  NamesOnTheWay references;
  NamesOnTheWay styles;
  const LayerOffer nothing;
  std::size_t bytes = 0;
  for (const WmsLayer& layer : capabilities.layers) {
    const LayerOffer& outer = layer.parent < 0 ? nothing : offers[static_cast<std::size_t>(layer.parent)];
    LayerOffer offer;
    offer.name = layer.name;
    offer.title = layer.title;
    offer.abstract = layer.abstract;
    offer.depth = layer.depth;
    Names ownReferences = referencesOf(layer.crs);
    references.enter(layer.depth, ownReferences);
    offer.crsCount = references.count();
    ownReferences = joined(std::move(ownReferences), outer.crs);
    std::ranges::stable_sort(ownReferences, {}, rankOf);
    offer.crs = firstOf(ownReferences, kMostListed);
    const Names ownStyles = shortNamesOf(layer.styles);
    styles.enter(layer.depth, ownStyles);
    offer.styleCount = styles.count();
    offer.styles = firstOf(joined(ownStyles, outer.styles), kMostStyles);
    offer.formats = formats;
    setTimes(layer, outer, offer);
    offer.box_degrees = layer.lonLatBox_degrees;
    offer.attribution = layer.attribution;
    offer.onlyWhole = layer.noSubsets;
    offer.fixedWidth = layer.fixedWidth;
    offer.fixedHeight = layer.fixedHeight;
    offer.minScaleDenominator = layer.minScaleDenominator;
    offer.maxScaleDenominator = layer.maxScaleDenominator;
    bytes += listedBytes(offer);
    offers.push_back(std::move(offer));
    if (bytes > kMostListedBytes) break;
  }
  return offers;
}

/// The references of tile matrix sets by their names.
using References = std::unordered_map<std::string_view, std::string_view>;

LayerOffer offerOf(const WmtsCapabilities& capabilities, const References& sets, const WmtsLayer& layer) {
  LayerOffer offer;
  offer.name = layer.name;
  offer.title = layer.title;
  offer.abstract = layer.abstract;
  Names references;
  for (const WmtsLink& link : layer.links) {
    if (offer.matrixSets.size() < kMostListed && link.matrixSet.size() <= kLongestName)
      offer.matrixSets.push_back(link.matrixSet);
    const auto set = sets.find(link.matrixSet);
    if (set != sets.end() && set->second.size() <= kLongestName) references.emplace_back(set->second);
  }
  setReferences(references, offer);
  offer.formats = shortOnes(layer.formats);
  const Names styles = shortNamesOf(layer.styles);
  offer.styleCount = styles.size();
  offer.styles = firstOf(styles, kMostStyles);
  if (const WmtsDimension* time = layer.dimension("time")) {
    offer.times = onOneLine(describeTimes(parseTimeExtent(fmt::format("{}", fmt::join(time->values, ",")))));
    offer.defaultTime = onOneLine(time->defaultValue);
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
    offers.layers = offersOf(*wms);
  } else if (const auto* wmts = std::get_if<WmtsCapabilities>(&found.description)) {
    offers.version = wmts->version;
    offers.title = wmts->title;
    offers.abstract = wmts->abstract;
    References sets;
    for (const WmtsMatrixSet& set : wmts->matrixSets)
      sets.emplace(set.name, set.crs);
    for (const WmtsLayer& layer : wmts->layers)
      offers.layers.push_back(offerOf(*wmts, sets, layer));
  } else if (const auto* map = std::get_if<TileMap>(&found.description)) {
    offers.title = map->title;
    offers.layers.push_back(offerOf(*map));
  } else if (const auto* maps = std::get_if<std::vector<TileMapReference>>(&found.description)) {
    std::unordered_map<std::string_view, int> sharing;  // a title
    for (const TileMapReference& one : *maps)
      ++sharing[one.title];
    for (const TileMapReference& one : *maps) {
      LayerOffer& offer = offers.layers.emplace_back();
      // Services list a map once for each of its grids, under one title.
      const bool unique = sharing[one.title] == 1 && !one.title.empty();
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
  std::size_t bytes = 0;
  for (LayerOffer& layer : offers.layers) {
    bytes += listedBytes(layer);
    if (bytes > kMostListedBytes) {
      return io::fail(
          io::Failure::Code::unsupported,
          "the layers offer more than can be listed; a scene's entry that names its layer opens it all the same",
          withoutSecrets(entry.source));
    }
    if (!layer.entry.type.empty()) continue;
    layer.entry.source = entry.source;
    layer.entry.type = found->type;
    layer.entry.version = entry.version;
    layer.entry.layer = layer.name;
  }
  return offers;
}

}  // namespace tellurion::raster
