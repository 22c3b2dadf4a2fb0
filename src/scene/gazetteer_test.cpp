#include "scene/gazetteer.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "geo/body.h"
#include "scene/arrival.h"
#include "scene/folded_text.h"
#include "scene/view_from_test.h"

namespace tellurion::scene {
namespace {

Gazetteer gazetteerOf(std::string_view csv, const std::string& body = "earth") {
  Gazetteer places;
  const auto added = places.add(csv, body, "places.csv");
  EXPECT_TRUE(added) << io::describe(added.error());
  return places;
}

// What Python's unicodedata makes of them (NFKD without combining characters), but for letters that it leaves as they
// are.
TEST(FoldedText, IsWhatAPersonTypes) {
  const std::pair<const char*, const char*> cases[] = {{"Z\u00fcrich", "zurich"},
                                                       {"S\u00e3o Paulo", "sao paulo"},
                                                       {"C\u00f4te d'Ivoire", "cote divoire"},
                                                       {"Reykjav\u00edk", "reykjavik"},
                                                       {"\u0141\u00f3d\u017a", "lodz"},
                                                       {"H\u00e0 N\u1ed9i", "ha noi"},
                                                       {"Stra\u00dfe", "strasse"},
                                                       {"\u00c6r\u00f8", "aero"},
                                                       {"\u0130stanbul", "istanbul"},
                                                       {"Zu\u0308rich", "zurich"},
                                                       {"N\u2019Djamena", "ndjamena"},
                                                       {"Guinea-Bissau", "guinea bissau"},
                                                       {"Washington, D.C.", "washington d c"},
                                                       {"\u5317\u4eac", "\u5317\u4eac"},
                                                       {"  A  B ", "a b"},
                                                       {"\xff\xc3", ""},
                                                       {"", ""}};
  for (const auto& [text, folded] : cases)
    EXPECT_EQ(foldedText(text), folded) << text;
}

TEST(FoldedText, IsFoldedOnceAndForAll) {
  std::mt19937 random(3);
  for (int i = 0; i < 20000; ++i) {
    std::string text;
    for (int k = 0; k < 8; ++k)
      text += static_cast<char>(std::uniform_int_distribution(0, 255)(random));
    const std::string once = foldedText(text);
    EXPECT_EQ(foldedText(once), once);
  }
}

TEST(Gazetteer, RanksWhatFits) {
  const Gazetteer places = gazetteerOf(
      "name,lat,lon,population\nNew "
      "York,40,-74,8000000\nYork,54,-1,150000\nYorkton,51,-102,16000\nYorkville,41,-88,21000\n"
      "Duryorka,1,1,1\nPari\u0301s,48,2,2000000\n");
  const auto found = places.search("YORK", 10);
  ASSERT_EQ(found.size(), 5u);
  EXPECT_EQ(found[0]->name, "York");
  EXPECT_EQ(found[1]->name, "Yorkville");
  EXPECT_EQ(found[2]->name, "Yorkton");
  EXPECT_EQ(found[3]->name, "New York");
  EXPECT_EQ(found[4]->name, "Duryorka");
  EXPECT_EQ(places.search("york", 2).size(), 2u);
  EXPECT_EQ(places.search("paris", 5).size(), 1u);
  EXPECT_TRUE(places.search("", 5).empty());
  EXPECT_TRUE(places.search("xyz", 5).empty());
}

// Each name of the shipped lists is found by itself, first or beside one of the same name.
TEST(Gazetteer, FindsEachShippedPlaceByItsName) {
  for (const std::string body : {"earth", "mars", "moon"}) {
    Gazetteer places;
    const auto added = places.addFile(TELLURION_SOURCE_DIR "/data/places/" + body + ".csv", body);
    ASSERT_TRUE(added) << io::describe(added.error());
    EXPECT_GT(places.size(), 200u);
    const auto olympus = places.search("olympus mons", 1);
    EXPECT_EQ(olympus.size(), body == "mars" ? 1u : 0u);
    if (!olympus.empty()) {
      EXPECT_NEAR(olympus[0]->lat.degrees(), 18.65, 1e-9);
      EXPECT_NEAR(olympus[0]->lon.degrees(), -133.8, 1e-9);
    }
  }
}

TEST(Gazetteer, ReadsWhatOthersGive) {
  const Gazetteer usgs = gazetteerOf(
      "Feature_Name,Target,Diameter,Center_Latitude,Center_Longitude,Origin,\r\n\"Gale\",\"Mars\",154.08,-5.37,137.81,"
      "\"Walter "
      "F.; a \"\"quoted\"\", astronomer\nof two lines\"\r\n\"Abbe\",\"Moon\",63.98,-57.58,174.77,\"\"\r\n",
      "mars");
  ASSERT_EQ(usgs.size(), 1u);
  EXPECT_EQ(usgs.search("gale", 1)[0]->size_m, 154080.0);
  const Gazetteer ogr = gazetteerOf("\xef\xbb\xbfX,Y,NAME,POP_MAX\n7.4,46.9,Bern,275329\n");
  EXPECT_NEAR(ogr.search("bern", 1)[0]->lon.degrees(), 7.4, 1e-9);
}

TEST(Gazetteer, SaysWhatIsWrongAndWhere) {
  const std::pair<const char*, const char*> cases[] = {{"", "p.csv:1"},
                                                       {"a,b\n", "p.csv:1"},
                                                       {"name,lat,lon\nX,91,0\n", "p.csv:2"},
                                                       {"name,lat,lon\nX,1,2\n\nY,1,east\n", "p.csv:4"},
                                                       {"name,lat,lon\n,1,2\n", "p.csv:2"},
                                                       {"name,lat,lon\nX\n", "p.csv:2"}};
  for (const auto& [text, where] : cases) {
    Gazetteer places;
    const auto added = places.add(text, "earth", "p.csv");
    ASSERT_FALSE(added) << text;
    EXPECT_EQ(added.error().where, where) << text;
  }
  EXPECT_FALSE(Gazetteer().addFile("/nowhere/p.csv", "earth"));
}

TEST(Arrival, SeesThePlaceInTheMiddleAsLargeAsItIs) {
  for (const geo::Body& body : {geo::earth(), geo::mars(), geo::moon(), geo::Body{"flat", geo::Ellipsoid(5e5, 0.3)}}) {
    const Ground ground{body.ellipsoid, [](const geo::Direction& d) { return std::optional(500.0 * d.n.x); }};
    const View now = viewFrom(10, 20, 3e6, 30, -40);
    const Place place{
        .name = "x", .kind = "", .lat = geo::Angle::degrees(-33), .lon = geo::Angle::degrees(151), .size_m = 30e3};
    const View view = arrivalAt(place, now, ground);
    const auto under = pointUnder(view, centreOf(view.viewport), ground);
    ASSERT_TRUE(under);
    const geo::Geodetic g = body.ellipsoid.geodeticFromBody(*under);
    EXPECT_NEAR(g.lat.degrees(), -33, 1e-6);
    EXPECT_NEAR(g.lon.degrees(), 151, 1e-6);
    const double shown_m = geo::length(view.eye - *under) * view.pixelAngle() * view.viewport.height;
    EXPECT_NEAR(place.size_m / shown_m, 2.0 / 3.0, 0.01);
    WrittenPlace written;
    written.camera.position = {.lat = geo::Angle::degrees(5), .lon = geo::Angle::degrees(6)};
    const View there = arrivalAt(written, now, ground);
    const double over_m = body.ellipsoid.geodeticFromBody(there.eye).height_m -
                          ground.heightOrZero_m(body.ellipsoid.directionFromBody(there.eye));
    EXPECT_NEAR(over_m, body.ellipsoid.semiMajorAxis_m() / 600.0, 1.0);
  }
}

TEST(Gazetteer, RefusesEndlessRecords) {
  for (const std::string& row : {std::string(5'000'000, ','), "\"" + std::string(5'000'000, 'a')}) {
    const auto added = Gazetteer().add("name,lat,lon\n" + row, "earth", "p.csv");
    ASSERT_FALSE(added);
    EXPECT_NE(io::describe(added.error()).find("p.csv:2"), std::string::npos) << io::describe(added.error());
    EXPECT_FALSE(Gazetteer().add(row, "earth", "p.csv"));
  }
}

}  // namespace
}  // namespace tellurion::scene
