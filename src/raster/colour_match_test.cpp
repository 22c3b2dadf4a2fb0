// Matches against the lines that the pictures were made with.
#include "raster/colour_match.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "geo/seed_test.h"

namespace tellurion::raster {
namespace {

const geo::GeoRect kArea = geo::GeoRect::fromDegrees(40, 10, 44, 14);
const geo::Angle kSpacing = geo::Angle::degrees(0.02);

using Picture = std::function<std::array<double, 3>(double lat, double lon)>;

std::array<double, 3> ground(double lat, double lon) {
  const double wave = std::sin(19.0 * lon + 3.0 * lat) * std::cos(23.0 * lat);
  return {110.0 + 40.0 * wave, 120.0 + 30.0 * wave, 100.0 - 25.0 * wave};
}

ColourSampler sampler(const Picture& picture) {
  return [picture](std::span<const geo::Direction> places, geo::Angle, std::span<Rgba8> out) {
    for (std::size_t i = 0; i < places.size(); ++i) {
      const geo::Geodetic place = geo::geodeticFromDirection(places[i]);
      const auto c = picture(place.lat.degrees(), place.lon.degrees());
      if (std::isnan(c[0])) continue;
      const auto byte = [](double v) { return static_cast<std::uint8_t>(std::lround(std::clamp(v, 0.0, 255.0))); };
      out[i] = {byte(c[0]), byte(c[1]), byte(c[2]), 255};
    }
    return io::Result<void>{};
  };
}

std::optional<ColourMatch> matched(const Picture& from, const Picture& to) {
  auto match = matchColours(sampler(from), sampler(to), {kArea}, kSpacing);
  EXPECT_TRUE(match.has_value());
  return match ? std::move(*match) : std::nullopt;
}

double worstOver(const ColourMatch& match, const Picture& from, const Picture& to) {
  double worst = 0.0;
  for (double lat = 40.05; lat < 44.0; lat += 0.1) {
    for (double lon = 10.05; lon < 14.0; lon += 0.1) {
      const ColourLine line = match.at(geo::directionFromDegrees(lat, lon));
      for (std::size_t k = 0; k < 3; ++k) {
        const double seen = line[k].gain * from(lat, lon)[k] + line[k].offset;
        worst = std::max(worst, std::abs(seen - to(lat, lon)[k]));
      }
    }
  }
  return worst;
}

TEST(ColourMatch, FindsTheLineOfEveryChannel) {
  const Picture other = [](double lat, double lon) {
    const auto c = ground(lat, lon);
    return std::array{0.8 * c[0] + 30.0, 1.3 * c[1] - 20.0, 0.9 * c[2] - 10.0};
  };
  const auto match = matched(ground, other);
  ASSERT_TRUE(match.has_value());
  EXPECT_LT(worstOver(*match, ground, other), 2.0);
  const ColourLine line = match->at(geo::directionFromDegrees(42, 12));
  EXPECT_NEAR(line[0].gain, 0.8, 0.03);
  EXPECT_NEAR(line[1].gain, 1.3, 0.03);
  EXPECT_NEAR(line[2].gain, 0.9, 0.03);
}

TEST(ColourMatch, FollowsALineThatDrifts) {
  const Picture other = [](double lat, double lon) {
    const auto c = ground(lat, lon);
    const double east = (lon - 10.0) / 4.0;
    const double north = (lat - 40.0) / 4.0;
    return std::array{(0.7 + 0.4 * east) * c[0] + 10.0, c[1] + 30.0 * north, (1.1 - 0.3 * north) * c[2] + 15.0 * east};
  };
  const auto match = matched(ground, other);
  ASSERT_TRUE(match.has_value());
  EXPECT_LT(worstOver(*match, ground, other), 7.0);
}

TEST(ColourMatch, CloudsDoNotPullItAside) {
  std::mt19937 random(geo::testSeed());
  std::vector<std::pair<double, double>> clouds;
  std::uniform_real_distribution<double> within(0.2, 3.8);
  for (int i = 0; i < 12; ++i)
    clouds.emplace_back(40.0 + within(random), 10.0 + within(random));
  const Picture other = [](double lat, double lon) {
    const auto c = ground(lat, lon);
    return std::array{0.8 * c[0] + 30.0, 1.1 * c[1] - 5.0, c[2] + 12.0};
  };
  const Picture cloudy = [&](double lat, double lon) {
    for (const auto& [north, east] : clouds) {
      if (std::hypot(lat - north, lon - east) < 0.2) return std::array{240.0, 241.0, 242.0};
    }
    return other(lat, lon);
  };
  const auto match = matched(ground, cloudy);
  ASSERT_TRUE(match.has_value());
  EXPECT_LT(worstOver(*match, ground, other), 8.0);
}

TEST(ColourMatch, HolesTakeThoseAroundAndNothingInCommonIsNoMatch) {
  const Picture half = [](double lat, double lon) {
    auto c = ground(lat, lon);
    c[0] = lon < 12.0 ? c[0] + 25.0 : std::nan("");
    return c;
  };
  const auto match = matched(ground, half);
  ASSERT_TRUE(match.has_value());
  const ColourLine beyond = match->at(geo::directionFromDegrees(42, 13.5));
  EXPECT_NEAR(beyond[0].gain * 110.0 + beyond[0].offset, 135.0, 3.0);
  EXPECT_FALSE(matched(ground, [](double, double) { return std::array{std::nan(""), 0.0, 0.0}; }).has_value());
}

TEST(ColourMatch, FadesOutFarFromWhatIsShared) {
  const auto match = matched(ground, [](double lat, double lon) {
    auto c = ground(lat, lon);
    c[0] += 30.0;
    return c;
  });
  ASSERT_TRUE(match.has_value());
  const Rgba8 grey{100, 100, 100, 200};
  EXPECT_NEAR(match->apply(geo::directionFromDegrees(42, 16), grey).r, 130, 3);
  EXPECT_EQ(match->apply(geo::directionFromDegrees(-20, -120), grey), grey);
  EXPECT_EQ(match->apply(geo::directionFromDegrees(42, 12), grey).a, 200);
  EXPECT_EQ(match->apply(geo::directionFromDegrees(42, 12), Rgba8{}), Rgba8{});
  int before = 130;
  for (double lon = 16.0; lon < 60.0; lon += 0.5) {
    const int now = match->apply(geo::directionFromDegrees(42, lon), grey).r;
    EXPECT_LE(std::abs(now - before), 3) << lon;
    before = now;
  }
}

TEST(ColourMatch, DistantAreasAreMatchedEachForItselfAndLeaveTheRestAlone) {
  const std::vector<geo::GeoRect> areas{geo::GeoRect::fromDegrees(52, 7, 58, 13),
                                        geo::GeoRect::fromDegrees(-23, 127, -17, 133)};
  const Picture above = [](double lat, double lon) {
    auto c = ground(lat, lon);
    c[0] += lat > 0.0 ? 60.0 : -40.0;
    return c;
  };
  const auto match = matchColours(sampler(ground), sampler(above), areas, kSpacing);
  ASSERT_TRUE(match && *match);
  const Rgba8 grey{100, 100, 100, 255};
  const auto redAt = [&](double lat, double lon) {
    return (*match)->apply(geo::directionFromDegrees(lat, lon), grey).r;
  };
  EXPECT_NEAR(redAt(55, 10), 160, 4);
  EXPECT_NEAR(redAt(-20, 130), 60, 4);
  for (const auto& [lat, lon] : {std::pair{75.0, 90.0}, {20.0, 70.0}, {30.0, 60.0}, {0.0, 0.0}, {-80.0, 20.0}})
    EXPECT_EQ((*match)->apply(geo::directionFromDegrees(lat, lon), grey), grey) << lat << " " << lon;
  // From one to the other there is no step.
  int before = redAt(55, 10);
  for (double t = 0.0; t <= 1.0; t += 1.0 / 512) {
    const int now = redAt(55 - 75 * t, 10 + 120 * t);
    EXPECT_LE(std::abs(now - before), 3) << t;
    before = now;
  }
}

}  // namespace
}  // namespace tellurion::raster
