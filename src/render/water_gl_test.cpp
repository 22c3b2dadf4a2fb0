// The sun's light on drawn water against Cox and Munk's slopes in double precision, with the shaders' own constants.

#include <array>
#include <cmath>

#include "geo/body.h"
#include "render/synthetic_tiles_test.h"
#include "scene/picking.h"

namespace tellurion::render {
namespace shading {
#include "render/shaders/constants.glsl"
}  // namespace shading
namespace {

using raster::Rgba8;
using synthetic::viewAt;

constexpr scene::Viewport kSize{96, 64};

double fromSrgb(std::uint8_t byte) {
  const double s = byte / 255.0;
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

/// Cox and Munk's distribution of slopes, each facet a mirror: the share of sunlight, of irradiance pi, that is sent to
/// the eye.
double mirrored(const geo::Vec3& toEye, const geo::Vec3& up, const geo::Vec3& toSun) {
  const geo::Vec3 facet = geo::normalize(toEye + toSun);
  const double tilt = std::acos(std::clamp(geo::dot(facet, up), -1.0, 1.0));
  const double reflects = 0.02 + 0.98 * std::pow(1.0 - geo::dot(facet, toSun), 5.0);
  const double meanSquare = 0.003 + 0.00512 * 5.0;
  const double density = std::exp(-std::pow(std::tan(tilt), 2.0) / meanSquare) / (geo::kPi * meanSquare);
  return geo::kPi * reflects * density / (4.0 * geo::dot(toEye, up) * std::pow(std::cos(tilt), 4.0));
}

class Water : public synthetic::GlTest {
 protected:
  /// A Moon of black water, but for its relief, which is steep.
  scene::Frame frameOf(double pitch, const geo::Vec3& toSun, std::uint8_t share) const {
    scene::Frame frame;
    frame.view = viewAt(moon_, 10, 30, 400e3, 90, pitch, kSize, 40);
    frame.light = {.enabled = true, .toSun_body = toSun, .ambient = 0.0};
    frame.tiles = synthetic::wholeBody(tiling::Tiling(tiling::Scheme::cube), moon_, 3, 32);
    frame.looks = {{}, {.role = scene::LayerRole::water}};
    const auto colour = synthetic::plainImage({0, 0, 0, 255});
    const auto water = synthetic::plainImage({0, 0, 0, share});
    const auto relief = synthetic::plainImage({200, 60, 128, 255});
    for (scene::DrawnTile& tile : frame.tiles) {
      tile.firstPicture = static_cast<std::uint32_t>(frame.pictures.size());
      tile.pictureCount = 2;
      frame.pictures.push_back({.image = colour, .window = {}, .layer = 0});
      frame.pictures.push_back({.image = water, .window = {}, .layer = 1});
      tile.relief = relief;
    }
    return frame;
  }

  raster::Raster<Rgba8> drawn(const scene::Frame& frame) const {
    RenderTarget target = makeTarget(kSize);
    makeRenderer().draw(frame, target);
    return readColour(target);
  }

  const geo::Ellipsoid moon_ = geo::moon().ellipsoid;
};

TEST_F(Water, MirrorsTheSunAsSlopesAreSpread) {
  for (const double pitch : {-80.0, -45.0, -30.0}) {
    for (const double sunLongitude : {32.0, 45.0, 80.0, 118.0, 123.0}) {
      const geo::Vec3 toSun = geo::directionFromDegrees(12, sunLongitude).n;
      const scene::Frame frame = frameOf(pitch, toSun, 255);
      const auto picture = drawn(frame);
      int compared = 0;
      for (int row = 2; row < kSize.height; row += 5) {
        for (int col = 2; col < kSize.width; col += 7) {
          const geo::Ray ray = scene::rayThrough(frame.view, {col + 0.5, row + 0.5});
          const auto hit = moon_.intersect(ray);
          if (!hit) continue;
          const geo::Vec3 up = geo::normalize(ray.origin.m + ray.direction * *hit);
          if (std::abs(geo::dot(up, toSun)) < 0.006 || geo::dot(-ray.direction, up) < 0.1)
            continue;  // sunset, and the rim
          const double expected = geo::dot(up, toSun) > 0.0 ? std::min(mirrored(-ray.direction, up, toSun), 1.0) : 0.0;
          const std::uint8_t byte = picture.at(col, row).g;
          EXPECT_NEAR(fromSrgb(byte), expected, 0.01 + 0.03 * expected) << pitch << ", " << col << ", " << row;
          ++compared;
        }
      }
      EXPECT_GT(compared, 50) << pitch;
    }
  }
}

TEST_F(Water, IsDarkWhereThereIsNoneAndByNight) {
  const geo::Vec3 toSun = geo::directionFromDegrees(12, 32).n;
  const auto most = [](const raster::Raster<Rgba8>& picture) {
    int brightest = 0;
    for (const Rgba8& pixel : picture.samples)
      brightest = std::max(brightest, static_cast<int>(pixel.g));
    return brightest;
  };
  const int whole = most(drawn(frameOf(-80, toSun, 255)));
  const int half = most(drawn(frameOf(-80, toSun, 128)));
  EXPECT_GT(whole, 100);
  EXPECT_NEAR(fromSrgb(static_cast<std::uint8_t>(half)) / fromSrgb(static_cast<std::uint8_t>(whole)), 0.5, 0.03);
  EXPECT_EQ(most(drawn(frameOf(-80, toSun, 0))), 0);
  EXPECT_EQ(most(drawn(frameOf(-80, -toSun, 255))), 0);
}

// By its own program, and by that of all layers, which a second layer of the same lamps asks for.
TEST_F(Water, AndLampsAreTheSameInTheProgramsOfEachAndOfAllLayers) {
  for (const int roles : {1, 2, 3}) {  // lamps, water, both
    const geo::Vec3 toSun = geo::directionFromDegrees(12, roles == 1 ? 150 : roles == 2 ? 110 : 120).n;
    scene::Frame few = frameOf(-60, toSun, 130);
    few.pictures.clear();
    few.looks = {{}};
    if ((roles & 1) != 0)
      few.looks.push_back({.opacity = 0.6, .brightness = 1.7, .role = scene::LayerRole::nightLights});
    if ((roles & 2) != 0) few.looks.push_back({.brightness = 1.3, .role = scene::LayerRole::water});
    scene::Frame all = few;
    all.looks.push_back(all.looks.back());
    const std::array images{synthetic::plainImage({90, 80, 60, 255}), synthetic::plainImage({0, 0, 0, 100}),
                            synthetic::plainImage({0, 0, 0, 200}), synthetic::plainImage({0, 0, 0, 200})};
    for (scene::Frame* frame : {&few, &all}) {
      for (scene::DrawnTile& tile : frame->tiles) {
        tile.firstPicture = static_cast<std::uint32_t>(frame->pictures.size());
        tile.pictureCount = static_cast<std::uint32_t>(frame->looks.size());
        for (std::uint32_t layer = 0; layer < tile.pictureCount; ++layer) {
          const bool isLast = layer > 0 && layer + 1 == tile.pictureCount && frame == &all;
          frame->pictures.push_back({.image = images[isLast ? layer - 1 : layer], .window = {}, .layer = layer});
        }
      }
    }
    const auto picture = drawn(few);
    const auto expected = drawn(all);
    int lit = 0;
    for (std::size_t i = 0; i < picture.samples.size(); ++i) {
      EXPECT_NEAR(picture.samples[i].r, expected.samples[i].r, 1) << roles << ", " << i;
      EXPECT_NEAR(picture.samples[i].b, expected.samples[i].b, 1) << roles << ", " << i;
      lit += picture.samples[i].r > 20 ? 1 : 0;
    }
    EXPECT_GT(lit, 500) << roles;
  }
}

}  // namespace
}  // namespace tellurion::render
