#include "scene/parse_place.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace tellurion::scene {
namespace {

double lat(const WrittenPlace& place) {
  return place.camera.position.lat.degrees();
}
double lon(const WrittenPlace& place) {
  return place.camera.position.lon.degrees();
}

struct Sexagesimal {
  int degrees;
  int minutes;
  double seconds;
};

/// Of an angle that is a whole number of tenths of a second.
Sexagesimal sexagesimal(int tenths) {
  return {tenths / 36000, tenths / 600 % 60, (tenths % 600) / 10.0};
}

/// The same place in every notation that parsePlace promises; tenths of a second, positive to the north and the east.
std::vector<std::string> notations(int latTenths, int lonTenths) {
  const char ns = latTenths < 0 ? 'S' : 'N', ew = lonTenths < 0 ? 'W' : 'E';
  const char* s1 = latTenths < 0 ? "-" : "";
  const char* s2 = lonTenths < 0 ? "-" : "";
  const Sexagesimal a = sexagesimal(std::abs(latTenths)), o = sexagesimal(std::abs(lonTenths));
  const double la = std::abs(latTenths) / 36000.0, lo = std::abs(lonTenths) / 36000.0;
  const double lam = a.minutes + a.seconds / 60.0, lom = o.minutes + o.seconds / 60.0;
  std::vector<std::string> all;
  for (const char* between : {", ", ",", " ", "; ", " / "}) {
    all.push_back(fmt::format("{}{:.8f}{}{}{:.8f}", s1, la, between, s2, lo));
    all.push_back(fmt::format("{:.8f}{}{}{:.8f}{}", la, ns, between, lo, ew));
    all.push_back(fmt::format("{:.8f}\u00b0 {}{}{:.8f}\u00b0 {}", la, ns, between, lo, ew));
    all.push_back(fmt::format("{}{:.8f}\u00b0{}{}{:.8f}\u00b0", s1, la, between, s2, lo));
    for (const auto& [d, m, s] : {std::array{"\u00b0", "'", "\""}, std::array{"\u00b0", "\u2032", "\u2033"},
                                  std::array{"d", "m", "s"}, std::array{"\u00b0 ", "\u2019 ", "\u201d"},
                                  std::array{" deg ", " min ", " sec"}, std::array{"\u00ba", "'", "''"}}) {
      all.push_back(fmt::format("{}{}{}{}{:.1f}{} {}{}{}{}{}{}{:.1f}{} {}", a.degrees, d, a.minutes, m, a.seconds, s,
                                ns, between, o.degrees, d, o.minutes, m, o.seconds, s, ew));
      all.push_back(fmt::format("{} {}{}{}{}{:.1f}{}{}{} {}{}{}{}{:.1f}{}", ns, a.degrees, d, a.minutes, m, a.seconds,
                                s, between, ew, o.degrees, d, o.minutes, m, o.seconds, s));
      all.push_back(fmt::format("{}{}{}{:.6f}{}{}{}{}{}{}{:.6f}{}{}", "", a.degrees, d, lam, m, ns, between, "",
                                o.degrees, d, lom, m, ew));
      all.push_back(fmt::format("{}{}{}{}{}{:.1f}{}{}{}{}{}{}{}{:.1f}{}", s1, a.degrees, d, a.minutes, m, a.seconds, s,
                                between, s2, o.degrees, d, o.minutes, m, o.seconds, s));
    }
    all.push_back(fmt::format("{}{}:{:02}:{:04.1f}{}{}{}:{:02}:{:04.1f}", s1, a.degrees, a.minutes, a.seconds, between,
                              s2, o.degrees, o.minutes, o.seconds));
    all.push_back(fmt::format("{} {} {:.1f} {}{}{} {} {:.1f} {}", a.degrees, a.minutes, a.seconds, ns, between,
                              o.degrees, o.minutes, o.seconds, ew));
    all.push_back(fmt::format("{}{} {:.6f}{}{}{} {:.6f}", ns, a.degrees, lam, between, ew, o.degrees, lom));
  }
  all.push_back(fmt::format("{}{} {} {:.1f} {}{} {} {:.1f}", s1, a.degrees, a.minutes, a.seconds, s2, o.degrees,
                            o.minutes, o.seconds));
  all.push_back(fmt::format("{}{} {:.6f} {}{} {:.6f}", s1, a.degrees, lam, s2, o.degrees, lom));
  all.push_back(fmt::format("{} {:.8f} {} {:.8f}", ew, lo, ns, la));
  all.push_back(fmt::format("{:.8f} {} {:.8f} {}", lo, ew, la, ns));
  all.push_back(fmt::format("lat {}{:.8f} lon {}{:.8f}", s1, la, s2, lo));
  all.push_back(fmt::format("Lon: {}{:.8f}, Lat: {}{:.8f}", s2, lo, s1, la));
  all.push_back(fmt::format("latitude={}{:.8f} longitude={}{:.8f}", s1, la, s2, lo));
  return all;
}

TEST(ParsePlace, ReadsEveryNotationOfAPlace) {
  constexpr unsigned kSeed = 41;
  std::mt19937 random(kSeed);
  for (int i = 0; i < 200; ++i) {
    const int latTenths = std::uniform_int_distribution(-90 * 36000, 90 * 36000)(random);
    const int lonTenths = std::uniform_int_distribution(-180 * 36000, 180 * 36000)(random);
    for (const std::string& text : notations(latTenths, lonTenths)) {
      const auto place = parsePlace(text);
      ASSERT_TRUE(place) << "seed " << kSeed << ": '" << text << "': " << io::describe(place.error());
      EXPECT_NEAR(lat(*place), latTenths / 36000.0, 2e-8) << text;
      EXPECT_NEAR(lon(*place), lonTenths / 36000.0, 2e-8) << text;
      EXPECT_FALSE(place->hasHeight) << text;
    }
  }
}

TEST(ParsePlace, ReadsHeights) {
  struct Case {
    const char* text;
    double height_m;
  };
  for (const auto& [text, height_m] :
       {Case{"27.98, 86.92, 8848", 8848}, Case{"27.98 86.92 8848 m", 8848}, Case{"27.98N 86.92E 8848m", 8848},
        Case{"27.98, 86.92, 8.8 km", 8800}, Case{"27.98 86.92 alt 29029 ft", 8848.0392}, Case{"27.98 86.92 8848", 8848},
        Case{"27d58m48sN 86d55m12sE 12 km", 12000}, Case{"N27 58.8 E86 55.2 height 5 m", 5},
        Case{"lat 27.98 lon 86.92 h -30", -30}, Case{"27.98, 86.92, -400 m", -400}}) {
    const auto place = parsePlace(text);
    ASSERT_TRUE(place) << text << ": " << io::describe(place.error());
    EXPECT_NEAR(lat(*place), 27.98, 1e-9) << text;
    EXPECT_NEAR(lon(*place), 86.92, 1e-9) << text;
    EXPECT_TRUE(place->hasHeight) << text;
    EXPECT_NEAR(place->camera.position.height_m, height_m, 1e-6) << text;
  }
}

TEST(ParsePlace, TellsSecondsFromSouth) {
  for (const char* text :
       {"33d51m10 S 151d12m40 E", "33d51m10 s, 151d12m40 e", "33d51m10S 151d12m40E", "33d51m10s S 151d12m40s E",
        "33D51M10 S 151D12M40 E", "33 d 51 m 10 s S 151 d 12 m 40 s E"}) {
    const auto place = parsePlace(text);
    ASSERT_TRUE(place) << text << ": " << io::describe(place.error());
    EXPECT_NEAR(lat(*place), -(33 + 51 / 60.0 + 10 / 3600.0), 1e-9) << text;
    EXPECT_NEAR(lon(*place), 151 + 12 / 60.0 + 40 / 3600.0, 1e-9) << text;
  }
  for (const char* text : {"33d51m10s 151d12m40s", "33D51M10S 151D12M40S", "33d 51m 10s 151d 12m 40s"}) {
    const auto place = parsePlace(text);
    ASSERT_TRUE(place) << text << ": " << io::describe(place.error());
    EXPECT_GT(lat(*place), 0) << text;
  }
  for (const char* text : {"33d51m10s, 151d12m40s E", "33D51M10S 151D12M40E"})
    EXPECT_FALSE(parsePlace(text)) << text;
}

// Commas are decimals where they cannot be separators; where they can be both, nobody guesses.
TEST(ParsePlace, ReadsDecimalCommasWhereTheyAreCertain) {
  std::mt19937 random(47);
  for (int i = 0; i < 500; ++i) {
    const int a = std::uniform_int_distribution(0, 8999)(random), o = std::uniform_int_distribution(0, 17999)(random);
    const auto comma = [](int hundredths) { return fmt::format("{},{:02}", hundredths / 100, hundredths % 100); };
    for (const std::string& text :
         {comma(a) + "; " + comma(o), comma(a) + ";" + comma(o), comma(a) + " / " + comma(o), comma(a) + " " + comma(o),
          comma(a) + "N " + comma(o) + "E", comma(a) + "\u00b0 N, " + comma(o) + "\u00b0 E",
          "E " + comma(o) + ", N " + comma(a), "lat " + comma(a) + " lon " + comma(o)}) {
      const auto place = parsePlace(text);
      ASSERT_TRUE(place) << text << ": " << io::describe(place.error());
      EXPECT_NEAR(lat(*place), a / 100.0, 1e-9) << text;
      EXPECT_NEAR(lon(*place), o / 100.0, 1e-9) << text;
      EXPECT_FALSE(place->hasHeight) << text;
    }
  }
  EXPECT_NEAR(parsePlace("48,25; 2,35; 100,5 m")->camera.position.height_m, 100.5, 1e-9);
  EXPECT_NEAR(lat(*parsePlace("48\u00b051,5'N 2\u00b021,1'E")), 48 + 51.5 / 60.0, 1e-9);
  for (const char* text : {"48,85, 2,35", "10, 20,5", "27,59 17"}) {
    const auto place = parsePlace(text);
    ASSERT_FALSE(place) << text;
    EXPECT_NE(place.error().message.find("comma"), std::string::npos) << place.error().message;
  }
  EXPECT_TRUE(parsePlace("10,20,-300,40")->hasAttitude) << "a camera as it is printed";
  EXPECT_NEAR(lon(*parsePlace("48,25")), 25.0, 1e-9);
  EXPECT_FALSE(parsePlace("48,25; 2.35, 7, 8"));
}

TEST(ParsePlace, ReadsCameras) {
  const auto place = parsePlace(" 27.5,86.75,12000,30,-25,1 ");
  ASSERT_TRUE(place);
  EXPECT_TRUE(place->hasAttitude);
  EXPECT_NEAR(place->camera.heading.degrees(), 30, 1e-9);
  EXPECT_NEAR(place->camera.pitch.degrees(), -25, 1e-9);
  EXPECT_FALSE(parsePlace("1,2,3")->hasAttitude);
}

TEST(ParsePlace, SaysWhatItDoesNotUnderstand) {
  struct Case {
    const char* text;
    const char* told;
  };
  for (const auto& [text, told] : {Case{"", "needed"},
                                   Case{"12", "needed"},
                                   Case{"Everest", "'Everest'"},
                                   Case{"91 0", "latitude 91"},
                                   Case{"-90.001, 5", "latitude"},
                                   Case{"0, 361", "longitude 361"},
                                   Case{"10 N 20 S", "two latitudes"},
                                   Case{"10 E 20 W", "two longitudes"},
                                   Case{"lon 10 N, lat 20 E", "latitude and a longitude"},
                                   Case{"lat 10 E, 20 N", "latitude and a longitude"},
                                   Case{"N lon 10, E 20", "latitude and a longitude"},
                                   Case{"27;59;17;86;55;30", "more than"},
                                   Case{"-10 S 20 E", "sign and a hemisphere"},
                                   Case{"10 60 0 N 20 E", "60"},
                                   Case{"10 20 61 N 20 E", "61"},
                                   Case{"10.5 20 N 20 E", "decimals"},
                                   Case{"1 2 3 4 5", "latitude and longitude"},
                                   Case{"48,8566,2,3522", "longitude"},
                                   Case{"1..2 3", "1..2"},
                                   Case{"10 20 banana", "'banana'"},
                                   Case{"10, 20, 30 m, 40", "more than"},
                                   Case{"5' 3\" N 20 E", "begins with degrees"},
                                   Case{"10 -5 N 3 E", ""},
                                   Case{"N S", "hemispheres"},
                                   Case{"1e400 5", ""},
                                   Case{"nan nan", ""},
                                   Case{"inf, 3", ""},
                                   Case{"- 5", "number"},
                                   Case{"10\" 20\" 30\"", "needed"},
                                   Case{"12 m 5", ""},
                                   Case{"10,20,30,40,95", "pitch"}}) {
    const auto place = parsePlace(text);
    ASSERT_FALSE(place) << text;
    EXPECT_NE(place.error().message.find(told), std::string::npos) << text << ": " << place.error().message;
  }
  EXPECT_FALSE(parsePlace(std::string(100000, '1')));
  EXPECT_FALSE(parsePlace(std::string_view("1, 2\0", 5)));
}

// Whatever comes, it is refused or a place on the body.
TEST(ParsePlace, BearsAnyText) {
  constexpr unsigned kSeed = 43;
  std::mt19937 random(kSeed);
  const std::vector<std::string> pieces{"1",   "27",  "59.5", "-", "+",      ".",    ",",    ";",  " ",     "\u00b0",
                                        "'",   "\"",  "N",    "s", "E",      "w",    "d",    "m",  "km",    "lat",
                                        "lon", "alt", ":",    "=", "\u2032", "\xc2", "\xff", "e9", "north", "\t"};
  for (int i = 0; i < 100000; ++i) {
    std::string text;
    for (int k = std::uniform_int_distribution(0, 12)(random); k > 0; --k)
      text += pieces[std::uniform_int_distribution<std::size_t>(0, pieces.size() - 1)(random)];
    const auto place = parsePlace(text);
    if (!place) {
      EXPECT_FALSE(place.error().message.empty());
      continue;
    }
    EXPECT_LE(std::abs(lat(*place)), 90.0 + 1e-9) << "seed " << kSeed << ": " << text;
    EXPECT_LE(std::abs(lon(*place)), 360.0 + 1e-9) << text;
    EXPECT_TRUE(std::isfinite(place->camera.position.height_m)) << text;
  }
}

}  // namespace
}  // namespace tellurion::scene
