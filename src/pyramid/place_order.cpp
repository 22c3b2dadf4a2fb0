#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "pyramid/query_tiles.h"
#include "tiling/morton.h"

namespace tellurion::pyramid {
namespace {

constexpr int kKeyLevel = 26;   // finer than any tile holds many of the places of a batch
constexpr int kDigitBits = 11;  // of a counting sort: its counts stay in the first-level cache
constexpr int kSignificantBits = 2 * kDigitBits;

struct Keyed {
  std::uint64_t key;
  std::uint32_t place;
};

std::uint32_t columnOf(double unit) {
  constexpr double kColumns = 1 << kKeyLevel;
  return static_cast<std::uint32_t>(std::max(0.0, std::min(kColumns - 1.0, unit * kColumns)));
}

std::uint64_t keyOf(const tiling::RootPoint& p) {
  return (static_cast<std::uint64_t>(p.root) << (2 * kKeyLevel)) | tiling::interleaved(columnOf(p.u), columnOf(p.v));
}

/// By the digit of the key at `shift`, places with the same one in the order that they had.
void sortByDigit(const std::vector<Keyed>& from, std::vector<Keyed>& to, int shift) {
  constexpr std::uint64_t kMask = (std::uint64_t{1} << kDigitBits) - 1;
  std::array<std::uint32_t, kMask + 1> start{};
  for (const Keyed& k : from)
    ++start[(k.key >> shift) & kMask];
  std::uint32_t sum = 0;
  for (std::uint32_t& s : start)
    sum += std::exchange(s, sum);
  for (const Keyed& k : from)
    to[start[(k.key >> shift) & kMask]++] = k;
}

}  // namespace

OrderedPlaces alongTheCurve(const tiling::Tiling& tiling, std::span<const geo::Direction> places) {
  OrderedPlaces ordered;
  ordered.points.resize(places.size());
  std::vector<Keyed> keyed(places.size());
  std::uint64_t lowest = ~std::uint64_t{0};
  std::uint64_t highest = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    ordered.points[i] = tiling.rootPoint(places[i]);
    keyed[i] = {keyOf(ordered.points[i]), static_cast<std::uint32_t>(i)};
    lowest = std::min(lowest, keyed[i].key);
    highest = std::max(highest, keyed[i].key);
  }
  // Only the highest bits in which keys differ: places that are so near to each other share their tiles anyway, or are
  // few.
  const int differing = places.empty() ? 0 : static_cast<int>(std::bit_width(lowest ^ highest));
  const int shift = std::max(0, differing - kSignificantBits);
  std::vector<Keyed> other(places.size());
  for (int digit = shift; digit < differing; digit += kDigitBits) {
    sortByDigit(keyed, other, digit);
    keyed.swap(other);
  }
  ordered.order.resize(places.size());
  std::ranges::transform(keyed, ordered.order.begin(), [](const Keyed& k) { return k.place; });
  return ordered;
}

}  // namespace tellurion::pyramid
