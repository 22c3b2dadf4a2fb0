#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tellurion::raster {

/// Of all that have one.
template <class Named>
std::vector<std::string> namesOf(const std::vector<Named>& all) {
  std::vector<std::string> names;
  for (const Named& one : all)
    if (!one.name.empty()) names.push_back(one.name);
  return names;
}

/// How many letters to add, take away or exchange to make one word of the other, capitals counted as small letters.
std::size_t editDistance(std::string_view a, std::string_view b);

/// Of the names on offer at most `most` that `wanted` may have meant, the likeliest first: few letters differ, or one
/// contains the other.
std::vector<std::string> nearNames(std::string_view wanted, std::span<const std::string> offered, std::size_t most);

/// Of an entry that names none of the layers that there are.
inline constexpr std::string_view kNameALayer = "name a layer (layer, or URL#LAYER)";

/// "; did you mean 'a' or 'b'?", else "; there are a, b, c and 12 more", else "; there is none".
std::string whatElseThereIs(std::string_view wanted, std::span<const std::string> offered);

}  // namespace tellurion::raster
