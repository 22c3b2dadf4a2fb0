#include "geo/ellipsoid.h"

#include <gtest/gtest.h>

#include <GeographicLib/Geocentric.hpp>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geo/body.h"
#include "geo/seed_test.h"

namespace tellurion::geo {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kNanometre = 1e-9;

Geodetic fromDegrees(double lat, double lon, double height_m) {
  return {.lat = Angle::degrees(lat), .lon = Angle::degrees(lon), .height_m = height_m};
}

Vec3 referencePosition(const GeographicLib::Geocentric& reference, double lat, double lon, double height_m) {
  Vec3 p;
  reference.Forward(lat, lon, height_m, p.x, p.y, p.z);
  return p;
}

// How far two geodetic positions lie apart, metres, for positions close together.
double separation_m(const Ellipsoid& ellipsoid, const Geodetic& a, const Geodetic& b) {
  const double radius = std::fabs(ellipsoid.semiMajorAxis_m() + a.height_m);
  const double north = (a.lat - b.lat).radians() * radius;
  const double east = std::remainder((a.lon - b.lon).radians(), 2.0 * kPi) * radius * std::cos(a.lat.radians());
  return std::sqrt(north * north + east * east + (a.height_m - b.height_m) * (a.height_m - b.height_m));
}

double randomLatitude(std::mt19937_64& random) {
  const double lat = std::asin(uniform(random, -1.0, 1.0)) * 180.0 / kPi;
  const int kind = static_cast<int>(uniform(random, 0.0, 20.0));
  if (kind == 0) return std::copysign(90.0 - std::exp(uniform(random, -35.0, 0.0)), lat);  // close to a pole
  if (kind == 1) return std::copysign(std::exp(uniform(random, -35.0, 0.0)), lat);         // close to the equator
  return lat;
}

/// Metres, or parts of the distance from the centre.
struct Extremes {
  double forward = 0.0;
  double backward = 0.0;
  double direction = 0.0;
};

// Largest differences to GeographicLib for random places between two heights.
Extremes differences(const Body& body, double lowest_m, double highest_m, int count, bool relative = false) {
  const Ellipsoid& ellipsoid = body.ellipsoid;
  const GeographicLib::Geocentric reference(ellipsoid.semiMajorAxis_m(), ellipsoid.flattening());
  auto random = seededGenerator();
  Extremes worst;
  for (int i = 0; i < count; ++i) {
    const double lat = randomLatitude(random);
    const double lon = uniform(random, -180.0, 180.0);
    const double height_m = uniform(random, lowest_m, highest_m);
    const Vec3 p = referencePosition(reference, lat, lon, height_m);
    double backLat = 0.0;
    double backLon = 0.0;
    double backHeight_m = 0.0;
    reference.Reverse(p.x, p.y, p.z, backLat, backLon, backHeight_m);
    const Geodetic expected = fromDegrees(backLat, backLon, backHeight_m);
    const Vec3 actual = ellipsoid.bodyFromGeodetic(fromDegrees(lat, lon, height_m)).m;
    const Direction normal = ellipsoid.directionFromBody({p});
    const double reach = std::fabs(ellipsoid.semiMajorAxis_m() + height_m);
    const double unit = relative ? length(p) : 1.0;
    worst.forward = std::max(worst.forward, length(actual - p) / unit);
    worst.backward =
        std::max(worst.backward, separation_m(ellipsoid, ellipsoid.geodeticFromBody({p}), expected) / unit);
    worst.direction = std::max(worst.direction,
                               angleBetween(normal, directionFromDegrees(backLat, backLon)).radians() * reach / unit);
  }
  return worst;
}

void report(const char* what, const Extremes& worst) {
  std::printf("%s: forward %.3g, backward %.3g, normal %.3g\n", what, worst.forward, worst.backward, worst.direction);
}

TEST(Ellipsoid, WithinTenNanometresOfGeographicLibUpToAThousandKilometres) {
  for (const Body& body : {earth(), mars(), moon()}) {
    const Extremes worst = differences(body, -20e3, 1000e3, 400000);
    report(body.name.c_str(), worst);
    EXPECT_LT(worst.forward, 10 * kNanometre) << body.name;
    EXPECT_LT(worst.backward, 10 * kNanometre) << body.name;
    EXPECT_LT(worst.direction, 10 * kNanometre) << body.name;
  }
}

TEST(Ellipsoid, WithinTenNanometresOfGeographicLibFarBelowTheSurface) {
  const Extremes worst = differences(earth(), -5000e3, -20e3, 200000);
  report("below", worst);
  EXPECT_LT(worst.forward, 10 * kNanometre);
  EXPECT_LT(worst.backward, 10 * kNanometre);
}

TEST(Ellipsoid, OneInTenToTheFifteenFarAway) {
  for (const double far_m : {1e7, 1e9, 1e12, 1e15}) {
    const Extremes worst = differences(earth(), 0.1 * far_m, far_m, 100000, true);
    report(std::to_string(far_m).c_str(), worst);
    EXPECT_LT(worst.forward, 1e-15) << far_m;
    EXPECT_LT(worst.backward, 1e-15) << far_m;
    EXPECT_LT(worst.direction, 1e-15) << far_m;
  }
}

// Independent of GeographicLib: forward again in long double, wherever the point lies, for any flattening. The error of
// the angles' own rounding is 2.5e-16 of the distance.
TEST(Ellipsoid, BackAndForthAnywhereForAnyFlattening) {
  auto random = seededGenerator();
  for (const double flattening : {0.0, 1e-16, 1e-9, 1.0 / 298.257223563, 0.1, 0.5, 0.9, 0.999}) {
    const Ellipsoid ellipsoid(6.4e6, flattening);
    for (int i = 0; i < 50000; ++i) {
      const double reach = 6.4e6 * std::exp(uniform(random, -40.0, 20.0));
      Vec3 p(uniform(random, -reach, reach), uniform(random, -reach, reach), uniform(random, -reach, reach));
      if (i % 7 == 0) p.z *= 1e-12;
      if (i % 11 == 0) p.x *= 1e-12, p.y *= 1e-12;
      const Geodetic g = ellipsoid.geodeticFromBody({p});
      ASSERT_LE(std::fabs(g.lat.radians()), kPi / 2.0);
      // The radius of curvature at a pole, by which the rounding of a latitude moves a point.
      const double tolerance_m = 1e-15 * std::max(ellipsoid.semiMajorAxis_m() / (1.0 - flattening), length(p));
      SCOPED_TRACE(::testing::Message() << "f " << flattening << " at " << p.x << " " << p.y << " " << p.z);
      ASSERT_LT(length(ellipsoid.bodyFromDirection(ellipsoid.directionFromBody({p}), g.height_m).m - p), tolerance_m);
      ASSERT_LT(length(ellipsoid.bodyFromGeodetic(g).m - p), tolerance_m);
    }
  }
}

TEST(Ellipsoid, PolesAxisAndCentre) {
  for (const Body& body : {earth(), mars(), Body{"flat", Ellipsoid(1000.0, 0.5)}}) {
    SCOPED_TRACE(body.name);
    const Ellipsoid& e = body.ellipsoid;
    const double b = e.semiMinorAxis_m();
    EXPECT_EQ(e.bodyFromGeodetic(fromDegrees(90.0, 77.0, 0.0)).m, Vec3(0.0, 0.0, b));
    EXPECT_EQ(e.bodyFromGeodetic(fromDegrees(-90.0, 77.0, 10.0)).m, Vec3(0.0, 0.0, -b - 10.0));
    for (const double z : {b + 100.0, b, 0.5 * b, 1e-3, 1e-200}) {
      const Geodetic north = e.geodeticFromBody({Vec3(0.0, 0.0, z)});
      EXPECT_EQ(north.lat, Angle::degrees(90.0)) << z;
      EXPECT_EQ(north.lon, Angle()) << z;
      EXPECT_NEAR(north.height_m, z - b, 2e-16 * b) << z;
      EXPECT_EQ(e.geodeticFromBody({Vec3(-0.0, -0.0, -z)}).lat, Angle::degrees(-90.0)) << z;
      EXPECT_EQ(e.directionFromBody({Vec3(0.0, 0.0, -z)}).n, Vec3(0.0, 0.0, -1.0)) << z;
    }
    const Geodetic centre = e.geodeticFromBody({Vec3(0.0, 0.0, 0.0)});
    EXPECT_EQ(centre.lat, Angle::degrees(90.0));
    EXPECT_EQ(centre.lon, Angle());
    EXPECT_EQ(centre.height_m, -b);
    EXPECT_EQ(e.directionFromBody({Vec3(0.0, 0.0, 0.0)}).n, Vec3(0.0, 0.0, 1.0));
  }
}

TEST(Ellipsoid, EquatorAndDateLine) {
  const Ellipsoid e = earth().ellipsoid;
  EXPECT_EQ(e.bodyFromGeodetic(fromDegrees(0.0, 180.0, 0.0)).m, Vec3(-6378137.0, 0.0, 0.0));
  EXPECT_EQ(e.bodyFromGeodetic(fromDegrees(0.0, -180.0, 0.0)).m, Vec3(-6378137.0, 0.0, 0.0));
  EXPECT_EQ(e.bodyFromGeodetic(fromDegrees(0.0, -90.0, 1.0)).m, Vec3(0.0, -6378138.0, 0.0));
  const Geodetic g = e.geodeticFromBody({Vec3(-6378137.0, -0.0, 0.0)});
  EXPECT_EQ(g.lon, Angle::degrees(180.0));
  EXPECT_EQ(g.lat, Angle());
  EXPECT_EQ(g.height_m, 0.0);
}

// In the equatorial plane within the evolute two places are equally near: the northern one.
TEST(Ellipsoid, SingularDisc) {
  const Ellipsoid e = earth().ellipsoid;
  const GeographicLib::Geocentric reference(e.semiMajorAxis_m(), e.flattening());
  for (const double r : {1e-9, 1.0, 1000.0, 42000.0, 42600.0}) {
    double lat = 0.0;
    double lon = 0.0;
    double height_m = 0.0;
    reference.Reverse(r, 0.0, 0.0, lat, lon, height_m);
    const Geodetic g = e.geodeticFromBody({Vec3(r, 0.0, 0.0)});
    EXPECT_NEAR(g.lat.degrees(), lat, 1e-9) << r;
    EXPECT_NEAR(g.height_m, height_m, 1e-8) << r;
    EXPECT_LT(e.geodeticFromBody({Vec3(r, 0.0, -1e-9)}).lat, Angle()) << r;
  }
}

TEST(Ellipsoid, NanInNanOut) {
  const Ellipsoid e = earth().ellipsoid;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 p(1.0, 2.0, 3.0);
    p[axis] = kNaN;
    EXPECT_TRUE(std::isnan(e.geodeticFromBody({p}).lat.radians()));
    EXPECT_TRUE(std::isnan(e.geodeticFromBody({p}).height_m));
    EXPECT_TRUE(std::isnan(e.directionFromBody({p}).n.z));
    EXPECT_FALSE(e.intersect({{p}, Vec3(1.0, 0.0, 0.0)}).has_value());
    EXPECT_FALSE(e.intersect({{Vec3(1e7, 0.0, 0.0)}, p}).has_value());
    EXPECT_FALSE(e.horizon({p}).hides({Vec3(-1e7, 0.0, 0.0)}));
    EXPECT_FALSE(e.horizon({Vec3(-1e7, 0.0, 0.0)}).hides({p}));
  }
  EXPECT_TRUE(std::isnan(e.bodyFromGeodetic(fromDegrees(kNaN, 0.0, 0.0)).m.z));
  EXPECT_TRUE(std::isnan(e.bodyFromGeodetic(fromDegrees(0.0, 0.0, kNaN)).m.x));
}

TEST(EllipsoidRay, FromOutsideStraightDown) {
  const Ellipsoid e = earth().ellipsoid;
  const Ray down{{Vec3(0.0, 0.0, 1e7)}, Vec3(0.0, 0.0, -2.0)};
  EXPECT_NEAR(*e.intersect(down), (1e7 - e.semiMinorAxis_m()) / 2.0, 1e-8);
  EXPECT_NEAR(*e.intersect(down, 1000.0), (1e7 - e.semiMinorAxis_m() - 1000.0) / 2.0, 1e-8);
  EXPECT_FALSE(e.intersect({down.origin, Vec3(0.0, 0.0, 1.0)}).has_value());
  EXPECT_FALSE(e.intersect({down.origin, Vec3(1.0, 0.0, 0.0)}).has_value());
  EXPECT_FALSE(e.intersect({down.origin, Vec3(0.0, 0.0, 0.0)}).has_value());
  EXPECT_FALSE(e.intersect(down, -7e6).has_value());
}

TEST(EllipsoidRay, FromInsideTheWayOut) {
  const Ellipsoid e = earth().ellipsoid;
  EXPECT_NEAR(*e.intersect({{Vec3(0.0, 0.0, 0.0)}, Vec3(0.0, 3.0, 0.0)}), e.semiMajorAxis_m() / 3.0, 1e-8);
  EXPECT_NEAR(*e.intersect({{Vec3(6e6, 0.0, 0.0)}, Vec3(1.0, 0.0, 0.0)}), 378137.0, 1e-8);
  EXPECT_NEAR(*e.intersect({{Vec3(6e6, 0.0, 0.0)}, Vec3(-1.0, 0.0, 0.0)}), 12378137.0, 1e-8);
  EXPECT_EQ(e.intersect({{Vec3(6378137.0, 0.0, 0.0)}, Vec3(-1.0, 0.0, 0.0)}), 0.0);
}

TEST(EllipsoidRay, HitsLieOnTheRaisedEllipsoidAndAreTheFirst) {
  auto random = seededGenerator();
  int hits = 0;
  for (int i = 0; i < 100000; ++i) {
    const Ellipsoid e(6.4e6, uniform(random, 0.0, 0.3));
    const double raised_m = uniform(random, -1e4, 1e4);
    const double eyeHeight_m = raised_m + std::exp(uniform(random, 0.0, 20.0));
    const double lat = uniform(random, -90.0, 90.0);
    const Ray ray{e.bodyFromGeodetic(fromDegrees(lat, uniform(random, -180.0, 180.0), eyeHeight_m)),
                  Vec3(uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0))};
    const auto t = e.intersect(ray, raised_m);
    if (!t) continue;
    ++hits;
    const Vec3 p = ray.origin.m + *t * ray.direction;
    const double a = e.semiMajorAxis_m() + raised_m;
    const double b = e.semiMinorAxis_m() + raised_m;
    const auto level = [a, b](const Vec3& q) { return (q.x * q.x + q.y * q.y) / (a * a) + q.z * q.z / (b * b) - 1.0; };
    ASSERT_NEAR(level(p), 0.0, 1e-13 * (1.0 + length(ray.origin.m) / a));
    ASSERT_GE(*t, 0.0);
    ASSERT_TRUE(level(ray.origin.m) <= 0.0 || level(ray.origin.m + 0.5 * *t * ray.direction) >= -1e-13);
  }
  EXPECT_GT(hits, 1000);
}

TEST(EllipsoidHorizon, HidesOnlyWhatIsHiddenFromAllEyesNearby) {
  auto random = seededGenerator();
  int hidden = 0;
  for (int i = 0; i < 30000; ++i) {
    const Ellipsoid e = i % 2 == 0 ? earth().ellipsoid : Ellipsoid(1e6, 0.2);
    const double depth_m = uniform(random, 0.0, 1e4);
    const auto place = [&](double height_m) {
      return e.bodyFromGeodetic(fromDegrees(uniform(random, -90.0, 90.0), uniform(random, -180.0, 180.0), height_m));
    };
    const double height_m = std::exp(uniform(random, 0.0, 16.0));
    const BodyPosition eye = place(height_m);
    const double move_m = uniform(random, 0.0, 1.0) * height_m;
    // Most of them just behind the edge.
    const Vec3 aside = normalize(place(0.0).m) * (e.semiMinorAxis_m() * std::exp(uniform(random, -8.0, 0.5)));
    const BodyPosition target = e.bodyFromGeodetic([&] {
      Geodetic g = e.geodeticFromBody({eye.m + aside});
      g.height_m = uniform(random, -depth_m, 2e4);
      return g;
    }());
    if (!e.horizon(eye, depth_m, move_m).hides(target)) continue;
    ++hidden;
    for (int k = 0; k < 8; ++k) {
      const BodyPosition other{eye.m + normalize(place(0.0).m) * (k < 6 ? move_m : uniform(random, 0.0, move_m))};
      ASSERT_TRUE(e.horizon(other, depth_m).hides(target));
    }
  }
  EXPECT_GT(hidden, 1000);
}

TEST(EllipsoidHorizon, HiddenExactlyWhereTheSightRayMeetsTheBodyFirst) {
  auto random = seededGenerator();
  int hidden = 0;
  for (int i = 0; i < 100000; ++i) {
    const Ellipsoid e = i % 2 == 0 ? earth().ellipsoid : Ellipsoid(1e6, 0.2);
    const double depth_m = uniform(random, 0.0, 1e4);
    const auto place = [&](double height_m) {
      return e.bodyFromGeodetic(fromDegrees(uniform(random, -90.0, 90.0), uniform(random, -180.0, 180.0), height_m));
    };
    const BodyPosition eye = place(std::exp(uniform(random, 0.0, 18.0)));
    const BodyPosition target = place(uniform(random, -depth_m, 1e4));
    const auto blocked = e.intersect({eye, target - eye}, -depth_m);
    const bool expected = blocked && *blocked < 1.0;
    const bool actual = e.horizon(eye, depth_m).hides(target);
    hidden += actual ? 1 : 0;
    // The two may differ only within rounding of grazing, and then towards visible; and for targets inside the
    // occluder.
    ASSERT_TRUE(!actual || expected);
    const Vec3 scaled =
        target.m / Vec3(e.semiMajorAxis_m() - depth_m, e.semiMajorAxis_m() - depth_m, e.semiMinorAxis_m() - depth_m);
    if (dot(scaled, scaled) > 1.0 && expected && !actual) {
      const auto deeper = e.intersect({eye, target - eye}, -depth_m - 1.0);
      ASSERT_FALSE(deeper && *deeper < 1.0);
    }
  }
  EXPECT_GT(hidden, 1000);
}

TEST(EllipsoidHorizon, NothingIsHiddenFromInside) {
  const Ellipsoid e = earth().ellipsoid;
  EXPECT_FALSE(e.horizon({Vec3(6e6, 0.0, 0.0)}).hides({Vec3(-7e6, 0.0, 0.0)}));
  EXPECT_TRUE(e.horizon({Vec3(6.4e6, 0.0, 0.0)}).hides({Vec3(-7e6, 0.0, 0.0)}));
  EXPECT_FALSE(e.horizon({Vec3(6.4e6, 0.0, 0.0)}, 7e6).hides({Vec3(-7e6, 0.0, 0.0)}));
}

TEST(Body, ByName) {
  EXPECT_EQ(bodyByName("earth"), earth());
  EXPECT_EQ(bodyByName("mars"), mars());
  EXPECT_EQ(bodyByName("moon"), moon());
  EXPECT_FALSE(bodyByName("Earth").has_value());
  EXPECT_NEAR(earth().ellipsoid.semiMinorAxis_m(), 6356752.314245179, 1e-8);
  EXPECT_NEAR(earth().ellipsoid.meanRadius_m(), 6371008.7714, 1e-3);
}

}  // namespace
}  // namespace tellurion::geo
