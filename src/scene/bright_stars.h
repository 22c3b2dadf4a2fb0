#pragma once

#include <string_view>

namespace tellurion::scene {

/// The text of data/sky/bright_stars.csv, as the build embeds it.
extern const std::string_view kBrightStars;

}  // namespace tellurion::scene
