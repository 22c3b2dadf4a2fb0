#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "geo/ellipsoid.h"

namespace tellurion::geo {

/// A planet or moon, or an invented world: a name and its reference ellipsoid.
struct Body {
  std::string name;
  Ellipsoid ellipsoid;

  friend bool operator==(const Body&, const Body&) = default;
};

Body earth();  ///< WGS 84: a = 6378137 m, 1/f = 298.257223563
Body mars();   ///< IAU sphere that MOLA, Viking, HRSC and HiRISE products are mapped on: 3396190 m (docs/decisions/)
Body moon();   ///< IAU sphere: 1737400 m

/// "earth", "mars", "moon"; nothing for another name.
std::optional<Body> bodyByName(std::string_view name);

}  // namespace tellurion::geo
