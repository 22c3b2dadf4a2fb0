#include "scene/colour_layers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "raster/colour.h"
#include "raster/reduce.h"
#include "scene/terrain_mesh.h"

namespace tellurion::scene {
namespace {

using raster::Rgba8;
using Picture = raster::Raster<Rgba8>;

const Picture& pixelsOf(const raster::SourceTile& tile) {
  return std::get<raster::ImageryTile>(tile.payload).pixels;
}

/// Colour at a place between pixel centres, bilinear in linear light, weighted with coverage.
Rgba8 between(const Picture& from, double col, double row) {
  const int c = std::clamp(static_cast<int>(std::floor(col)), 0, from.width - 2);
  const int r = std::clamp(static_cast<int>(std::floor(row)), 0, from.height - 2);
  const double right = std::clamp(col - c, 0.0, 1.0);
  const double below = std::clamp(row - r, 0.0, 1.0);
  std::array<double, 4> sum{};
  const auto add = [&](int dc, int dr) {
    const Rgba8 p = from.at(c + dc, r + dr);
    const double weight = (dc != 0 ? right : 1.0 - right) * (dr != 0 ? below : 1.0 - below) * p.a;
    sum[0] += weight * raster::linearFromSrgb(p.r);
    sum[1] += weight * raster::linearFromSrgb(p.g);
    sum[2] += weight * raster::linearFromSrgb(p.b);
    sum[3] += weight;
  };
  add(0, 0);
  add(1, 0);
  add(0, 1);
  add(1, 1);
  if (sum[3] <= 0.0) return {};
  const auto byte = [&](double v) { return raster::srgbFromLinear(static_cast<std::uint16_t>(v / sum[3] + 0.5)); };
  return {byte(sum[0]), byte(sum[1]), byte(sum[2]), static_cast<std::uint8_t>(sum[3] + 0.5)};
}

/// The part of an ancestor's picture that a tile covers, at the tile's own size, gutter included.
Picture enlarged(const Picture& from, int fromLevel, const tiling::TileId& id) {
  Picture out(from.width, from.height);
  const int size = from.width - 2 * raster::kGutter;
  const double scale = tiling::tileSize(id.level - fromLevel);
  const auto source = [&](std::uint32_t index, int i) {
    const std::uint32_t within = index & ((1u << (id.level - fromLevel)) - 1u);
    return (static_cast<double>(within) * size + i - 0.5) * scale + 0.5;
  };
  for (int row = 0; row < out.height; ++row) {
    for (int col = 0; col < out.width; ++col)
      out.at(col, row) = between(from, source(id.x, col), source(id.y, row));
  }
  return out;
}

/// Strength of a light in 0..255, linear, from the relative luminance of its colour.
std::uint8_t strengthOf(Rgba8 p, double opacity) {
  const double luminance = 0.2126 * raster::linearFromSrgb(p.r) + 0.7152 * raster::linearFromSrgb(p.g) +
                           0.0722 * raster::linearFromSrgb(p.b);
  return static_cast<std::uint8_t>(std::lround(luminance * p.a / 65535.0 * opacity));
}

void layOver(Picture& ground, const Picture& layer, double opacity) {
  for (std::size_t i = 0; i < ground.samples.size(); ++i) {
    Rgba8 top = layer.samples[i];
    top.a = static_cast<std::uint8_t>(std::lround(top.a * opacity));
    const std::uint8_t lights = ground.samples[i].a;
    if (top.a == 255) {
      ground.samples[i] = top;
    } else if (top.a != 0) {
      Rgba8 bottom = ground.samples[i];
      bottom.a = 255;
      ground.samples[i] = raster::over(top, bottom);
    }
    ground.samples[i].a = lights;
  }
}

void addLights(Picture& ground, const Picture& layer, double opacity) {
  for (std::size_t i = 0; i < ground.samples.size(); ++i) {
    const std::uint8_t strength = strengthOf(layer.samples[i], opacity);
    ground.samples[i].a = std::max(ground.samples[i].a, strength);
  }
}

std::uint8_t meanOfFour(const Picture& p, int col, int row) {
  const int right = std::min(col + 1, p.width - 1);
  const int below = std::min(row + 1, p.height - 1);
  return static_cast<std::uint8_t>(
      (p.at(col, row).a + p.at(right, row).a + p.at(col, below).a + p.at(right, below).a + 2) / 4);
}

Picture reduced(const Picture& finer, Picture opaqueFiner) {
  Picture out = raster::halved(opaqueFiner);
  for (int row = 0; row < out.height; ++row) {
    for (int col = 0; col < out.width; ++col)
      out.at(col, row).a = meanOfFour(finer, 2 * col, 2 * row);
  }
  return out;
}

}  // namespace

std::shared_ptr<const TextureImage> textureFrom(Picture finest) {
  auto image = std::make_shared<TextureImage>();
  image->serial = nextSerial();
  image->mips.push_back(std::move(finest));
  while (image->mips.back().width > 1 || image->mips.back().height > 1) {
    Picture opaque = image->mips.back();
    for (Rgba8& p : opaque.samples)
      p.a = 255;
    image->mips.push_back(reduced(image->mips.back(), std::move(opaque)));
  }
  return image;
}

ComposedColour ColourLayers::compose(const tiling::TileId& id) const {
  struct Part {
    LayerTiles::TilePointer tile;
    int level = -1;
  };
  ComposedColour out;
  std::vector<Part> parts;
  bool own = id.level == 0 && !layers_.empty();
  for (const Layer& layer : layers_) {
    Part part{.level = layer.tiles ? layer.tiles->storedLevel(id) : -1};
    own = own || part.level == id.level;
    parts.push_back(part);
  }
  if (!own) return out;
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    Part& part = parts[i];
    for (; part.level >= 0 && !part.tile; part.level -= part.tile ? 0 : 1)
      part.tile = layers_[i].tiles->get(id.ancestor(part.level));
    out.finerBelow = out.finerBelow || (part.tile && part.level == id.level && part.tile->childMask != 0);
  }
  Rgba8 plain = kPlainGround;
  plain.a = 0;
  Picture ground(pixels_ + 2 * raster::kGutter, pixels_ + 2 * raster::kGutter, plain);
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    const Part& part = parts[i];
    if (!part.tile) continue;
    const Picture& pixels = pixelsOf(*part.tile);
    const Picture larger = part.level < id.level ? enlarged(pixels, part.level, id) : Picture();
    const Picture& layer = part.level < id.level ? larger : pixels;
    if (layers_[i].nightLights) {
      addLights(ground, layer, layers_[i].opacity);
    } else {
      layOver(ground, layer, layers_[i].opacity);
    }
  }
  out.image = textureFrom(std::move(ground));
  return out;
}

void ColourLayers::addNeeds(const tiling::TileId& id, std::vector<TileNeed>& needs) const {
  const std::size_t before = needs.size();
  bool mayBeOwn = id.level == 0;
  for (const Layer& layer : layers_) {
    if (!layer.tiles) continue;
    if (!layer.tiles->tellsPresence()) {
      mayBeOwn = mayBeOwn || id.level <= layer.tiles->info().maxLevel;
      continue;
    }
    const int level = layer.tiles->storedLevel(id);
    mayBeOwn = mayBeOwn || level == id.level;
    addNeed(*layer.tiles, id, level, needs);
  }
  if (!mayBeOwn) needs.resize(before);
}

}  // namespace tellurion::scene
