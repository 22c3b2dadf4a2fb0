#include "render/air_tables.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "render/air_model.h"

namespace tellurion::render {
namespace {

using geo::Vec2f;
using geo::Vec3f;
using geo::Vec4f;

namespace shading {
using namespace air_shading;
using glm::abs;
using glm::clamp;
using glm::max;
using glm::sign;
using glm::smoothstep;
using glm::sqrt;
using glm::vec2;
using glm::vec3;
using std::exp;
#include "render/shaders/air_model.glsl"
}  // namespace shading

using air_shading::AirModel;

constexpr int kStepsToTop = 40;
constexpr int kGlowRows = 6;  // directions over the sphere: rows of equal area, and places on each
constexpr int kGlowColumns = 6;
constexpr int kGlowSteps = 14;
constexpr int kSkyRows = 5;  // over the half above the ground
constexpr int kSkyColumns = 6;
constexpr int kSkySteps = 12;

/// A table of colours between whose texels is read as a sampler does.
struct Table {
  const Vec4f* texels;
  int width;
  int height;

  Vec3f at(Vec2f place) const {
    const float x = std::clamp(place.x * static_cast<float>(width) - 0.5f, 0.0f, static_cast<float>(width - 1));
    const float y = std::clamp(place.y * static_cast<float>(height) - 0.5f, 0.0f, static_cast<float>(height - 1));
    const int col = std::min(static_cast<int>(x), width - 2);
    const int row = std::min(static_cast<int>(y), height - 2);
    const Vec4f* corner = texels + static_cast<std::ptrdiff_t>(row) * width + col;
    const float s = x - static_cast<float>(col);
    const float t = y - static_cast<float>(row);
    return Vec3f((corner[0] * (1.0f - s) + corner[1] * s) * (1.0f - t) +
                 (corner[width] * (1.0f - s) + corner[width + 1] * s) * t);
  }
};

Table transmittanceOf(const AirTables& tables) {
  return {tables.transmittance.data(), shading::kTransmittanceWidth, shading::kTransmittanceHeight};
}
Table glowOf(const AirTables& tables) {
  return {tables.glow.data(), shading::kGlowSide, shading::kGlowSide};
}

/// The share of a table's side where its texel lies: the inverse of inTexels().
float shareOfTexel(int texel, int texels) {
  return static_cast<float>(texel) / static_cast<float>(texels - 1);
}

/// The inverse of sunPlace().
float sunCosineAt(float place) {
  const float from = 2.0f * place - 1.0f;
  return from * std::abs(from);
}

/// A straight way from a height, at an angle of this cosine from the zenith.
struct Way {
  const AirModel& air;
  float from;    // radius at its begin
  float cosine;  // there

  double radiusAt(double t) const {
    const double r = static_cast<double>(from);
    return std::sqrt(r * r + t * t + 2.0 * r * t * static_cast<double>(cosine));
  }
  float heightAt(double t) const { return static_cast<float>(radiusAt(t) - static_cast<double>(air.sphere.x)); }

  /// Metres to the bottom, or else to the top of the air.
  double length(bool* meetsBottom = nullptr) const {
    const double r = static_cast<double>(from);
    const double mu = static_cast<double>(cosine);
    const auto squareTo = [&](float height) {
      const double to = static_cast<double>(air.sphere.x) + static_cast<double>(height);
      return to * to - r * r * (1.0 - mu * mu);
    };
    const double bottom = squareTo(air.sphere.y);
    const bool meets = mu < 0.0 && bottom >= 0.0;
    if (meetsBottom != nullptr) *meetsBottom = meets;
    if (meets) return std::max(-r * mu - std::sqrt(bottom), 0.0);
    return std::max(-r * mu + std::sqrt(std::max(squareTo(air.sphere.z), 0.0)), 0.0);
  }
};

/// Calls back with the mean densities, the middle and the length of each of `steps` parts of a way.
template <class Part>
void walk(const Way& way, double length, int steps, Part part) {
  float height = way.heightAt(0.0);
  Vec3f densities = shading::densitiesAt(way.air, height);
  for (int i = 0; i < steps; ++i) {
    const double begin = length * i / steps;
    const double end = length * (i + 1) / steps;
    const float nextHeight = way.heightAt(end);
    const Vec3f next = shading::densitiesAt(way.air, nextHeight);
    part(shading::meanDensities(way.air, densities, next, nextHeight - height), 0.5 * (begin + end),
         static_cast<float>(end - begin));
    height = nextHeight;
    densities = next;
  }
}

Vec3f expOf(const Vec3f& v) {
  return glm::exp(v);
}

/// The integral of exp(-lost t) over t in 0..1.
Vec3f meanKept(const Vec3f& lost) {
  Vec3f out;
  for (int i = 0; i < 3; ++i)
    out[i] = lost[i] < 0.01f ? 1.0f - 0.5f * lost[i] : (1.0f - std::exp(-lost[i])) / lost[i];
  return out;
}

void fillTransmittance(const AirModel& air, std::vector<Vec4f>& table) {
  const double bottom = static_cast<double>(air.sphere.x) + static_cast<double>(air.sphere.y);
  const double depth = static_cast<double>(air.sphere.z) - static_cast<double>(air.sphere.y);
  const double widest = std::sqrt(depth * (2.0 * bottom + depth));
  for (int row = 0; row < shading::kTransmittanceHeight; ++row) {
    const double toHorizon = widest * static_cast<double>(shareOfTexel(row, shading::kTransmittanceHeight));
    const double r = std::sqrt(toHorizon * toHorizon + bottom * bottom);
    const double least = bottom + depth - r;
    for (int col = 0; col < shading::kTransmittanceWidth; ++col) {
      const double share = static_cast<double>(shareOfTexel(col, shading::kTransmittanceWidth));
      const double length = least + share * (toHorizon + widest - least);
      const double cosine =
          length > 0.0 ? (widest * widest - toHorizon * toHorizon - length * length) / (2.0 * r * length) : 1.0;
      Vec3f lost(0.0f);
      const Way way{air, static_cast<float>(r), static_cast<float>(std::clamp(cosine, -1.0, 1.0))};
      walk(way, length, kStepsToTop,
           [&](const Vec3f& densities, double, float part) { lost += shading::extinction(air, densities) * part; });
      table.emplace_back(expOf(-lost), 1.0f);
    }
  }
}

/// Sun and air about a place: how much light comes along a way to it.
struct Incoming {
  Vec3f light{0.0f};   // single scattering, with the ground's share of it where the way ends there
  Vec3f spread{0.0f};  // what comes of air that glows with 1 on all sides
};

/// As if all matter scattered evenly to all sides.
Incoming alongForGlow(const AirModel& air, const Table& transmittance, const Vec3f& groundAlbedo, float height,
                      float upwards, float sunUp, float sunAlong) {
  const Way way{air, air.sphere.x + height, upwards};
  bool meets = false;
  const double length = way.length(&meets);
  Incoming in;
  Vec3f reaches(1.0f);
  const auto sunAt = [&](double t) {
    const double r = way.radiusAt(t);
    return static_cast<float>((static_cast<double>(way.from * sunUp) + t * static_cast<double>(sunAlong)) / r);
  };
  const auto sunlight = [&](float at, float sun) {
    return transmittance.at(shading::transmittancePlace(air, at, sun)) * shading::sunVisible(air, at, sun);
  };
  walk(way, length, kGlowSteps, [&](const Vec3f& densities, double middle, float part) {
    const Vec3f scatters = shading::bands(air.gas) * densities.x + shading::bands(air.aerosolScattering) * densities.y;
    const Vec3f lost = shading::extinction(air, densities) * part;
    const Vec3f share = reaches * scatters * meanKept(lost) * part;
    const float at = way.heightAt(middle);
    in.light += share * sunlight(at, std::clamp(sunAt(middle), -1.0f, 1.0f)) * 0.25f;  // pi / (4 pi)
    in.spread += share;
    reaches *= expOf(-lost);
  });
  if (!meets) return in;
  const float sun = std::clamp(sunAt(length), -1.0f, 1.0f);
  in.light += reaches * groundAlbedo * sunlight(air.sphere.y, sun) * std::max(sun, 0.0f);
  return in;
}

void fillGlow(const AirModel& air, const Table& transmittance, const Vec3f& groundAlbedo, std::vector<Vec4f>& table) {
  for (int row = 0; row < shading::kGlowSide; ++row) {
    const float root = shareOfTexel(row, shading::kGlowSide);
    const float height = air.sphere.y + root * root * (air.sphere.z - air.sphere.y);
    for (int col = 0; col < shading::kGlowSide; ++col) {
      const float sunUp = sunCosineAt(shareOfTexel(col, shading::kGlowSide));
      const float sunSide = std::sqrt(std::max(1.0f - sunUp * sunUp, 0.0f));
      Incoming mean;
      for (int i = 0; i < kGlowRows; ++i) {
        const float up = 2.0f * (static_cast<float>(i) + 0.5f) / kGlowRows - 1.0f;
        const float sideways = std::sqrt(1.0f - up * up);
        for (int k = 0; k < kGlowColumns; ++k) {  // the other half is its mirror image
          const float azimuth = shading::kPi * (static_cast<float>(k) + 0.5f) / kGlowColumns;
          const float sunAlong = up * sunUp + sideways * std::cos(azimuth) * sunSide;
          const Incoming in = alongForGlow(air, transmittance, groundAlbedo, height, up, sunUp, sunAlong);
          mean.light += in.light;
          mean.spread += in.spread;
        }
      }
      mean.light /= static_cast<float>(kGlowRows * kGlowColumns);
      mean.spread /= static_cast<float>(kGlowRows * kGlowColumns);
      table.emplace_back(mean.light / (1.0f - glm::min(mean.spread, Vec3f(0.95f))), 1.0f);
    }
  }
}

/// What the sky sends down along a way to the ground.
Vec3f skyAlong(const AirModel& air, const AirTables& tables, float height, float upwards, float sunUp, float sunAlong) {
  const Way way{air, air.sphere.x + height, upwards};
  const Table transmittance = transmittanceOf(tables);
  const Table glow = glowOf(tables);
  Vec3f light(0.0f);
  Vec3f reaches(1.0f);
  walk(way, way.length(), kSkySteps, [&](const Vec3f& densities, double middle, float part) {
    const float at = way.heightAt(middle);
    const auto r = static_cast<float>(way.radiusAt(middle));
    const float sun = std::clamp((way.from * sunUp + static_cast<float>(middle) * sunAlong) / r, -1.0f, 1.0f);
    const Vec3f sunlight =
        transmittance.at(shading::transmittancePlace(air, at, sun)) * shading::sunVisible(air, at, sun);
    const Vec3f lost = shading::extinction(air, densities) * part;
    light += reaches * meanKept(lost) * part *
             shading::scattered(air, densities, sunAlong, sunlight, glow.at(shading::glowPlace(air, at, sun)));
    reaches *= expOf(-lost);
  });
  return light;
}

/// Light of the whole sky on level ground, over pi.
Vec3f skyLight(const AirModel& air, const AirTables& tables, float height, float sunUp) {
  const float sunSide = std::sqrt(std::max(1.0f - sunUp * sunUp, 0.0f));
  Vec3f sum(0.0f);
  for (int i = 0; i < kSkyRows; ++i) {
    const float up = std::sqrt((static_cast<float>(i) + 0.5f) / kSkyRows);  // rows of equal share
    const float sideways = std::sqrt(1.0f - up * up);
    for (int k = 0; k < kSkyColumns; ++k) {
      const float azimuth = shading::kPi * (static_cast<float>(k) + 0.5f) / kSkyColumns;
      sum += skyAlong(air, tables, height, up, sunUp, up * sunUp + sideways * std::cos(azimuth) * sunSide);
    }
  }
  return sum / static_cast<float>(kSkyRows * kSkyColumns);
}

float groundHeightOfRow(const AirModel& air, int row) {
  return air.sphere.y +
         shareOfTexel(row, shading::kGroundLightHeight) * shading::kGroundLightReach * (air.sphere.z - air.sphere.y);
}

void fillGroundLight(const AirModel& air, AirTables& tables) {
  const Table transmittance = transmittanceOf(tables);
  std::vector<Vec4f> sky;
  for (int row = 0; row < shading::kGroundLightHeight; ++row) {
    const float height = groundHeightOfRow(air, row);
    for (int col = 0; col < shading::kGroundLightWidth; ++col) {
      const float sun = sunCosineAt(shareOfTexel(col, shading::kGroundLightWidth));
      const Vec3f direct = transmittance.at(shading::transmittancePlace(air, height, sun));
      tables.groundLight.emplace_back(direct * shading::sunVisible(air, height, sun), 1.0f);
      sky.emplace_back(skyLight(air, tables, height, sun), 1.0f);
    }
  }
  tables.groundLight.insert(tables.groundLight.end(), sky.begin(), sky.end());
}

}  // namespace

AirTables makeAirTables(const scene::Atmosphere& atmosphere, double radius_m) {
  const AirModel air = airModelOf(atmosphere, radius_m);
  AirTables tables;
  fillTransmittance(air, tables.transmittance);
  fillGlow(air, transmittanceOf(tables), bandsOf(atmosphere.groundAlbedo), tables.glow);
  fillGroundLight(air, tables);
  return tables;
}

double groundLightAt(const AirTables& tables, const scene::Atmosphere& atmosphere, double radius_m, double height_m,
                     double sunCosine) {
  const auto sun = static_cast<float>(sunCosine);
  const Vec2f place = shading::groundLightPlace(airModelOf(atmosphere, radius_m), static_cast<float>(height_m), sun);
  const Table direct{tables.groundLight.data(), shading::kGroundLightWidth, shading::kGroundLightHeight};
  const Table sky{tables.groundLight.data() + shading::kGroundLightWidth * shading::kGroundLightHeight, direct.width,
                  direct.height};
  const Vec3f light = direct.at(place) * std::max(sun, 0.0f) + sky.at(place);
  return static_cast<double>(geo::dot(light, Vec3f(0.2126f, 0.7152f, 0.0722f)));
}

}  // namespace tellurion::render
