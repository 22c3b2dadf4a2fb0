// Catalogues of stars, the one that comes with the program too, and the table [sky] of scene files.
#include "scene/star_catalogue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "geo/geodetic.h"
#include "scene/frame.h"
#include "scene/scene_file.h"
#include "scene/sky.h"

namespace tellurion::scene {
namespace {

using testing::HasSubstr;

std::string complaint(const std::string& text) {
  const auto read = readStars(text, "own.csv");
  return read ? "" : io::describe(read.error());
}

TEST(StarCatalogue, HasTheBrightestStarsWherePublished) {
  const auto catalogue = brightStars();
  EXPECT_EQ(catalogue->stars.size(), 5044u);
  EXPECT_TRUE(std::ranges::is_sorted(catalogue->stars, {}, &Star::magnitude));
  // The Bright Star Catalogue, 5th edition: hours, minutes and seconds, degrees and minutes, magnitude (J2000).
  struct Known {
    const char* name;
    double hours, minutes, seconds, degrees, arcMinutes, magnitude;
  };
  for (const Known& k :
       {Known{"Sirius", 6, 45, 8.9, -16, 42.97, -1.46}, Known{"Canopus", 6, 23, 57.1, -52, 41.73, -0.72},
        Known{"Vega", 18, 36, 56.3, 38, 47.02, 0.03}, Known{"Polaris", 2, 31, 48.7, 89, 15.85, 2.02},
        Known{"Betelgeuse", 5, 55, 10.3, 7, 24.42, 0.5}}) {
    const double sign = k.degrees < 0.0 ? -1.0 : 1.0;
    const geo::Vec3f expected(geo::directionFromDegrees(k.degrees + sign * k.arcMinutes / 60.0,
                                                        15.0 * (k.hours + k.minutes / 60.0 + k.seconds / 3600.0))
                                  .n);
    const auto near = std::ranges::find_if(catalogue->stars, [&](const Star& star) {
      return geo::length(star.direction_celestial - expected) < 2e-4f &&
             std::abs(static_cast<double>(star.magnitude) - k.magnitude) < 0.15;
    });
    EXPECT_NE(near, catalogue->stars.end()) << k.name;
  }
}

TEST(StarCatalogue, ColoursFollowTheIndex) {
  const geo::Vec3f red = starColour(1.85), blue = starColour(-0.2);
  EXPECT_EQ(red.r, 1.0f);
  EXPECT_LT(red.b, red.g);
  EXPECT_LT(red.b, 0.5f);
  EXPECT_EQ(blue.b, 1.0f);
  EXPECT_LT(blue.r, blue.g);
  for (double bv = -2.0; bv < 8.0; bv += 0.25)
    EXPECT_EQ(std::max({starColour(bv).r, starColour(bv).g, starColour(bv).b}), 1.0f) << bv;
}

TEST(StarCatalogue, ReadsColumnsInAnyOrderAndSortsThem) {
  const auto read =
      readStars("name, magnitude ,dec_degrees,ra_degrees,bv\r\nx,3.5,10,20,\r\n\r\ny,-1,-90,-360,0.5\r\n", "own.csv");
  ASSERT_TRUE(read) << io::describe(read.error());
  ASSERT_EQ(read->stars.size(), 2u);
  EXPECT_EQ(read->stars[0].magnitude, -1.0f);
  EXPECT_EQ(read->stars[1].colour, geo::Vec3f(1.0f));
  EXPECT_NEAR(static_cast<double>(geo::length(read->stars[1].direction_celestial -
                                              geo::Vec3f(geo::directionFromDegrees(10.0, 20.0).n))),
              0.0, 1e-7);
}

TEST(StarCatalogue, SaysWhatIsWrongAndWhere) {
  EXPECT_THAT(complaint(""), HasSubstr("own.csv:1: there is no column 'ra_degrees'"));
  EXPECT_THAT(complaint("ra_degrees,dec_degrees,magnitude\n1,2,3\n1,91,3\n"),
              HasSubstr("own.csv:3: 'dec_degrees' must be a number from -90 to 90, not '91'"));
  EXPECT_THAT(complaint("ra_degrees,dec_degrees,magnitude\n1,2\n"), HasSubstr("own.csv:2: 'magnitude' must be"));
  EXPECT_THAT(complaint("ra_degrees,dec_degrees,magnitude,bv\n1,2,nan,\n"), HasSubstr("'magnitude'"));
  std::string many = "ra_degrees,dec_degrees,magnitude\n";
  for (int i = 0; i <= 1'000'000; ++i)
    many += "1,2,3\n";
  EXPECT_THAT(complaint(many), HasSubstr("more than 1000000 stars"));
}

TEST(SkyEntry, MeansWhatItSays) {
  EXPECT_FALSE(parseScene("", "s.toml")->sky.enabled);
  const auto plain = parseScene("[sky]", "s.toml");
  ASSERT_TRUE(plain) << io::describe(plain.error());
  EXPECT_TRUE(plain->sky.enabled);
  EXPECT_EQ(plain->sky.stars, brightStars());
  const std::vector<std::string> settings{"sky.stars=false", "sky.brightness=2", "sky.discs=false"};
  const auto set = parseScene("", "s.toml", settings);
  ASSERT_TRUE(set) << io::describe(set.error());
  EXPECT_EQ(set->sky.stars, nullptr);
  EXPECT_EQ(set->sky.brightness_stops, 2.0);
  EXPECT_FALSE(set->sky.discs);
  EXPECT_THAT(io::describe(parseScene("[sky]\nmoon = true", "s.toml").error()), HasSubstr("s.toml:2"));
  EXPECT_THAT(io::describe(parseScene("[sky]\nstars = \"none.csv\"", "s.toml").error()), HasSubstr("none.csv"));
}

TEST(Sky, KnowsWhatStandsWhere) {
  const SkyPlaces without = skyPlacesAt(geo::earth(), {});
  EXPECT_EQ(without.bodyFromCelestial, geo::Mat3(1.0));
  EXPECT_FALSE(without.moon_m);
  const SkyPlaces earth = skyPlacesAt(geo::earth(), 1.8e9);
  EXPECT_NE(earth.bodyFromCelestial, geo::Mat3(1.0));
  EXPECT_TRUE(earth.moon_m);
  EXPECT_FALSE(skyPlacesAt(geo::mars(), 1.8e9).moon_m);

  SkySettings settings{.enabled = true, .stars = brightStars()};
  EXPECT_GT(skyFor(settings, earth, geo::earth(), true).sunRadius_radians, 0.0);
  EXPECT_EQ(skyFor(settings, earth, geo::earth(), false).sunRadius_radians, 0.0);
  settings.discs = false;
  EXPECT_FALSE(skyFor(settings, earth, geo::earth(), true).moon_m);
  settings.enabled = false;
  EXPECT_TRUE(skyFor(settings, earth, geo::earth(), true).isEmpty());
}

TEST(Sky, BelongsToEveryPartOfAPicture) {
  Frame frame;
  frame.sky = {
      .stars = brightStars(), .brightness_stops = 2.0, .sunRadius_radians = 0.01, .moon_m = geo::Vec3(4e8, 0, 0)};
  const Frame part = partOf(frame, frame.view);
  EXPECT_EQ(part.sky.stars, frame.sky.stars);
  EXPECT_EQ(part.sky.moon_m, frame.sky.moon_m);
  EXPECT_EQ(part.sky.brightness_stops, 2.0);
}

}  // namespace
}  // namespace tellurion::scene
