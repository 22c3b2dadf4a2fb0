#pragma once

#include <string_view>

namespace tellurion::app {

/// data/places/BODY.csv, which travels inside the program; empty for bodies of which there is none. The definition is
/// written by embed_places.cmake.
std::string_view shippedPlaces(std::string_view body);

}  // namespace tellurion::app
