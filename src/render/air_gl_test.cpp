// Sky and ground seen through the air, against an integral of single scattering in double precision, in air so thin
// that there is hardly more than that; and what a frame with air must not do.

#include <cmath>
#include <numeric>

#include "geo/body.h"
#include "render/allocation_count_test.h"
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
constexpr double kRadius_m = 6371000.0;

scene::Atmosphere thinAir() {
  scene::Atmosphere air = *scene::atmosphereByName("earth");
  for (std::size_t band = 0; band < 3; ++band) {
    air.gasDepth[band] *= 0.02;
    air.aerosolDepth[band] *= 0.02;
    air.ozoneDepth[band] *= 0.02;
  }
  air.groundAlbedo = {0, 0, 0};
  air.bottom_m = 0.0;
  return air;
}

double fromSrgb(std::uint8_t byte) {
  const double s = byte / 255.0;
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

/// By how many steps of 8 bits the noise that hides them has moved a pixel: dithered() in air.glsl.
double noiseAt(int col, int row) {
  const auto fraction = [](double v) { return v - std::floor(v); };
  const double place = 0.06711056 * (col + 0.5) + 0.00583715 * (kSize.height - row - 0.5);
  return static_cast<double>(shading::kDither) * (fraction(52.9829189 * fraction(place)) - 0.5);
}

/// Single scattering, summed up step by step; the sun's illuminance is pi.
class Reference {
 public:
  Reference(const scene::Atmosphere& air, const geo::Vec3& toSun) : air_(air), toSun_(toSun) {}

  geo::Vec3 light(const geo::Vec3& eye, const geo::Vec3& direction) const {
    const auto air = crossing(eye, direction, kRadius_m + air_.top_m);
    if (!air || air->second <= 0.0) return geo::Vec3(0.0);
    const auto ground = crossing(eye, direction, kRadius_m);
    const double begin = std::max(air->first, 0.0);
    const double end = ground && ground->first > 0.0 ? ground->first : air->second;
    constexpr int kSteps = 300;
    const double step = (end - begin) / kSteps;
    const double cosine = geo::dot(direction, toSun_);
    geo::Vec3 sum(0.0);
    geo::Vec3 depth(0.0);
    for (int i = 0; i < kSteps; ++i) {
      const geo::Vec3 at = eye + direction * (begin + step * (i + 0.5));
      const geo::Vec3 lost = extinction(at) * step;
      depth += lost * 0.5;
      if (!isShaded(at)) sum += glm::exp(-depth - depthToSun(at)) * scattering(at, cosine) * step;
      depth += lost * 0.5;
    }
    return sum;
  }

 private:
  static std::optional<std::pair<double, double>> crossing(const geo::Vec3& from, const geo::Vec3& along,
                                                           double radius) {
    const double b = geo::dot(from, along);
    const double d = b * b - geo::dot(from, from) + radius * radius;
    if (d < 0.0) return std::nullopt;
    return std::pair(-b - std::sqrt(d), -b + std::sqrt(d));
  }
  bool isShaded(const geo::Vec3& at) const {
    const auto ground = crossing(at, toSun_, kRadius_m);
    return ground && ground->second > 0.0;
  }
  static geo::Vec3 of(const scene::ThreeBands& bands) { return {bands[0], bands[1], bands[2]}; }
  geo::Vec3 gasAt(double h) const { return of(air_.gasDepth) / air_.gasHeight_m * std::exp(-h / air_.gasHeight_m); }
  geo::Vec3 aerosolAt(double h) const {
    return of(air_.aerosolDepth) / air_.aerosolHeight_m * std::exp(-h / air_.aerosolHeight_m);
  }
  geo::Vec3 extinction(const geo::Vec3& at) const {
    const double h = geo::length(at) - kRadius_m;
    const double tent = std::max(1.0 - std::abs(h - air_.ozoneMiddle_m) / air_.ozoneReach_m, 0.0);
    return gasAt(h) + aerosolAt(h) + of(air_.ozoneDepth) / air_.ozoneReach_m * tent;
  }
  geo::Vec3 scattering(const geo::Vec3& at, double cosine) const {
    const double h = geo::length(at) - kRadius_m;
    geo::Vec3 aerosol = aerosolAt(h);
    for (int i = 0; i < 3; ++i) {
      const double g = air_.aerosolForward[static_cast<std::size_t>(i)];
      aerosol[i] *= air_.aerosolAlbedo[static_cast<std::size_t>(i)] * (1 - g * g) /
                    (4 * std::pow(1 + g * g - 2 * g * cosine, 1.5));
    }
    return gasAt(h) * (3.0 / 16.0 * (1 + cosine * cosine)) + aerosol;
  }
  geo::Vec3 depthToSun(const geo::Vec3& at) const {
    const double length = crossing(at, toSun_, kRadius_m + air_.top_m)->second;
    constexpr int kSteps = 60;
    geo::Vec3 depth(0.0);
    for (int i = 0; i < kSteps; ++i)
      depth += extinction(at + toSun_ * (length * (i + 0.5) / kSteps)) * (length / kSteps);
    return depth;
  }

  scene::Atmosphere air_;
  geo::Vec3 toSun_;
};

geo::Vec3 sunOver(double lat, double lon) {
  return geo::directionFromDegrees(lat, lon).n;
}

class InAir : public synthetic::GlTest {
 protected:
  scene::Frame frameOf(const scene::View& view, const geo::Vec3& toSun, const scene::Atmosphere& air,
                       double stops) const {
    scene::Frame frame;
    frame.view = view;
    frame.light.toSun_body = toSun;
    frame.ellipsoid = sphere_;
    frame.air = {.enabled = true, .atmosphere = air, .exposure_stops = stops};
    return frame;
  }

  static Renderer makeAirRenderer() {
    Renderer renderer = makeRenderer();
    const auto ready = renderer.prepareAir();
    if (!ready) ADD_FAILURE() << io::describe(ready.error());
    return renderer;
  }

  raster::Raster<Rgba8> drawn(Renderer& renderer, const scene::Frame& frame) const {
    RenderTarget target = makeTarget(kSize);
    drawCalls_ = renderer.draw(frame, target).drawCalls;
    return readColour(target);
  }

  /// How far pixels are off, of those that are bright enough and not so bright that the picture bends them.
  void expectReference(const scene::Frame& frame, const raster::Raster<Rgba8>& picture, int atLeast) const {
    const Reference reference(frame.air.atmosphere, frame.light.toSun_body);
    const double exposure = std::exp2(*frame.air.exposure_stops);
    int compared = 0;
    int beyond = 0;
    double worst = 0.0;
    double sum = 0.0;
    for (int row = 2; row < kSize.height; row += 5) {
      for (int col = 2; col < kSize.width; col += 7) {
        const geo::Ray ray = scene::rayThrough(frame.view, {col + 0.5, row + 0.5});
        const geo::Vec3 direction = geo::normalize(ray.direction);
        if (geo::dot(direction, frame.light.toSun_body) > 0.999) continue;                // the sun's disc
        if (frame.tiles.empty() && sphere_.intersect({ray.origin, direction})) continue;  // no ground is drawn
        // Where ground ends and sky begins is the mesh's to say, within a pixel.
        const double past = geo::length(geo::cross(ray.origin.m, direction)) - kRadius_m;
        const double pixel_m = frame.view.pixelAngle() * (geo::length(ray.origin.m) - kRadius_m);
        if (std::abs(past) < 2.0 * pixel_m + 1000.0) continue;
        const geo::Vec3 expected = reference.light(ray.origin.m, direction) * exposure;
        const Rgba8 pixel = picture.at(col, row);
        const std::array<std::uint8_t, 3> bytes{pixel.r, pixel.g, pixel.b};
        for (int band = 0; band < 3; ++band) {
          if (expected[band] < 0.02 || expected[band] > 0.58) continue;
          // Half a byte is rounding's.
          const std::uint8_t byte = bytes[static_cast<std::size_t>(band)];
          const double rounding = 0.55 * (fromSrgb(static_cast<std::uint8_t>(byte + 1)) - fromSrgb(byte));
          const double noise = noiseAt(col, row) * 2.275 * std::pow(expected[band], 1.4 / 2.4) / 255.0;
          const double off =
              std::max(std::abs(fromSrgb(byte) - noise - expected[band]) - rounding, 0.0) / expected[band];
          sum += off;
          worst = std::max(worst, off);
          ++compared;
          EXPECT_LT(off, 0.1) << col << ", " << row << ", " << band << ": " << expected[band];
          beyond += off > 0.05 ? 1 : 0;
        }
      }
    }
    EXPECT_GT(compared, atLeast);
    EXPECT_LE(beyond, compared / 50) << "of " << compared << " off by more than 5%";
    RecordProperty("worst", std::to_string(worst));
    RecordProperty("mean", std::to_string(sum / std::max(compared, 1)));
    EXPECT_LT(sum / std::max(compared, 1), 0.025) << "of " << compared << ", worst " << worst;
  }

  mutable int drawCalls_ = 0;
  const geo::Ellipsoid sphere_{kRadius_m, 0.0};
};

TEST_F(InAir, TheSkyIsThatOfAnIntegral) {
  Renderer renderer = makeAirRenderer();
  struct Case {
    double height_m, heading, pitch, fov, sunLat, sunLon, stops;
  };
  for (const Case& c :
       {Case{2, 40, 25, 60, 50, 0, 4}, Case{2, 200, 40, 60, 20, 80, 4}, Case{2000, 90, 20, 60, 0, 60, 4},
        Case{30e3, 90, 12, 60, 0, 40, 5}, Case{99e3, 90, -6, 20, 0, 20, 5}}) {
    SCOPED_TRACE(c.height_m);
    const scene::Frame frame = frameOf(viewAt(sphere_, 0, 0, c.height_m, c.heading, c.pitch, kSize, c.fov),
                                       sunOver(c.sunLat, c.sunLon), thinAir(), c.stops);
    expectReference(frame, drawn(renderer, frame), 40);
  }
}

// Black ground: what is seen there is the air's light, from an eye's height up to where the air is a thousandth of the
// body's distance.
TEST_F(InAir, TheAirBeforeTheGroundIsThatOfAnIntegral) {
  Renderer renderer = makeAirRenderer();
  const auto black = synthetic::plainImage({0, 0, 0, 255});
  struct Case {
    double height_m, pitch, fov, stops;
  };
  for (const Case& c : {Case{20e3, -50, 50, 7}, Case{99e3, -40, 50, 7}, Case{101e3, -40, 50, 7},
                        Case{400e3, -60, 60, 7}, Case{15e6, -90, 45, 6.5}, Case{1e8, -90, 7, 6.5}}) {
    SCOPED_TRACE(c.height_m);
    scene::Frame frame =
        frameOf(viewAt(sphere_, 0, 0, c.height_m, 70, c.pitch, kSize, c.fov), sunOver(20, 30), thinAir(), c.stops);
    frame.tiles = synthetic::wholeBody(tiling::Tiling(tiling::Scheme::cube), sphere_, 3, 32);
    for (scene::DrawnTile& tile : frame.tiles)
      synthetic::paint(frame, tile, black);
    expectReference(frame, drawn(renderer, frame), 100);
    EXPECT_LE(drawCalls_, 5);
  }
}

TEST_F(InAir, NothingJumpsWhereTheEyeLeavesTheAir) {
  Renderer renderer = makeAirRenderer();
  const scene::Atmosphere air = *scene::atmosphereByName("earth");
  const auto ground = synthetic::plainImage({120, 110, 90, 255});
  const auto picture = [&](double height_m, double pitch) {
    scene::Frame frame = frameOf(viewAt(sphere_, 0, 0, height_m, 80, pitch, kSize, 50), sunOver(10, 60), air, 1.0);
    frame.tiles = synthetic::wholeBody(tiling::Tiling(tiling::Scheme::cube), sphere_, 2, 32);
    for (scene::DrawnTile& tile : frame.tiles)
      synthetic::paint(frame, tile, ground);
    return drawn(renderer, frame);
  };
  for (const double pitch : {-60.0, -12.0}) {
    const auto below = picture(air.top_m - 20.0, pitch);
    const auto above = picture(air.top_m + 20.0, pitch);
    int worst = 0;
    double sum = 0.0;
    for (std::size_t i = 0; i < below.samples.size(); ++i) {
      for (const int off : {below.samples[i].r - above.samples[i].r, below.samples[i].g - above.samples[i].g,
                            below.samples[i].b - above.samples[i].b}) {
        worst = std::max(worst, std::abs(off));
        sum += std::abs(off);
      }
    }
    EXPECT_LT(sum / (3.0 * static_cast<double>(below.samples.size())), 1.5) << pitch;
    EXPECT_LE(worst, 12) << pitch;
  }
}

// A sky that changes by a few steps of 8 bits over the picture: rounded alone, rows would stand on steps, half of one
// off at their edges.
TEST_F(InAir, SkiesHaveNoBands) {
  Renderer renderer = makeAirRenderer();
  constexpr scene::Viewport kWide{128, 96};
  scene::Frame frame =
      frameOf(viewAt(sphere_, 0, 0, 10.0, 90, 40, kWide, 2.5), sunOver(0, 80), *scene::atmosphereByName("earth"), 2.0);
  RenderTarget target = makeTarget(kWide);
  renderer.draw(frame, target);
  const auto picture = readColour(target);
  renderer.draw(frame, target);
  EXPECT_EQ(readColour(target).samples, picture.samples);
  std::vector<double> means(kWide.height, 0.0);
  for (int row = 0; row < kWide.height; ++row) {
    for (int col = 0; col < kWide.width; ++col)
      means[static_cast<std::size_t>(row)] += picture.at(col, row).g / double{kWide.width};
  }
  // The straight line through them.
  const double middle = 0.5 * (kWide.height - 1);
  double mean = 0.0;
  double slope = 0.0;
  double squares = 0.0;
  for (int row = 0; row < kWide.height; ++row) {
    const double from = row - middle;
    mean += means[static_cast<std::size_t>(row)] / kWide.height;
    slope += from * means[static_cast<std::size_t>(row)];
    squares += from * from;
  }
  slope /= squares;
  ASSERT_GT(std::abs(slope) * kWide.height, 2.0) << "steps to be seen";
  ASSERT_LT(std::abs(slope) * kWide.height, 12.0) << "and broad ones";
  double worst = 0.0;
  for (int row = 0; row < kWide.height; ++row) {
    const double expected = mean + slope * (row - middle);
    worst = std::max(worst, std::abs(means[static_cast<std::size_t>(row)] - expected));
    for (int col = 0; col < kWide.width; ++col)
      EXPECT_LT(std::abs(picture.at(col, row).g - expected), 1.3)
          << "noise is less than a step: " << col << ", " << row;
  }
  EXPECT_LT(worst, 0.25);
}

TEST_F(InAir, WithoutItPicturesAreWhatTheyWere) {
  const auto ground = synthetic::plainImage({120, 110, 90, 255});
  scene::Frame frame = frameOf(viewAt(sphere_, 0, 0, 8e6, 0, -90, kSize), sunOver(10, 40), thinAir(), 0.0);
  frame.tiles = synthetic::wholeBody(tiling::Tiling(tiling::Scheme::cube), sphere_, 2, 16);
  for (scene::DrawnTile& tile : frame.tiles)
    synthetic::paint(frame, tile, ground);
  frame.air.enabled = false;
  Renderer plain = makeRenderer();
  const auto expected = drawn(plain, frame);
  Renderer renderer = makeAirRenderer();
  EXPECT_EQ(drawn(renderer, frame).samples, expected.samples);
  frame.air.enabled = true;
  EXPECT_NE(drawn(renderer, frame).samples, expected.samples);
  frame.air.enabled = false;
  EXPECT_EQ(drawn(renderer, frame).samples, expected.samples) << "after a frame with air";
  frame.air.enabled = true;
  frame.light.enabled = false;
  EXPECT_EQ(drawn(renderer, frame).samples, [&] {
    frame.air.enabled = false;
    return drawn(plain, frame).samples;
  }()) << "colours as they are have no air before them";
}

// The eye's tables are kept while they are the same: whatever was drawn before, pictures are equal.
TEST_F(InAir, PicturesDoNotDependOnThoseBefore) {
  const scene::Atmosphere air = *scene::atmosphereByName("earth");
  const auto of = [&](double lon, double height_m, double pitch, double sunLon, double stops) {
    return frameOf(viewAt(sphere_, 0, lon, height_m, 80, pitch, kSize, 50), sunOver(10, sunLon), air, stops);
  };
  std::vector<scene::Frame> frames{of(0, 2e3, 10, 60, 0),  of(0, 2e3, 20, 60, 0),  of(0, 2e3, 20, 60, 1),
                                   of(0, 2e3, 20, 80, 1),  of(0, 2e4, 20, 80, 1),  of(40, 2e4, 20, 80, 1),
                                   of(40, 2e4, 20, 80, 1), of(40, 2e4, 20, 80, 1), of(40, 2e4, -5, 80, 1)};
  frames[6].air.atmosphere.groundAlbedo = {0.9, 0.9, 0.9};
  frames[7].ellipsoid = geo::earth().ellipsoid;
  scene::Frame other = of(-90, 3e5, -30, -50, 0);
  Renderer renderer = makeAirRenderer();
  Renderer makesAllAnew = makeAirRenderer();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (i == 6) other.air.atmosphere = thinAir();
    drawn(makesAllAnew, other);
    EXPECT_EQ(drawn(renderer, frames[i]).samples, drawn(makesAllAnew, frames[i]).samples) << i;
  }
}

TEST_F(InAir, ASteadyFrameAllocatesNothing) {
  Renderer renderer = makeAirRenderer();
  scene::Frame frame = frameOf(viewAt(sphere_, 0, 0, 2e6, 0, -60, kSize), sunOver(10, 40), thinAir(), 0.0);
  frame.tiles = synthetic::wholeBody(tiling::Tiling(tiling::Scheme::cube), sphere_, 1, 16);
  RenderTarget target = makeTarget(kSize);
  for (int i = 0; i < 3; ++i)
    renderer.draw(frame, target);
  startCountingAllocations();
  for (int i = 0; i < 5; ++i)
    renderer.draw(frame, target);
  EXPECT_EQ(allocationsCounted(), 0);
}

// Left to the eye, exposure makes up for the dusk, and not in space.
TEST_F(InAir, ExposureFollowsTheSunOnTheGroundOnly) {
  Renderer renderer = makeAirRenderer();
  const scene::Atmosphere air = *scene::atmosphereByName("earth");
  const auto brightness = [&](double height_m, std::optional<double> stops) {
    scene::Frame frame = frameOf(viewAt(sphere_, 0, 0, height_m, 90, 10, kSize, 60), sunOver(0, 93), air, 0.0);
    frame.air.exposure_stops = stops;
    const auto picture = drawn(renderer, frame);
    return std::accumulate(picture.samples.begin(), picture.samples.end(), 0L,
                           [](long sum, const Rgba8& p) { return sum + p.r + p.g + p.b; });
  };
  EXPECT_GT(brightness(10.0, std::nullopt), brightness(10.0, 0.0) * 3 / 2);
  EXPECT_EQ(brightness(400e3, std::nullopt), brightness(400e3, 0.0));
}

}  // namespace
}  // namespace tellurion::render
