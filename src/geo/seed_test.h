#pragma once

// For the property tests of all rooms: one seed, printed. The same each time, so that a change and not the dice decides
// a run; --gtest_random_seed=N takes another, and TELLURION_TEST_SEED=random a fresh one (tests/hunt.sh does that in a
// loop).

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <random>
#include <string_view>

namespace tellurion::geo {

inline unsigned testSeed() {
  static const unsigned seed = [] {
    constexpr unsigned kUsual = 20261;
    const int given = GTEST_FLAG_GET(random_seed);
    const char* wish = std::getenv("TELLURION_TEST_SEED");
    const bool isFresh = wish != nullptr && std::string_view(wish) == "random";
    const unsigned chosen = given != 0 ? static_cast<unsigned>(given)
                            : isFresh  ? std::random_device{}() % 99999u + 1u
                                       : kUsual;
    std::printf("seed: --gtest_random_seed=%u\n", chosen);
    return chosen;
  }();
  return seed;
}

inline std::mt19937_64 seededGenerator() {
  return std::mt19937_64(testSeed());
}

inline double uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

}  // namespace tellurion::geo
