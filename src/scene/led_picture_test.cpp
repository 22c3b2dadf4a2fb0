#include "scene/led_picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "geo/seed_test.h"
#include "scene/procedural_source_test.h"
#include "scene/view_from_test.h"

namespace tellurion::scene {
namespace {

using geo::uniform;

LedPicture anyPicture(std::mt19937_64& random) {
  const auto flag = [&] { return random() % 2 == 0; };
  const Camera camera{.position = {.lat = geo::Angle::degrees(uniform(random, -90, 90)),
                                   .lon = geo::Angle::degrees(uniform(random, -180, 180)),
                                   .height_m = std::exp(uniform(random, 0, 18))},
                      .heading = geo::Angle::degrees(uniform(random, 0, 360)),
                      .pitch = geo::Angle::degrees(uniform(random, -90, 90)),
                      .roll = geo::Angle::degrees(uniform(random, -180, 180))};
  const View view = viewOf(camera, geo::earth().ellipsoid, geo::Angle::degrees(uniform(random, 0.001, 170)),
                           {.width = 64, .height = 48});
  const auto direction = geo::directionFromDegrees(uniform(random, -90, 90), uniform(random, -180, 180));
  LedPicture picture{.eye = view.eye,
                     .viewFromBody = view.viewFromBody,
                     .verticalFov = view.verticalFov,
                     .cutTime_s = uniform(random, 0, 1e6),
                     .tolerance_px = flag() ? uniform(random, 0.01, 1000) : std::numeric_limits<double>::infinity(),
                     .texelTolerance_px = uniform(random, 0.5, 10),
                     .maxSpacing_px = flag() ? uniform(random, 0.01, 1000) : std::numeric_limits<double>::infinity(),
                     .morph = flag(),
                     .exaggeration = uniform(random, 0, 100),
                     .lighting = {.enabled = flag(),
                                  .sun = static_cast<Lighting::Sun>(random() % 3),
                                  .subsolar = direction,
                                  .ambient = uniform(random, 0, 1)},
                     .airEnabled = flag(),
                     .skyEnabled = flag(),
                     .skyBrightness_stops = uniform(random, -20, 20),
                     .discs = flag(),
                     .background = {0.0f, 0.25f, 1.0f}};
  if (flag()) picture.clock_s = uniform(random, -1e10, 1e10);
  if (flag()) picture.exposure_stops = uniform(random, -20, 20);
  for (std::size_t i = random() % 20; i > 0; --i)
    picture.looks.push_back({.visible = flag(),
                             .opacity = uniform(random, 0, 1),
                             .blend = static_cast<BlendMode>(random() % kBlendModes.size()),
                             .brightness = uniform(random, 0, kMostAdjustment),
                             .contrast = uniform(random, 0, kMostAdjustment),
                             .saturation = uniform(random, 0, kMostAdjustment),
                             .gamma = uniform(random, kLeastGamma, kMostAdjustment)});
  picture.order.resize(picture.looks.size());
  std::iota(picture.order.begin(), picture.order.end(), 0u);
  std::ranges::shuffle(picture.order, random);
  return picture;
}

/// What of it reaches the cut and the renderer is within what they bear.
bool isSane(const LedPicture& p) {
  const auto finite = [](const geo::Vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); };
  const bool isRotation = geo::length(geo::cross(p.viewFromBody[0], p.viewFromBody[1]) - p.viewFromBody[2]) < 1e-5;
  const bool areLooks = std::ranges::all_of(p.looks, [](const LayerLook& look) {
    return look.opacity >= 0.0 && look.opacity <= 1.0 && look.gamma >= kLeastGamma && nameOf(look.blend) != nullptr &&
           static_cast<std::size_t>(look.blend) < kBlendModes.size();
  });
  std::vector<std::uint32_t> order = p.order;
  std::ranges::sort(order);
  bool isWhole = order.size() == p.looks.size();
  for (std::uint32_t i = 0; isWhole && i < order.size(); ++i)
    isWhole = order[i] == i;
  return finite(p.eye.m) && isRotation && p.verticalFov.radians() > 0.0 && p.tolerance_px > 0.0 &&
         std::isfinite(p.cutTime_s) && p.exaggeration >= 0.0 && p.exaggeration <= 100.0 && areLooks && isWhole;
}

TEST(LedPicture, isReadAsItWasWrittenToTheLastBit) {
  std::mt19937_64 random = geo::seededGenerator();
  for (int i = 0; i < 500; ++i) {
    const LedPicture picture = anyPicture(random);
    const std::string bytes = encode(picture);
    const auto read = decodeLedPicture(bytes);
    ASSERT_TRUE(read) << io::describe(read.error());
    EXPECT_EQ(encode(*read), bytes);
    EXPECT_EQ(read->eye, picture.eye);
    EXPECT_EQ(read->viewFromBody, picture.viewFromBody);
    EXPECT_EQ(read->clock_s, picture.clock_s);
    EXPECT_EQ(read->order, picture.order);
    EXPECT_TRUE(isSane(*read));
  }
}

TEST(LedPicture, cutOffOrLongerItIsRefused) {
  std::mt19937_64 random = geo::seededGenerator();
  for (int i = 0; i < 20; ++i) {
    const std::string bytes = encode(anyPicture(random));
    for (std::size_t length = 0; length < bytes.size(); ++length)
      EXPECT_FALSE(decodeLedPicture(std::string_view(bytes).substr(0, length))) << length;
    EXPECT_FALSE(decodeLedPicture(bytes + '\0'));
  }
}

TEST(LedPicture, whateverIsReadIsWithinBounds) {
  std::mt19937_64 random = geo::seededGenerator();
  int good = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string bytes = encode(anyPicture(random));
    for (std::size_t changes = 1 + random() % 4; changes > 0; --changes)
      bytes[random() % bytes.size()] = static_cast<char>(random());
    if (const auto read = decodeLedPicture(bytes)) {
      ++good;
      ASSERT_TRUE(isSane(*read)) << i;
    }
  }
  EXPECT_GT(good, 0);
}

TEST(LedPicture, nonsenseIsRefused) {
  std::mt19937_64 random = geo::seededGenerator();
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](auto&& change) {
    LedPicture picture = anyPicture(random);
    picture.looks.resize(2);
    picture.order = {0, 1};
    EXPECT_TRUE(decodeLedPicture(encode(picture)));
    change(picture);
    return !decodeLedPicture(encode(picture));
  };
  EXPECT_TRUE(refused([&](LedPicture& p) { p.eye.m.y = kNan; }));
  EXPECT_TRUE(refused([](LedPicture& p) { p.eye.m.z = std::numeric_limits<double>::infinity(); }));
  EXPECT_TRUE(refused([](LedPicture& p) { p.viewFromBody = geo::Mat3(0.0); }));
  EXPECT_TRUE(refused([](LedPicture& p) { p.viewFromBody[0] = -p.viewFromBody[0]; })) << "a mirror";
  EXPECT_TRUE(refused([](LedPicture& p) { p.viewFromBody *= 1.01; }));
  EXPECT_TRUE(refused([](LedPicture& p) { p.verticalFov = {}; }));
  EXPECT_TRUE(refused([](LedPicture& p) { p.tolerance_px = 0.0; }));
  EXPECT_TRUE(refused([&](LedPicture& p) { p.clock_s = kNan; }));
  EXPECT_TRUE(refused([](LedPicture& p) { p.exaggeration = 101.0; }));
  EXPECT_TRUE(refused([](LedPicture& p) { p.looks[1].opacity = 1.5; }));
  EXPECT_TRUE(refused([](LedPicture& p) { p.looks[1].blend = static_cast<BlendMode>(9); }));
  EXPECT_TRUE(refused([](LedPicture& p) { p.lighting.sun = static_cast<Lighting::Sun>(9); }));
  EXPECT_TRUE(refused([](LedPicture& p) { p.lighting.subsolar.n = geo::Vec3(0.0); }));
  EXPECT_TRUE(refused([](LedPicture& p) { p.order = {0, 0}; }));
  EXPECT_TRUE(refused([](LedPicture& p) { p.order = {0, 2}; }));
  EXPECT_TRUE(refused([](LedPicture& p) { p.order = {0}; }));
}

/// A globe with some layers of imagery.
std::unique_ptr<Globe> layeredGlobe(std::size_t layers) {
  GlobeLayers all;
  all.elevation.push_back({std::make_shared<ProceduralSource>(raster::Kind::elevation, tiling::Scheme::cube, 2)});
  for (std::size_t i = 0; i < layers; ++i) {
    GlobeLayers::Imagery layer;
    layer.source = {std::make_shared<ProceduralSource>(raster::Kind::imagery, tiling::Scheme::cube, 2)};
    layer.look.role = i == 0 ? LayerRole::nightLights : LayerRole::colour;
    all.imagery.push_back(layer);
  }
  return Globe::fromLayers({.tiling = tiling::Scheme::cube}, std::move(all)).value();
}

TEST(LedPicture, aGlobeThatFollowsShowsTheSame) {
  constexpr std::size_t kLayers = 4;
  std::mt19937_64 random = geo::seededGenerator();
  const auto leader = layeredGlobe(kLayers);
  const auto follower = layeredGlobe(kLayers);
  for (int i = 0; i < 100; ++i) {
    // A picture of the right number of layers stands for what a hand would do to the leader.
    LedPicture hand = anyPicture(random);
    hand.airEnabled = i % 2 == 0;
    hand.looks.resize(kLayers);
    hand.order = {0, 1, 2, 3};
    std::ranges::shuffle(hand.order, random);
    const auto cut = apply(hand, *leader, {});
    ASSERT_TRUE(cut);
    const View view = viewOf(hand, {.width = 640, .height = 480});
    const LedPicture led = ledPicture(*leader, view, *cut);
    EXPECT_EQ(led.order, hand.order);
    EXPECT_EQ(led.looks.front().role, LayerRole::nightLights);
    const auto came = decodeLedPicture(encode(led));
    ASSERT_TRUE(came);
    const auto followed = apply(*came, *follower, {.maxTiles = 77});
    ASSERT_TRUE(followed);
    EXPECT_EQ(followed->maxTiles, 77);
    EXPECT_EQ(encode(ledPicture(*follower, viewOf(*came, {.width = 10, .height = 10}), *followed)), encode(led));
    EXPECT_EQ(follower->air().atmosphere, leader->air().atmosphere);
  }
  LedPicture other = anyPicture(random);
  other.looks.resize(kLayers + 1);
  const auto failed = apply(other, *follower, {});
  ASSERT_FALSE(failed);
  EXPECT_NE(failed.error().message.find("has 5 layers of imagery, this one 4"), std::string::npos);
}

}  // namespace
}  // namespace tellurion::scene
