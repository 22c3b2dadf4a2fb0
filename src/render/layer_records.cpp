#include "render/layer_records.h"

#include <algorithm>

#include "raster/colour.h"

namespace tellurion::render {
namespace {

namespace shading {
#include "render/shaders/constants.glsl"
}  // namespace shading

using scene::BlendMode;
using scene::LayerLook;

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
  return look.visible && !look.nightLights && look.blend == BlendMode::normal && look.opacity >= 1.0 &&
         resident.picture->image->isOpaque;
}

PictureRecord recordOf(const ResidentPicture& resident, const LayerLook& look) {
  const float opacity = within(look.opacity, 0.0, 1.0);
  const auto adjustment = [](double v) { return within(v, 0.0, scene::kMostAdjustment); };
  const scene::TextureWindow& w = resident.picture->window;
  return {.window = resident.place != nullptr ? geo::Vec4f(w.offset.x, w.offset.y, w.scale.x, w.scale.y)
                                              : meanLight(*resident.picture->image),
          .place = numberOf(resident.place),
          .opacity = look.nightLights ? 0.0f : opacity,
          .lamps = look.nightLights ? opacity * adjustment(look.brightness) : 0.0f,
          .blend = static_cast<float>(numberOf(look.blend)),
          .adjustment = {adjustment(look.brightness), adjustment(look.contrast), adjustment(look.saturation),
                         1.0f / within(look.gamma, scene::kLeastGamma, scene::kMostAdjustment)}};
}

}  // namespace

bool lampsMayBurn(const scene::TerrainMesh& mesh, const scene::Light& light) {
  const double middle = geo::dot(geo::Vec3(mesh.middleUp_body), light.toSun_body);
  return light.enabled && middle - static_cast<double>(mesh.upReach) < static_cast<double>(shading::kNightLightsOut);
}

TileColours coloursOf(std::span<const ResidentPicture> pictures, std::span<const LayerLook> looks, bool lampsBurn,
                      std::vector<PictureRecord>& records) {
  std::size_t lowest = 0;
  for (std::size_t i = pictures.size(); i-- > 0 && lowest == 0;) {
    if (hides(pictures[i], looks[pictures[i].picture->layer])) lowest = i;
  }
  TileColours out{.first = static_cast<std::uint32_t>(records.size())};
  bool asItIs = true;  // of colours one picture is seen, unchanged
  std::size_t lampCount = 0;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const LayerLook& look = looks[pictures[i].picture->layer];
    if (!look.visible || !(look.opacity > 0.0) || (look.nightLights ? !lampsBurn : i < lowest)) continue;
    records.push_back(recordOf(pictures[i], look));
    if (look.nightLights) {
      ++lampCount;
      out.lamps = pictures[i];
      out.lampStrength = records.back().lamps;
    } else {
      asItIs = asItIs && out.one.picture == nullptr && hides(pictures[i], look) && !look.adjusts();
      out.one = pictures[i];
    }
  }
  if (!asItIs || lampCount > 1) {
    out.kind = TileColours::Kind::layered;
  } else if (lampCount == 1) {
    out.kind = out.lamps.place != nullptr ? TileColours::Kind::night : TileColours::Kind::layered;
  }
  out.count = static_cast<std::uint32_t>(records.size()) - out.first;
  return out;
}

}  // namespace tellurion::render
