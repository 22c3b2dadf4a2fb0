#include "render/layer_records.h"

#include <algorithm>
#include <cmath>

#include "raster/colour.h"

namespace tellurion::render {
namespace {

namespace shading {
#include "render/shaders/constants.glsl"
}  // namespace shading

using scene::BlendMode;
using scene::LayerLook;
using scene::LayerRole;

/// Looks may be changed by anyone; NaN is the lower end.
float within(double v, double low, double high) {
  return static_cast<float>(v >= low ? std::min(v, high) : low);
}

int numberOf(BlendMode mode) {
  switch (mode) {
    case BlendMode::normal:
      return shading::kNormal;
    case BlendMode::multiply:
      return shading::kMultiply;
    case BlendMode::screen:
      return shading::kScreen;
    case BlendMode::add:
      return shading::kAdd;
    case BlendMode::overlay:
      return shading::kOverlay;
  }
  return shading::kNormal;
}

float numberOf(const TexturePlace* place) {
  return place == nullptr ? -1.0f : static_cast<float>(place->number());
}

/// Nothing below it shows.
bool hides(const ResidentPicture& resident, const LayerLook& look) {
  return look.visible && look.role == LayerRole::colour && look.blend == BlendMode::normal && look.opacity >= 1.0 &&
         resident.picture->image->isOpaque;
}

float strengthSign(LayerRole role) {
  return role == LayerRole::nightLights ? 1.0f : role == LayerRole::water ? -1.0f : 0.0f;
}

PictureRecord recordOf(const ResidentPicture& resident, const LayerLook& look) {
  const float opacity = within(look.opacity, 0.0, 1.0);
  const auto adjustment = [](double v) { return within(v, 0.0, scene::kMostAdjustment); };
  const scene::TextureWindow& w = resident.picture->window;
  return {.window = resident.place != nullptr ? geo::Vec4f(w.offset.x, w.offset.y, w.scale.x, w.scale.y)
                                              : meanLight(*resident.picture->image),
          .place = numberOf(resident.place),
          .opacity = look.role == LayerRole::colour ? opacity : 0.0f,
          .strength = strengthSign(look.role) * opacity * adjustment(look.brightness),
          .blend = static_cast<float>(numberOf(look.blend)),
          .adjustment = {adjustment(look.brightness), adjustment(look.contrast), adjustment(look.saturation),
                         1.0f / within(look.gamma, scene::kLeastGamma, scene::kMostAdjustment)}};
}

}  // namespace

SunEffects effectsOn(const scene::TerrainMesh& mesh, const scene::Light& light) {
  const double middle = geo::dot(geo::Vec3(mesh.middleUp_body), light.toSun_body);
  const auto reach = static_cast<double>(mesh.upReach);
  return {.lamps = light.enabled && middle - reach < static_cast<double>(shading::kNightLightsOut),
          .mirror = light.enabled && middle + reach > static_cast<double>(shading::kSunriseBegins)};
}

TileColours coloursOf(std::span<const ResidentPicture> pictures, std::span<const LayerLook> looks, SunEffects effects,
                      std::vector<PictureRecord>& records) {
  std::size_t lowest = 0;
  for (std::size_t i = pictures.size(); i-- > 0 && lowest == 0;) {
    if (hides(pictures[i], looks[pictures[i].picture->layer])) lowest = i;
  }
  TileColours out{.first = static_cast<std::uint32_t>(records.size())};
  bool asItIs = true;  // of colours one picture is seen, unchanged
  ResidentPicture lamps;
  ResidentPicture water;
  float lampStrength = 0.0f;
  float waterStrength = 0.0f;
  std::size_t strengthCount = 0;
  const auto isSeen = [&](std::size_t i, LayerRole role) {
    return role == LayerRole::nightLights ? effects.lamps : role == LayerRole::water ? effects.mirror : i >= lowest;
  };
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const LayerLook& look = looks[pictures[i].picture->layer];
    if (!look.visible || !(look.opacity > 0.0) || !isSeen(i, look.role)) continue;
    records.push_back(recordOf(pictures[i], look));
    if (look.role != LayerRole::colour) {
      ++strengthCount;
      const bool isWater = look.role == LayerRole::water;
      (isWater ? water : lamps) = pictures[i];
      (isWater ? waterStrength : lampStrength) = std::abs(records.back().strength);
    } else {
      asItIs = asItIs && out.one.picture == nullptr && hides(pictures[i], look) && !look.adjusts();
      out.one = pictures[i];
    }
  }
  using Kind = TileColours::Kind;
  const std::size_t placed = (lamps.place != nullptr ? 1u : 0u) + (water.place != nullptr ? 1u : 0u);
  if (!asItIs || strengthCount != placed) {  // more than one of a role, or one without room
    out.kind = Kind::layered;
  } else if (lamps.place != nullptr) {
    out.kind = water.place != nullptr ? Kind::both : Kind::lamps;
    out.second = lamps;
    out.secondStrength = lampStrength;
    out.third = water;
    out.thirdStrength = waterStrength;
  } else if (water.place != nullptr) {
    out.kind = Kind::water;
    out.second = water;
    out.secondStrength = waterStrength;
  }
  out.count = static_cast<std::uint32_t>(records.size()) - out.first;
  return out;
}

}  // namespace tellurion::render
