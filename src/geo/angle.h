#pragma once

#include <compare>

#include "geo/sin_cos_series.h"

namespace tellurion::geo {

inline constexpr double kPi = 3.14159265358979323846;

/// An angle. Never a bare double in a public interface: degrees and radians are its constructors and its readers.
class Angle {
 public:
  constexpr Angle() = default;
  static constexpr Angle degrees(double d) { return Angle(d * (kPi / 180.0)); }
  static constexpr Angle radians(double r) { return Angle(r); }

  constexpr double degrees() const { return radians_ * (180.0 / kPi); }
  constexpr double radians() const { return radians_; }

  constexpr auto operator<=>(const Angle&) const = default;
  constexpr Angle operator-() const { return Angle(-radians_); }
  constexpr Angle operator+(Angle o) const { return Angle(radians_ + o.radians_); }
  constexpr Angle operator-(Angle o) const { return Angle(radians_ - o.radians_); }
  constexpr Angle operator*(double k) const { return Angle(radians_ * k); }
  constexpr Angle operator/(double k) const { return Angle(radians_ / k); }
  constexpr double operator/(Angle o) const { return radians_ / o.radians_; }

 private:
  explicit constexpr Angle(double r) : radians_(r) {}
  double radians_ = 0.0;
};

/// Sine and cosine of an angle in degrees: exact at multiples of 90 degrees, the same to the last bit for angles that
/// differ by an exactly representable multiple of 360. NaN in, NaN out.
SinCos sinCosDegrees(double degrees);

/// Sine and cosine of `quarters` * 90 degrees + `rest`: exact where the rest is 0. No negative zeros. NaN in, NaN out.
/// |rest| at most 45 degrees and a hair. The same bits on every machine.
inline SinCos sinCosQuarters(long long quarters, Angle rest) {
  // Numbers, 0 or 1, and not branches: which quarter a place is in cannot be foreseen.
  const auto quarter = static_cast<int>(quarters & 3);
  const double odd = quarter & 1;
  const double signOfSin = 1 - (quarter & 2);
  const double signOfCos = 1 - ((quarter + 1) & 2);
  const SinCos s = sinCosSeries(rest.radians());
  return {((1.0 - odd) * s.sin + odd * s.cos) * signOfSin + 0.0, ((1.0 - odd) * s.cos + odd * s.sin) * signOfCos + 0.0};
}

/// Sine and cosine of an angle: exact at every angle that Angle::degrees makes from a multiple of 90 within +-360
/// degrees (it reads the double next to pi / 2 as a quarter turn). Elsewhere within 2.5e-16 of the true value, up to
/// 450 degrees. NaN in, NaN out.
SinCos sinCos(Angle angle);

/// The same direction within [-180, 180) degrees. Unchanged, to the last bit, where it is already there. NaN in, NaN
/// out.
Angle wrappedLongitude(Angle longitude);

}  // namespace tellurion::geo
