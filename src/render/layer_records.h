#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/texture_pool.h"
#include "scene/frame.h"

namespace tellurion::render {

/// A picture as terrain_layers.frag.glsl reads it: three texels of a buffer, the last only where colours are adjusted.
struct PictureRecord {
  geo::Vec4f window;      ///< offset, scale; of a picture without room its mean light and coverage
  float place = -1.0f;    ///< TexturePlace::number(); -1: without room
  float opacity = 0.0f;   ///< of its colours
  float strength = 0.0f;  ///< of its night lights; of water, less than 0
  float blend = 0.0f;     ///< number of the blend mode, as shaders/constants.glsl has it
  geo::Vec4f adjustment;  ///< brightness, contrast, saturation, 1 / gamma
};
static_assert(sizeof(PictureRecord) == 48);

/// A drawn picture and where it lies; without room: null.
struct ResidentPicture {
  const scene::DrawnPicture* picture = nullptr;
  const TexturePlace* place = nullptr;
};

/// What draws a tile's colours.
struct TileColours {
  enum class Kind : std::uint8_t {
    one,      ///< one opaque picture as it is, or none; may be drawn as `layered` too
    lamps,    ///< that, and one of night lights; likewise
    water,    ///< or of water
    both,     ///< or one of each
    layered,  ///< what the range of records says
  };
  Kind kind = Kind::one;
  ResidentPicture one;
  ResidentPicture second;       ///< of `lamps`, `water` and, the lamps, `both`; not without room
  float secondStrength = 0.0f;  ///< of that, 0 or more
  ResidentPicture third;        ///< the water of `both`, likewise
  float thirdStrength = 0.0f;
  std::uint32_t first = 0;  ///< of the range, which has all pictures
  std::uint32_t count = 0;
};

/// What the sun lets be seen on some of a mesh's ground.
struct SunEffects {
  bool lamps = false;   ///< night lights burn
  bool mirror = false;  ///< water shows the sun
};
SunEffects effectsOn(const scene::TerrainMesh& mesh, const scene::Light& light);

/// Appends a record for each picture of a tile that can be seen: layers that are not visible are left out, and what
/// lies below one that hides it, and night lights by day and water by night. Pictures bottom first; looks, by their
/// layer.
TileColours coloursOf(std::span<const ResidentPicture> pictures, std::span<const scene::LayerLook> looks,
                      SunEffects effects, std::vector<PictureRecord>& records);

}  // namespace tellurion::render
