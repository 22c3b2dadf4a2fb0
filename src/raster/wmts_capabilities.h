#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/failure.h"
#include "raster/xml_document.h"

/// What a Web Map Tile Service says of itself: OGC 07-057r7 (1.0.0).
namespace tellurion::raster {

struct WmtsMatrix {
  std::string name;
  double scaleDenominator = 0.0;    ///< > 0
  std::array<double, 2> topLeft{};  ///< in the order of the reference's axes, as written
  int tileWidth = 256;              ///< pixels, 1..4096 (kMaxImageSide)
  int tileHeight = 256;
  std::int64_t width = 0;  ///< tiles, 1..2^40
  std::int64_t height = 0;
};

struct WmtsMatrixSet {
  std::string name;
  std::string crs;
  std::vector<WmtsMatrix> matrices;  ///< as written
};

struct WmtsLimits {
  std::string matrix;
  std::int64_t minRow = 0, maxRow = 0, minColumn = 0, maxColumn = 0;  ///< both ends belong to it
};

struct WmtsLink {
  std::string matrixSet;
  std::vector<WmtsLimits> limits;  ///< of some matrices
};

struct WmtsStyle {
  std::string name;
  std::string title;
  bool isDefault = false;
};

struct WmtsDimension {
  std::string name;  ///< as written
  std::string defaultValue;
  std::vector<std::string> values;
};

struct WmtsTemplate {
  std::string format;
  std::string url;
};

struct WmtsLayer {
  std::string name;
  std::string title;
  std::string abstract;
  std::optional<std::array<double, 4>> lonLatBox_degrees;  ///< west, south, east, north
  std::vector<WmtsStyle> styles;
  std::vector<std::string> formats;
  std::vector<WmtsDimension> dimensions;
  std::vector<WmtsLink> links;
  std::vector<WmtsTemplate> templates;  ///< for tiles, RESTful

  /// Capitals do not matter.
  const WmtsDimension* dimension(std::string_view dimensionName) const;
};

struct WmtsCapabilities {
  std::string version;
  std::string title;
  std::string abstract;
  std::string attribution;  ///< the provider's name
  std::string getTileUrl;   ///< for key-value requests; empty: none is stated
  std::vector<WmtsLayer> layers;
  std::vector<WmtsMatrixSet> matrixSets;

  const WmtsLayer* layer(std::string_view name) const;
  const WmtsMatrixSet* matrixSet(std::string_view name) const;
};

/// From the root element of a capabilities document. A matrix whose numbers are out of range is left out. Fails where
/// the root is another document's or no layer is in it; on more than 20,000 layers or 4,096 sets, or a layer, set or
/// list of limits of more than 4,096 parts; on an exception report with the server's own words.
io::Result<WmtsCapabilities> parseWmtsCapabilities(const XmlElement& root, const std::string& where);

}  // namespace tellurion::raster
