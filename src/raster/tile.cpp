#include "raster/tile.h"

namespace tellurion::raster {

std::optional<Kind> kindByName(std::string_view name) {
  if (name == "elevation") return Kind::elevation;
  if (name == "imagery") return Kind::imagery;
  return std::nullopt;
}

std::string_view nameOf(Kind kind) {
  return kind == Kind::elevation ? "elevation" : "imagery";
}

}  // namespace tellurion::raster
