#pragma once

// For the property tests of all rooms: a fresh seed each run, printed, and given again with --gtest_random_seed=N.

#include <gtest/gtest.h>

#include <cstdio>
#include <random>

namespace tellurion::geo {

inline std::mt19937_64 seededGenerator() {
  static const unsigned seed = [] {
    const int given = GTEST_FLAG_GET(random_seed);
    const unsigned chosen = given != 0 ? static_cast<unsigned>(given) : std::random_device{}() % 99999u + 1u;
    std::printf("seed: --gtest_random_seed=%u\n", chosen);
    return chosen;
  }();
  return std::mt19937_64(seed);
}

inline double uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

}  // namespace tellurion::geo
