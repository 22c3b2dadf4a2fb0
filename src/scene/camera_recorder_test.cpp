#include "scene/camera_recorder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "geo/body.h"
#include "scene/bookmarks.h"
#include "scene/key_frames.h"

namespace tellurion::scene {
namespace {

using geo::Angle;

Camera cameraAt(double lat, double lon, double height_m, double heading = 0.0, double pitch = -90.0) {
  return {.position = {.lat = Angle::degrees(lat), .lon = Angle::degrees(lon), .height_m = height_m},
          .heading = Angle::degrees(heading),
          .pitch = Angle::degrees(pitch),
          .roll = {}};
}

double apart_m(const Camera& a, const Camera& b) {
  const geo::Ellipsoid& earth = geo::earth().ellipsoid;
  return geo::length(earth.bodyFromGeodetic(a.position) - earth.bodyFromGeodetic(b.position));
}

/// A flight that stands still between the seconds 2 and 5.
Camera flown(double time_s) {
  const double t = time_s < 2.0 ? time_s : std::max(2.0, time_s - 3.0);
  return cameraAt(10.0 + t, 20.0 + 0.5 * t * t, 1e5 + 1e4 * std::sin(t), 30.0 * t, -60.0 + t);
}

// What was flown at uneven times, written, read and played again, is where it was.
TEST(CameraRecorder, PlaysAgainWhatWasFlown) {
  std::mt19937 random(7);
  CameraRecorder recorder;
  std::vector<double> times;
  for (double t = 0.0; t < 8.0; t += std::uniform_real_distribution(0.002, 0.08)(random))
    times.push_back(t);
  for (const double t : times)
    recorder.add(flown(t), 100.0 + t);
  const auto path = parseCameraPath(formatCameraPath(recorder.keys()), "recorded.csv");
  ASSERT_TRUE(path) << io::describe(path.error());
  EXPECT_NEAR(path->duration().count(), times.back(), 2e-3);
  EXPECT_LE(path->keys().size(), 8.0 * 30.0 + 5.0);
  for (const double t : times) {
    const Camera again = path->at(CameraPath::Seconds(t));
    EXPECT_LT(apart_m(again, flown(t)), 3700.0) << t;  // 222 km a second: half of a thirtieth of one
    EXPECT_NEAR(again.pitch.degrees(), flown(t).pitch.degrees(), 0.05) << t;
  }
  for (double t = 2.2; t < 4.8; t += 0.1)
    EXPECT_LT(apart_m(path->at(CameraPath::Seconds(t)), flown(t)), 1.0) << "the stand is a stand at " << t;
}

TEST(CameraRecorder, AStandIsTwoKeys) {
  CameraRecorder recorder;
  EXPECT_TRUE(recorder.keys().empty());
  for (int i = 0; i < 1000; ++i)
    recorder.add(cameraAt(1, 2, 3), 5.0 + 0.01 * i);
  ASSERT_EQ(recorder.keys().size(), 2u);
  EXPECT_NEAR(recorder.keys().back().seconds, 9.99, 1e-9);
}

// A mouse that tells its place in every other frame: the way is smooth, what is seen of it a staircase.
TEST(CameraRecorder, StandsOfSingleFramesAreNoStands) {
  CameraRecorder recorder;
  constexpr double kSeconds = 20.0;
  const auto way = [](double t) { return cameraAt(5.0 * std::sin(t), 20.0 + t, 1e5 + 5e4 * std::cos(1.7 * t)); };
  for (int i = 0; i < 120 * kSeconds; ++i)
    recorder.add(way((i - i % 2) / 120.0), 3.0 + i / 120.0);
  const auto keys = recorder.keys();
  EXPECT_LE(keys.size(), 30 * kSeconds + 2) << "at most 30 a second";
  const auto path = CameraPath::create(keys);
  ASSERT_TRUE(path);
  for (double t = 0.1; t < kSeconds - 0.1; t += 0.07)
    EXPECT_LT(apart_m(path->at(CameraPath::Seconds(t)), way(t)), 0.03 * apart_m(way(t - 0.5), way(t + 0.5))) << t;
}

// However often it is looked at, a flight of few turns is few keys.
TEST(CameraRecorder, KeepsWhatTheSplineCannotRebuild) {
  for (const double rate : {30.0, 60.0, 240.0}) {
    CameraRecorder steady;
    CameraRecorder winding;
    const auto bends = [](double t) {
      return cameraAt(50.0 + 0.01 * std::sin(t), 0.01 * t, 500.0, 20.0 * std::cos(t), -20);
    };
    std::vector<CameraPath::Key> seen;
    for (int i = 0; i <= 60 * rate; ++i) {
      const double t = i / rate;
      steady.add(cameraAt(0.0, 0.5 * t, 1e5, 90.0, -30.0), t);
      winding.add(bends(t), t);
    }
    EXPECT_LE(steady.keys().size(), 4u) << rate;
    const auto keys = winding.keys();
    EXPECT_LE(keys.size(), 60u * 8u) << "ten turns of six seconds, " << rate;
    const auto path = CameraPath::create(keys);
    ASSERT_TRUE(path);
    for (double t = 0.0; t <= 60.0; t += 1.0 / 30.0) {
      const Camera again = path->at(CameraPath::Seconds(t));
      EXPECT_LT(apart_m(again, bends(t)), 0.01 + 0.3 * apart_m(bends(t), bends(t + 1.0 / 30.0))) << t;
      EXPECT_NEAR(again.heading.degrees(), bends(t).heading.degrees(), 0.25) << t << " at " << rate;
    }
  }
}

TEST(KeyFrames, AndKeysAreTheSameThing) {
  std::vector<KeyFrame> frames{{cameraAt(0, 0, 1e6)}, {cameraAt(1, 0, 1e5), 2.0}, {cameraAt(2, 0, 1e4), -1.0}};
  const auto keys = keysOf(frames);
  ASSERT_TRUE(CameraPath::create(keys)) << "also with a leg that is too short";
  EXPECT_EQ(keys[1].seconds, 2.0);
  const auto again = keyFramesOf(keys);
  ASSERT_EQ(again.size(), 3u);
  EXPECT_EQ(again[1].leg_s, 2.0);
  EXPECT_NEAR(again[2].leg_s, kLeastLeg_s, 1e-12);
  frames[1].leg_s = 100000.0;
  EXPECT_EQ(keysOf(frames)[1].seconds, 100000.0) << "a long leg is not cut";
  frames[1].leg_s = std::nan("");
  EXPECT_TRUE(CameraPath::create(keysOf(frames)));
  EXPECT_TRUE(keysOf({}).empty());
}

TEST(KeyFrames, MoveAsInAList) {
  for (std::size_t from = 0; from < 5; ++from) {
    for (std::size_t to = 0; to < 6; ++to) {
      std::vector<KeyFrame> frames;
      std::vector<double> expected;
      for (int i = 0; i < 5; ++i) {
        frames.push_back({cameraAt(i, 0, 0)});
        expected.push_back(i);
      }
      moveKeyFrame(frames, from, to);
      if (to < 5) {
        expected.erase(expected.begin() + static_cast<std::ptrdiff_t>(from));
        expected.insert(expected.begin() + static_cast<std::ptrdiff_t>(to), static_cast<double>(from));
      }
      for (std::size_t i = 0; i < 5; ++i)
        EXPECT_NEAR(frames[i].camera.position.lat.degrees(), expected[i], 1e-9);
    }
  }
}

TEST(Bookmarks, ComeBackAsTheyWere) {
  std::mt19937 random(11);
  const auto between = [&random](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  const std::vector<std::string> names{"Everest", "a \"quoted\" \\ name", "Z\u00fcrich \u5317\u4eac", "",
                                       "tab\there\nline"};
  std::vector<Bookmark> bookmarks;
  for (const std::string& name : names)
    bookmarks.push_back(
        {name, "mars",
         cameraAt(between(-90, 90), between(-180, 180), between(0, 1e7), between(-180, 180), between(-90, 90))});
  const auto again = parseBookmarks(formatBookmarks(bookmarks), "bookmarks.toml");
  ASSERT_TRUE(again) << io::describe(again.error());
  ASSERT_EQ(again->size(), bookmarks.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    EXPECT_EQ((*again)[i].name, names[i]);
    EXPECT_EQ((*again)[i].body, "mars");
    EXPECT_LT(apart_m((*again)[i].camera, bookmarks[i].camera), 1e-3);
    EXPECT_NEAR((*again)[i].camera.heading.degrees(), bookmarks[i].camera.heading.degrees(), 1e-6);
  }
  EXPECT_TRUE(parseBookmarks("", "b")->empty());
}

TEST(Bookmarks, DamagedOnesAreToldAndWhere) {
  for (const char* text : {"[[bookmark]]\nname = 3\n", "[[bookmark]]\nname = \"x\"\n", "bookmark = 5", "][",
                           "[[other]]\n", "[[bookmark]]\nname=\"a\"\nbody=\"earth\"\ncamera=\"95,0,0\""}) {
    const auto read = parseBookmarks(text, "b.toml");
    ASSERT_FALSE(read) << text;
    EXPECT_NE(io::describe(read.error()).find("b.toml"), std::string::npos) << io::describe(read.error());
  }
}

}  // namespace
}  // namespace tellurion::scene
