#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "io/failure.h"
#include "raster/time_extent.h"
#include "raster/xml_document.h"

/// What a Web Map Service says of itself: OGC 06-042 (1.3.0), 01-068r3 (1.1.1), and the older 1.1.0 and 1.0.0.
namespace tellurion::raster {

struct WmsStyle {
  std::string name;
  std::string title;
};

/// A box in a reference, as the server wrote it: minx, miny, maxx, maxy in the order of that version's axes.
struct WmsBox {
  std::string crs;
  std::array<double, 4> values{};
};

struct WmsDimension {
  std::string name;  ///< lower case: "time", "elevation", ...
  std::string units;
  std::string defaultValue;
  std::string values;  ///< as written: parseTimeExtent() reads those of "time"
  bool nearestValue = false;
};

/// A layer. Flags, geographic box, attribution and scales hold what is inherited; the lists are the layer's own, until
/// WmsCapabilities::withInherited() completes them: copies of a long list in thousands of layers cost gigabytes.
struct WmsLayer {
  int parent = -1;   ///< place in WmsCapabilities::layers; -1: outermost
  std::string name;  ///< empty: a heading that cannot be asked for
  std::string title;
  std::string abstract;
  int depth = 0;  ///< 0: the outermost
  bool noSubsets = false;
  int fixedWidth = 0;  ///< pixels; 0: any
  int fixedHeight = 0;
  std::vector<WmsStyle> styles;
  std::vector<std::string> crs;
  std::optional<std::array<double, 4>> lonLatBox_degrees;  ///< west, south, east, north
  std::vector<WmsBox> boxes;
  std::vector<WmsDimension> dimensions;
  std::string attribution;
  std::optional<double> minScaleDenominator;  ///< not to be drawn finer than this
  std::optional<double> maxScaleDenominator;  ///< nor coarser

  const WmsDimension* dimension(std::string_view dimensionName) const;
};

struct WmsCapabilities {
  std::string version;
  std::string title;
  std::string abstract;
  std::string getMapUrl;  ///< may be empty or relative
  std::vector<std::string> formats;
  int maxWidth = 0;  ///< pixels of an image; 0: not stated
  int maxHeight = 0;
  int layerLimit = 0;
  std::vector<WmsLayer> layers;  ///< every <Layer>, in the order of the document

  const WmsLayer* layer(std::string_view name) const;
  /// The layer (one of `layers`) with the styles and references of those around it added, and their boxes and
  /// dimensions where it has no own.
  WmsLayer withInherited(const WmsLayer& layer) const;
};

/// From the root element of a capabilities document. Values that cannot be read (a box that is no box, a scale that is
/// no number) count as not stated. Fails where the root is another document's, where it has no layer or more than
/// 20,000, one of more than 8,192 references, styles and boxes or 64 dimensions, or more than 250,000 of these in all;
/// on a service exception with the server's own words.
io::Result<WmsCapabilities> parseWmsCapabilities(const XmlElement& root, const std::string& where);

}  // namespace tellurion::raster
