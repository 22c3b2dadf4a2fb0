#include "raster/near_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "raster/service_url.h"

namespace tellurion::raster {

std::size_t editDistance(std::string_view a, std::string_view b) {
  const std::string first = lowered(a);
  const std::string second = lowered(b);
  std::vector<std::size_t> row(second.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (const char letter : first) {
    std::size_t corner = row[0]++;
    for (std::size_t j = 0; j < second.size(); ++j) {
      const std::size_t exchanged = corner + (letter == second[j] ? 0u : 1u);
      corner = row[j + 1];
      row[j + 1] = std::min({exchanged, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

std::vector<std::string> nearNames(std::string_view wanted, std::span<const std::string> offered, std::size_t most) {
  constexpr std::size_t kLongestCompared = 200;  // the cost grows with the square
  std::vector<std::pair<std::size_t, std::string>> ranked;
  const std::string lower = lowered(wanted.substr(0, kLongestCompared));
  for (const std::string& name : offered) {
    if (name.size() > kLongestCompared || lower.empty()) continue;
    const std::string other = lowered(name);
    const std::size_t distance = editDistance(lower, other);
    const bool contains = other.find(lower) != other.npos || (other.size() > 2 && lower.find(other) != lower.npos);
    if (distance * 3 <= std::max(lower.size(), other.size())) {
      ranked.emplace_back(distance, name);
    } else if (contains) {
      ranked.emplace_back(kLongestCompared + distance, name);
    }
  }
  std::ranges::stable_sort(ranked, {}, &std::pair<std::size_t, std::string>::first);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < std::min(most, ranked.size()); ++i)
    names.push_back(ranked[i].second);
  return names;
}

std::string whatElseThereIs(std::string_view wanted, std::span<const std::string> offered) {
  constexpr std::size_t kMostNear = 3;
  constexpr std::size_t kMostListed = 8;
  const std::vector<std::string> near = nearNames(wanted, offered, kMostNear);
  if (!near.empty()) return fmt::format("; did you mean '{}'?", fmt::join(near, "' or '"));
  if (offered.empty()) return "; there is none";
  const auto listed = offered.subspan(0, std::min(kMostListed, offered.size()));
  const std::string more =
      offered.size() > listed.size() ? fmt::format(" and {} more", offered.size() - listed.size()) : "";
  return fmt::format("; there {} {}{}", offered.size() == 1 ? "is" : "are", fmt::join(listed, ", "), more);
}

}  // namespace tellurion::raster
