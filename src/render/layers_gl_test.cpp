// Layers as they are drawn against the same formulas in double precision, and what changing them costs.

#include <cmath>

#include "geo/body.h"
#include "geo/seed_test.h"
#include "raster/colour.h"
#include "render/allocation_count_test.h"
#include "render/synthetic_tiles_test.h"
#include "scene/globe.h"
#include "scene/procedural_source_test.h"
#include "scene/texture_image.h"

namespace tellurion::render {
namespace {

using raster::Rgba8;
using scene::BlendMode;
using scene::LayerLook;

constexpr scene::Viewport kSize{48, 36};
constexpr std::uint64_t kMebi = 1u << 20u;

double toSrgb255(double linear) {
  const double l = std::clamp(linear, 0.0, 1.0);
  return 255.0 * (l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1.0 / 2.4) - 0.055);
}

geo::Vec3 lightOf(Rgba8 p) {
  const auto light = [](std::uint8_t byte) { return raster::linearLight(byte / 255.0); };
  return {light(p.r), light(p.g), light(p.b)};
}

double luminance(const geo::Vec3& c) {
  return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z;
}

geo::Vec3 eachOf(const geo::Vec3& v, const std::function<double(double)>& f) {
  return {f(v.x), f(v.y), f(v.z)};
}

geo::Vec3 adjusted(const geo::Vec3& colour, const LayerLook& look) {
  const double grey = raster::linearLight(0.5);
  const geo::Vec3 bright =
      eachOf(colour, [&](double c) { return std::max(0.0, grey + (c * look.brightness - grey) * look.contrast); });
  const double mean = luminance(bright);
  return eachOf(bright, [&](double c) {
    return std::pow(std::clamp(mean + (c - mean) * look.saturation, 0.0, 1.0), 1.0 / look.gamma);
  });
}

double blended(BlendMode mode, double c, double g) {
  switch (mode) {
    case BlendMode::normal:
      return c;
    case BlendMode::multiply:
      return c * g;
    case BlendMode::screen:
      return 1.0 - (1.0 - c) * (1.0 - g);
    case BlendMode::add:
      return std::min(c + g, 1.0);
    case BlendMode::overlay:
      return g <= 0.5 ? 2.0 * c * g : 1.0 - 2.0 * (1.0 - c) * (1.0 - g);
  }
  return 0.0;
}

/// Of texels that are multiplied with their coverage, bottom first.
geo::Vec3 reference(const std::vector<Rgba8>& texels, const std::vector<LayerLook>& looks) {
  geo::Vec3 ground = lightOf(scene::kPlainGround);
  for (std::size_t i = 0; i < texels.size(); ++i) {
    if (!looks[i].visible || texels[i].a == 0) continue;
    const double coverage = texels[i].a / 255.0;
    const geo::Vec3 colour = lightOf(texels[i]) / coverage;
    const geo::Vec3 c = looks[i].adjusts() ? adjusted(colour, looks[i]) : colour;
    const double share = coverage * looks[i].opacity;
    for (int k = 0; k < 3; ++k)
      ground[k] = ground[k] * (1.0 - share) + share * std::min(1.0, blended(looks[i].blend, c[k], ground[k]));
  }
  return ground;
}

Rgba8 multiplied(Rgba8 p) {
  const geo::Vec3 light = lightOf(p) * (p.a / 255.0);
  const auto byte = [](double l) { return static_cast<std::uint8_t>(std::lround(toSrgb255(l))); };
  return {byte(light.x), byte(light.y), byte(light.z), p.a};
}

class Layers : public synthetic::GlTest {
 protected:
  /// The Earth in six tiles from far above the middle of one, unlit.
  static scene::Frame earth() {
    scene::Frame frame;
    frame.view = synthetic::viewAt(geo::earth().ellipsoid, 0, 0, 3e6, 0, -90, kSize, 30);
    frame.light.enabled = false;
    frame.tiles = synthetic::wholeBody(tiling::Tiling(tiling::Scheme::cube), geo::earth().ellipsoid, 0, 16);
    return frame;
  }

  /// The same pictures on all tiles, a layer each.
  static void stack(scene::Frame& frame, const std::vector<synthetic::Image>& images) {
    frame.pictures.clear();
    for (std::size_t i = 0; i < images.size(); ++i)
      frame.pictures.push_back({.image = images[i], .window = {}, .layer = static_cast<std::uint32_t>(i)});
    for (scene::DrawnTile& tile : frame.tiles)
      tile.pictureCount = static_cast<std::uint32_t>(images.size());
  }

  static LayerLook randomLook(std::mt19937_64& random, bool adjusts) {
    LayerLook look{.visible = random() % 5 != 0,
                   .opacity = random() % 3 == 0 ? 1.0 : geo::uniform(random, 0.0, 1.0),
                   .blend = scene::kBlendModes.at(random() % scene::kBlendModes.size())};
    if (random() % 2 == 0) look.blend = BlendMode::normal;
    if (!adjusts || random() % 2 == 0) return look;
    look.brightness = geo::uniform(random, 0.0, 3.0);
    look.contrast = geo::uniform(random, 0.0, 3.0);
    look.saturation = geo::uniform(random, 0.0, 3.0);
    look.gamma = geo::uniform(random, 0.5, 3.0);
    return look;
  }

  static Rgba8 randomTexel(std::mt19937_64& random) {
    const auto byte = [&] { return static_cast<std::uint8_t>(random()); };
    const std::array<std::uint8_t, 4> coverages{0, 255, 255, byte()};
    return {byte(), byte(), byte(), coverages.at(random() % 4)};
  }

  static void expectAll(const raster::Raster<Rgba8>& picture, const geo::Vec3& light, double tolerance = 1.0) {
    for (const Rgba8& pixel : picture.samples) {
      ASSERT_NEAR(pixel.r, toSrgb255(light.x), tolerance);
      ASSERT_NEAR(pixel.g, toSrgb255(light.y), tolerance);
      ASSERT_NEAR(pixel.b, toSrgb255(light.z), tolerance);
    }
  }

  /// Random looks of 1 to 20 layers, pictures of several shapes in several blocks.
  static void expectReference(const RendererOptions& options, int rounds) {
    auto random = geo::seededGenerator();
    Renderer renderer = makeRenderer(options);
    const RenderTarget target = makeTarget(kSize);
    scene::Frame frame = earth();
    for (int round = 0; round < rounds; ++round) {
      std::vector<Rgba8> texels;
      std::vector<synthetic::Image> images;
      frame.looks.clear();
      for (std::size_t count = 1 + random() % 20; count > 0; --count) {
        texels.push_back(multiplied(randomTexel(random)));
        images.push_back(synthetic::plainImage(texels.back(), std::array{4, 18, 258}.at(random() % 3)));
        frame.looks.push_back(randomLook(random, round % 2 == 0));
      }
      stack(frame, images);
      const RenderStatistics drawn = renderer.draw(frame, target);
      EXPECT_EQ(drawn.drawCalls, 1);
      expectAll(readColour(target), reference(texels, frame.looks));
      if (HasFatalFailure()) FAIL() << "round " << round << " of " << texels.size() << " layers";
    }
  }
};

TEST_F(Layers, AreBlendedAsTheFormulasSay) {
  expectReference({}, 150);
}

TEST_F(Layers, AreBlendedAsTheFormulasSayWithTheShadersOfGpus) {
  expectReference({.asOnAnyGpu = true}, 40);
}

// All is of one colour here, so a mean colour is the colour.
TEST_F(Layers, WithoutRoomAreTheirMeanColour) {
  expectReference({.gpuBudgetBytes = 1}, 40);
}

// Wherever a picture is covered, by however much, it has the ground's colour: what is between its texels, and between
// its mip levels, must have it too.
TEST_F(Layers, UncoveredTexelsNeitherDarkenNorColour) {
  auto random = geo::seededGenerator();
  constexpr Rgba8 kGround{180, 120, 60, 255};
  Renderer renderer = makeRenderer();
  const RenderTarget target = makeTarget(kSize);
  for (const int side : {8, 64, 258}) {
    raster::Raster<Rgba8> patches(side, side, {255, 0, 255, 0});
    for (Rgba8& p : patches.samples) {
      if (random() % 2 == 0) p = {kGround.r, kGround.g, kGround.b, 255};
      if (random() % 4 == 0) p = {kGround.r, kGround.g, kGround.b, static_cast<std::uint8_t>(100 + random() % 155)};
    }
    scene::Frame frame = earth();
    frame.looks.resize(2);
    stack(frame, {synthetic::plainImage(kGround), scene::textureFrom(std::move(patches))});
    renderer.draw(frame, target);
    expectAll(readColour(target), lightOf(kGround), 1.5);
  }
}

// ---- What a change costs

class LayerChanges : public synthetic::GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    scene::Scene planet;
    const auto source = [&](raster::Kind kind, int maxLevel) {
      sources.push_back(std::make_shared<scene::ProceduralSource>(kind, planet.tiling, maxLevel));
      return sources.back();
    };
    scene::GlobeLayers layers{.elevation = {source(raster::Kind::elevation, 2)}, .imagery = {}};
    for (const int maxLevel : {6, 2, 5})
      layers.imagery.push_back(
          {.source = source(raster::Kind::imagery, maxLevel), .alsoFrom = {}, .look = {}, .name = {}});
    layers.imagery[1].look.opacity = 0.5;
    layers.imagery[2].look.opacity = 0.7;
    globe = scene::Globe::fromLayers(planet, std::move(layers), {.cpuCacheBytes = 1024 * kMebi}).value();
    renderer.emplace(makeRenderer());
    target.emplace(makeTarget({160, 120}));
  }

  const scene::Frame& drawOnce() {
    options.time_s = *options.time_s + 1.0 / 60.0;
    const scene::Frame& frame = globe->update(view, options, &renderer->residency());
    drawn = renderer->draw(frame, *target);
    return frame;
  }

  void settle() {
    while (true) {
      const scene::Frame& frame = drawOnce();
      if (frame.complete && !frame.morphing) break;
      globe->waitForArrivals(std::chrono::milliseconds(100));
    }
    for (int i = 0; i < 100; ++i)  // what is copied ahead
      drawOnce();
  }

  std::vector<std::shared_ptr<scene::ProceduralSource>> sources;
  std::unique_ptr<scene::Globe> globe;
  std::optional<Renderer> renderer;
  std::optional<RenderTarget> target;
  scene::View view = synthetic::viewAt(geo::earth().ellipsoid, 46, 8, 200e3, 20, -35, {160, 120});
  scene::CutOptions options{.time_s = 0.0};
  RenderStatistics drawn;
};

TEST_F(LayerChanges, OfLooksNeitherAskNorCopyNorAllocate) {
  settle();
  const auto looks = globe->imageryLooks();
  ASSERT_EQ(looks.size(), 3u);
  const auto change = [&](int i) {
    const double wave = 0.5 + 0.5 * std::sin(0.1 * i);
    looks[1].opacity = wave;
    looks[2].opacity = 1.0 - 0.5 * wave;
    looks[2].blend = scene::kBlendModes.at(static_cast<std::size_t>(i) % scene::kBlendModes.size());
    looks[0].saturation = 2.0 * wave;
  };
  change(1);
  const std::uint64_t requests = drawOnce().statistics.requests;
  const std::size_t tiles = drawOnce().tiles.size();
  const int drawCalls = drawn.drawCalls;
  EXPECT_LE(drawCalls, 4);
  startCountingAllocations();
  int uploads = 0;
  bool same = true;
  for (int i = 0; i < 300; ++i) {
    change(i);
    const scene::Frame& frame = drawOnce();
    uploads += drawn.uploads;
    same = same && frame.complete && frame.tiles.size() == tiles && drawn.drawCalls == drawCalls &&
           frame.statistics.requests == requests;
  }
  EXPECT_EQ(allocationsCounted(), 0);
  EXPECT_EQ(uploads, 0);
  EXPECT_TRUE(same);
}

TEST_F(LayerChanges, OfVisibilityShowInTheSameFrameAndAskNothing) {
  settle();
  const auto looks = globe->imageryLooks();
  const std::uint64_t requests = drawOnce().statistics.requests;
  const auto all = readColour(*target);
  for (const std::size_t hidden : {1u, 2u}) {
    looks[hidden].visible = false;
    drawOnce();
    EXPECT_NE(readColour(*target).samples, all.samples) << hidden;
    looks[hidden].visible = true;
    drawOnce();
    EXPECT_EQ(drawn.uploads, 0);
    EXPECT_EQ(readColour(*target).samples, all.samples) << hidden;
  }
  EXPECT_EQ(drawOnce().statistics.requests, requests);
}

TEST_F(LayerChanges, OfOrderShowInTheSameFrameAndAskNothing) {
  settle();
  drawOnce();
  const std::uint64_t requests = globe->update(view, options).statistics.requests;
  const auto before = readColour(*target);
  auto random = geo::seededGenerator();
  std::vector<std::size_t> expected{0, 1, 2};
  for (int i = 0; i < 50; ++i) {
    const std::size_t layer = random() % 3, place = random() % 5;
    std::erase(expected, layer);
    expected.insert(expected.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(place, 2)), layer);
    globe->moveImagery(layer, place);
    const scene::Frame& frame = drawOnce();
    ASSERT_TRUE(std::ranges::equal(globe->imageryOrder(), expected));
    EXPECT_EQ(frame.statistics.requests, requests);
    EXPECT_EQ(drawn.uploads, 0);
    for (const scene::DrawnTile& tile : frame.tiles) {
      std::vector<std::size_t> order;
      for (std::uint32_t p = 0; p < tile.pictureCount; ++p)
        order.push_back(frame.pictures[tile.firstPicture + p].layer);
      ASSERT_EQ(order, expected);
    }
    const bool asAtFirst = std::ranges::is_sorted(expected);
    EXPECT_EQ(readColour(*target).samples == before.samples, asAtFirst) << testing::PrintToString(expected);
  }
  globe->moveImagery(3, 0);
  EXPECT_TRUE(std::ranges::equal(globe->imageryOrder(), expected));
}

TEST_F(LayerChanges, OnlyVisibleLayersMakeTilesFiner) {
  view = synthetic::viewAt(geo::earth().ellipsoid, 46, 8, 30e3, 20, -80, {160, 120});
  options.tolerance_px = 20.0;  // the ground's shape asks for nothing
  globe->imageryLooks()[0].visible = false;
  globe->imageryLooks()[2].visible = false;
  settle();
  const auto deepest = [&] {
    int level = 0;
    for (const auto& [id, count] : sources[1]->requests())  // of the first imagery layer
      level = std::max<int>(level, id.level);
    return level;
  };
  const int before = deepest();
  globe->imageryLooks()[0].visible = true;
  settle();
  EXPECT_GT(deepest(), before);
}

}  // namespace
}  // namespace tellurion::render
