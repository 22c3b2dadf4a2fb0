#include "geo/body.h"

namespace tellurion::geo {

Body earth() {
  return {"earth", Ellipsoid(6378137.0, 1.0 / 298.257223563)};
}
Body mars() {
  return {"mars", Ellipsoid(3396190.0, 0.0)};
}
Body moon() {
  return {"moon", Ellipsoid(1737400.0, 0.0)};
}

std::optional<Body> bodyByName(std::string_view name) {
  if (name == "earth") return earth();
  if (name == "mars") return mars();
  if (name == "moon") return moon();
  return std::nullopt;
}

}  // namespace tellurion::geo
