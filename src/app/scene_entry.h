#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "raster/service.h"
#include "raster/tile.h"

namespace tellurion::app {

/// An entry of a scene file, [[imagery]] or [[elevation]] by its kind; only what is stated.
std::string tomlOf(const raster::ServiceLayer& entry, raster::Kind kind);

/// The same keys.
nlohmann::ordered_json entryJson(const raster::ServiceLayer& entry);

}  // namespace tellurion::app
