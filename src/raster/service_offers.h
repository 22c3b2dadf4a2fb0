#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "raster/service.h"

namespace tellurion::raster {

/// A layer that a server has, whatever the protocol.
struct LayerOffer {
  std::string name;  ///< as `layer` of an entry takes it; empty: a heading over those below it, or the only layer
  std::string title;
  std::string abstract;
  int depth = 0;
  Kind kind = Kind::imagery;         ///< what the server says it is; most do not say
  std::vector<std::string> crs;      ///< names as referenceName() writes them, those that we prefer first, at most 64
  std::size_t crsCount = 0;          ///< of all
  std::vector<std::string> formats;  ///< at most 64
  std::vector<std::string> styles;   ///< at most 256
  std::size_t styleCount = 0;        ///< of all
  std::vector<std::string> matrixSets;               ///< at most 64
  std::string times;                                 ///< for people; empty: no time
  std::string defaultTime;                           ///< empty: none is stated
  std::optional<std::array<double, 4>> box_degrees;  ///< west, south, east, north
  std::string attribution;
  bool onlyWhole = false;  ///< WMS: the server gives one map of all of it, no parts
  int fixedWidth = 0;      ///< WMS: pixels of every map of it; 0: any
  int fixedHeight = 0;
  std::optional<double> minScaleDenominator;  ///< WMS: not to be drawn finer than this
  std::optional<double> maxScaleDenominator;  ///< WMS: nor coarser
  ServiceLayer entry;                         ///< opens it
};

struct ServiceOffers {
  std::string type;  ///< wms, wmts, tms, xyz, worldwind
  std::string version;
  std::string title;
  std::string abstract;
  std::vector<LayerOffer> layers;
};

/// What is at `entry.source`. Of the entry only source, type and version count. Fails where the lists of all layers
/// take more than 64 MiB, which no service known to us comes near. Waits for the network.
io::Result<ServiceOffers> listService(const ServiceLayer& entry, io::Resources& resources);

}  // namespace tellurion::raster
