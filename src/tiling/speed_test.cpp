// Prints what docs/tilings.md says of speed. Off by default: a busy machine is no failure.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>

#include "tiling/places_test.h"

namespace tellurion::tiling {
namespace {

template <class Function>
void printNanoseconds(const char* what, Scheme scheme, std::size_t places, const Function& function) {
  constexpr int kRounds = 30;
  double sum = 0.0;
  const auto start = std::chrono::steady_clock::now();
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t i = 0; i < places; ++i)
      sum += function(i);
  }
  const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - start;
  std::printf("%s %s: %.1f ns (%g)\n", std::string(nameOf(scheme)).c_str(), what,
              taken.count() / (kRounds * static_cast<double>(places)), sum);
}

TEST_P(EveryTiling, DISABLED_Speed) {
  constexpr std::size_t kPlaces = 65536;
  std::vector<geo::Direction> directions;
  std::vector<RootPoint> points;
  std::vector<TileId> tiles;
  for (std::size_t i = 0; i < kPlaces; ++i) {
    directions.push_back(randomDirection(random_));
    points.push_back(tiling_.rootPoint(directions.back()));
    tiles.push_back(tiling_.tileAt(directions.back(), 8));
  }
  const auto time = [scheme = GetParam()](const char* what, const auto& f) {
    printNanoseconds(what, scheme, kPlaces, f);
  };
  time("direction", [&](std::size_t i) { return tiling_.direction(points[i]).n.x; });
  time("rootPoint", [&](std::size_t i) { return tiling_.rootPoint(directions[i]).u; });
  time("wrapped", [&](std::size_t i) { return tiling_.wrapped(points[i])->u; });
  time("bounds", [&](std::size_t i) { return tiling_.bounds(tiles[i]).west.radians(); });
  time("cap", [&](std::size_t i) { return tiling_.cap(tiles[i]).radius.radians(); });
}

}  // namespace
}  // namespace tellurion::tiling
