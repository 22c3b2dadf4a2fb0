// The tables of the air against published figures and plain integrals in double precision.

#include "render/air_tables.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geo/body.h"
#include "render/air_model.h"

namespace tellurion::render {
namespace {

constexpr double kEarthRadius_m = 6371000.0;

class EarthsAir : public testing::Test {
 protected:
  static void SetUpTestSuite() { tables_ = makeAirTables(earth(), kEarthRadius_m); }
  static scene::Atmosphere earth() { return *scene::atmosphereByName("earth"); }

  /// As a sampler reads the row of the sea's height nearest to it, the way straight up being the first texel.
  static const AirTables& tables() { return tables_; }

 private:
  static inline AirTables tables_;
};

/// The row of the transmittance that lies nearest to a height.
int rowOf(const scene::Atmosphere& air, double height_m) {
  const double bottom = kEarthRadius_m + air.bottom_m;
  const double depth = air.top_m - air.bottom_m;
  const double over = height_m - air.bottom_m;
  const double share = std::sqrt(over * (2 * bottom + over) / (depth * (2 * bottom + depth)));
  return static_cast<int>(std::lround(share * (air_shading::kTransmittanceHeight - 1)));
}

/// Height and cosine of a texel of the transmittance, from its layout's definition.
struct Place {
  double height_m;
  double cosine;
};
Place placeOf(const scene::Atmosphere& air, int col, int row) {
  const double bottom = kEarthRadius_m + air.bottom_m;
  const double top = kEarthRadius_m + air.top_m;
  const double widest = std::sqrt(top * top - bottom * bottom);
  const double toHorizon = widest * row / (air_shading::kTransmittanceHeight - 1);
  const double r = std::hypot(toHorizon, bottom);
  const double length = top - r + (toHorizon + widest - top + r) * col / (air_shading::kTransmittanceWidth - 1);
  const double cosine = length > 0 ? (top * top - r * r - length * length) / (2 * r * length) : 1.0;
  return {r - kEarthRadius_m, cosine};
}

double depthByIntegral(const scene::Atmosphere& air, const Place& from, std::size_t band) {
  const double r = kEarthRadius_m + from.height_m;
  const double top = kEarthRadius_m + air.top_m;
  const double length =
      -r * from.cosine + std::sqrt(std::max(top * top - r * r * (1 - from.cosine * from.cosine), 0.0));
  constexpr int kSteps = 4000;
  double depth = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double t = length * (i + 0.5) / kSteps;
    const double h = std::sqrt(r * r + t * t + 2 * r * t * from.cosine) - kEarthRadius_m;
    const double tent = std::max(1 - std::abs(h - air.ozoneMiddle_m) / air.ozoneReach_m, 0.0);
    depth += (air.gasDepth[band] / air.gasHeight_m * std::exp(-h / air.gasHeight_m) +
              air.aerosolDepth[band] / air.aerosolHeight_m * std::exp(-h / air.aerosolHeight_m) +
              air.ozoneDepth[band] / air.ozoneReach_m * tent) *
             length / kSteps;
  }
  return depth;
}

TEST_F(EarthsAir, TransmittanceIsThatOfAPlainIntegral) {
  for (int row = 0; row < air_shading::kTransmittanceHeight; row += 9) {
    for (int col = 0; col < air_shading::kTransmittanceWidth; col += 15) {
      const geo::Vec4f texel =
          tables().transmittance[static_cast<std::size_t>(row * air_shading::kTransmittanceWidth + col)];
      for (int band = 0; band < 3; ++band) {
        const double expected =
            std::exp(-depthByIntegral(earth(), placeOf(earth(), col, row), static_cast<std::size_t>(band)));
        EXPECT_NEAR(static_cast<double>(texel[band]), expected, 0.003 + 0.01 * expected)
            << row << ", " << col << ", " << band;
      }
    }
  }
}

// Bodhaine and others (1999), table 3: 0.0972 at 550 nm, 0.2430 at 440, 0.0410 at 680, of the whole air over the sea.
// 300 Dobson units of ozone take some 0.028 at 550 nm more.
TEST_F(EarthsAir, StandsOverTheSeaAsMeasured) {
  const int row = rowOf(earth(), 0.0);
  const double height = placeOf(earth(), 0, row).height_m;
  ASSERT_NEAR(height, 0.0, 150.0);
  const geo::Vec4f up = tables().transmittance[static_cast<std::size_t>(row * air_shading::kTransmittanceWidth)];
  const scene::Atmosphere air = earth();
  const std::array<double, 3> rayleigh{0.0410, 0.0972, 0.2430};
  const std::array<double, 3> ozone{0.0098, 0.0282, 0.0013};
  for (std::size_t band = 0; band < 3; ++band) {
    const double aerosol = air.aerosolDepth[band] * std::exp(-height / air.aerosolHeight_m);
    const double depth = -std::log(static_cast<double>(up[static_cast<int>(band)])) - aerosol;
    EXPECT_NEAR(depth, rayleigh[band] * std::exp(-height / air.gasHeight_m) + ozone[band], 0.0025) << band;
  }
}

// Kasten and Young (1989): air is crossed 1.994 times as at the zenith at 60 degrees from it, 5.58 times at 80, 10.3 at
// 85 and 38 at 90, where rays are bent, which is left out here: an exponential air of 8.4 km has 35.
TEST_F(EarthsAir, IsAsThickTowardsTheHorizonAsMeasured) {
  scene::Atmosphere air = earth();
  air.aerosolDepth = air.ozoneDepth = {0, 0, 0};
  air.bottom_m = 0.0;
  const AirTables gas = makeAirTables(air, kEarthRadius_m);
  const double zenith = -std::log(static_cast<double>(gas.transmittance[0][1]));
  const auto airMass = [&](double fromZenith) {
    double best = 10.0;
    double mass = 0.0;
    for (int col = 0; col < air_shading::kTransmittanceWidth; ++col) {
      const double angle = std::acos(std::clamp(placeOf(air, col, 0).cosine, -1.0, 1.0)) * 180 / geo::kPi;
      if (std::abs(angle - fromZenith) >= best) continue;
      best = std::abs(angle - fromZenith);
      mass = -std::log(static_cast<double>(gas.transmittance[static_cast<std::size_t>(col)][1])) / zenith;
    }
    return mass;
  };
  EXPECT_NEAR(airMass(60.0), 1.994, 0.03);
  EXPECT_NEAR(airMass(80.0), 5.58, 0.12);
  EXPECT_NEAR(airMass(85.0), 10.3, 0.4);
  EXPECT_NEAR(airMass(90.0), 36.0, 2.5);
}

geo::Vec3f groundLight(const AirTables& tables, int layer, double sunCosine) {
  const double place = 0.5 + 0.5 * std::copysign(std::sqrt(std::abs(sunCosine)), sunCosine);
  const auto col = static_cast<int>(std::lround(place * (air_shading::kGroundLightWidth - 1)));
  return geo::Vec3f(tables.groundLight[static_cast<std::size_t>(
      layer * air_shading::kGroundLightWidth * air_shading::kGroundLightHeight + col)]);
}

TEST_F(EarthsAir, NeverGivesMoreLightThanTheSun) {
  for (double sun = -1.0; sun <= 1.0; sun += 0.02) {
    const geo::Vec3f both =
        groundLight(tables(), 0, sun) * static_cast<float>(std::max(sun, 0.0)) + groundLight(tables(), 1, sun);
    for (int band = 0; band < 3; ++band) {
      EXPECT_GE(both[band], 0.0f);
      EXPECT_LE(static_cast<double>(both[band]), std::max(sun, 0.0) + 0.04) << sun;
    }
  }
  EXPECT_LT(groundLightAt(tables(), earth(), kEarthRadius_m, 0.0, -0.3), 1e-4) << "the night is dark";
}

// A clear sky gives 8 to 20% of what reaches level ground under a high sun (Perez and others, 1990, and any handbook of
// solar energy), and it is blue.
TEST_F(EarthsAir, HasASkyAsBrightAndBlueAsACleanOne) {
  const double sun = std::cos(30.0 * geo::kPi / 180);
  const geo::Vec3f direct = groundLight(tables(), 0, sun) * static_cast<float>(sun);
  const geo::Vec3f sky = groundLight(tables(), 1, sun);
  EXPECT_GT(sky[1] / (sky[1] + direct[1]), 0.08f);
  EXPECT_LT(sky[1] / (sky[1] + direct[1]), 0.20f);
  EXPECT_GT(sky[2] / sky[0], 2.0f);
  const geo::Vec3f low = groundLight(tables(), 0, 0.02);
  EXPECT_GT(low[0] / low[2], 10.0f) << "the low sun is red";
}

TEST(AirModel, MakesAnySphereOfAnEllipsoidAndKeepsItsHorizonAndDay) {
  const geo::Ellipsoid earth = geo::earth().ellipsoid;
  const geo::Vec3 scale = airFromBody(earth);
  const geo::Vec3 toSun = geo::normalize(geo::Vec3(0.3, -0.5, 0.8));
  for (const double lat : {-90.0, -47.0, 0.0, 12.0, 90.0}) {
    for (const double lon : {-180.0, -33.0, 0.0, 120.0}) {
      const geo::Direction up = geo::directionFromDegrees(lat, lon);
      const geo::BodyPosition at = earth.bodyFromDirection(up);
      EXPECT_NEAR(geo::length(at.m * scale), earth.meanRadius_m(), 1e-6);
      const EyeInAir eye = eyeInAir(earth, at, toSun);
      const double onEllipsoid = geo::dot(up.n, toSun);
      EXPECT_EQ(onEllipsoid > 1e-9, eye.sunCosine > 1e-9) << lat << ", " << lon;
      EXPECT_NEAR(onEllipsoid, eye.sunCosine, 0.004);
    }
  }
}

}  // namespace
}  // namespace tellurion::render
