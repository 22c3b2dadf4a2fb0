#pragma once

#include <array>

namespace tellurion::geo {

/// Sine and cosine.
struct SinCos {
  double sin;
  double cos;
};

/// Of an angle in radians within an eighth of a turn, |x| <= pi / 4 and a hair more: the Taylor series, whose first
/// term left out is below 1e-17. Within 1.2e-16 of the true values, odd and even to the last bit, 0 and 1 at 0. Nothing
/// but sums and products in one order, so the same bits on every machine, and nothing that keeps a loop from being
/// vectorised. NaN in, NaN out.
inline SinCos sinCosSeries(double x) {
  constexpr std::array<double, 8> kSin{
      -1.0 / 6.0,        1.0 / 120.0,        -1.0 / 5040.0,          1.0 / 362880.0,
      -1.0 / 39916800.0, 1.0 / 6227020800.0, -1.0 / 1307674368000.0, 1.0 / 355687428096000.0};
  constexpr std::array<double, 8> kCos{
      1.0 / 24.0,        -1.0 / 720.0,         1.0 / 40320.0,          -1.0 / 3628800.0,
      1.0 / 479001600.0, -1.0 / 87178291200.0, 1.0 / 20922789888000.0, -1.0 / 6402373705728000.0};
  // By halves rather than term after term: the sums do not wait for each other.
  const double x2 = x * x;
  const double x4 = x2 * x2;
  const double x8 = x4 * x4;
  const auto sum = [&](const std::array<double, 8>& k) {
    return ((k[0] + x2 * k[1]) + x4 * (k[2] + x2 * k[3])) + x8 * ((k[4] + x2 * k[5]) + x4 * (k[6] + x2 * k[7]));
  };
  const double half = 0.5 * x2;
  const double rounded = 1.0 - half;
  return {x + x * (x2 * sum(kSin)), rounded + (((1.0 - rounded) - half) + x4 * sum(kCos))};
}

}  // namespace tellurion::geo
