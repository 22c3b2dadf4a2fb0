#include "scene/colour_layers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <tuple>
#include <utility>

#include "raster/colour.h"
#include "scene/texture_image.h"

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

/// The part of a layer's own data set that lies over a tile.
struct Part {
  LayerTiles::TilePointer tile;
  int level = -1;        ///< of `tile`
  int nativeLevel = -1;  ///< the deepest of the data set
};

/// What a root shows until its tile is here.
Part standInOf(const ColourLayers::Layer& layer, LayerTiles& set, const tiling::TileId& id) {
  Part part{.level = set.storedLevel(id), .nativeLevel = set.info().maxLevel};
  if (part.level < 0) return part;
  part.tile = set.tellsPresence() ? set.kept(id) : set.held(id);
  const auto overview = std::ranges::find(layer.overviews, &set, &ColourLayers::Layer::Overview::of);
  if (!part.tile && overview != layer.overviews.end()) part.tile = overview->tiles->get(id);
  return part;
}

/// The nearest tile over `id` that can be had.
Part nearestPart(LayerTiles& set, const tiling::TileId& id) {
  Part part{.level = set.storedLevel(id), .nativeLevel = set.info().maxLevel};
  for (; part.level >= 0; --part.level) {
    part.tile = set.held(id.ancestor(part.level));
    if (part.tile) break;
  }
  return part;
}

/// Coarser pixels show where the finer ones above them are not covered.
void layUnder(Picture& finer, const Picture& coarser) {
  for (std::size_t i = 0; i < finer.samples.size(); ++i) {
    if (finer.samples[i].a != 255) finer.samples[i] = raster::over(finer.samples[i], coarser.samples[i]);
  }
}

bool isCovered(const Picture& picture) {
  return std::ranges::all_of(picture.samples, [](Rgba8 p) { return p.a == 255; });
}

/// `parts` have a tile each.
Picture composed(std::vector<Part> parts, const tiling::TileId& id) {
  std::ranges::reverse(parts);  // of equals the later comes first
  std::ranges::stable_sort(parts, std::greater(), [](const Part& p) { return std::tuple(p.level, p.nativeLevel); });
  Picture out = pixelsOf(*parts.front().tile);
  for (std::size_t i = 1; i < parts.size() && !isCovered(out); ++i) {
    const Picture& pixels = pixelsOf(*parts[i].tile);
    layUnder(out, parts[i].level < id.level ? enlarged(pixels, parts[i].level, id) : pixels);
  }
  return out;
}

/// Strength of lights, or the share of water, in 0..255, linear, from the relative luminance of their colour.
Rgba8 strengthOf(Rgba8 p) {
  const double luminance = 0.2126 * raster::linearFromSrgb(p.r) + 0.7152 * raster::linearFromSrgb(p.g) +
                           0.0722 * raster::linearFromSrgb(p.b);
  return {0, 0, 0, static_cast<std::uint8_t>(std::lround(luminance * p.a / 65535.0))};
}

template <class PartOf>
LayerPicture pictureOf(const ColourLayers::Layer& layer, bool compress, const tiling::TileId& id,
                       const LayerPicture* parent, const PartOf& partOf) {
  LayerPicture out;
  const CurrentStep::Now now = layer.step ? layer.step->now() : CurrentStep::Now{};
  if (parent != nullptr) out = {.image = parent->image, .level = parent->level, .edition = parent->edition};
  if (id.level == 0) out = {.edition = now.edition};
  const auto isOwnOf = [&](LayerTiles& set) { return set.storedLevel(id) == id.level; };
  const bool mayBeOwn = std::ranges::any_of(layer.sets, [&](const auto& set) { return isOwnOf(*set); }) ||
                        (now.tiles && isOwnOf(*now.tiles));
  if (!mayBeOwn) return out;  // what is not looked at is not loaded
  std::vector<Part> parts;
  const auto look = [&](LayerTiles& set) {
    Part part = partOf(set, id);
    if (!part.tile) return;
    out.isOwn = out.isOwn || part.level == id.level;
    out.finerBelow = out.finerBelow || (part.level == id.level && part.tile->childMask != 0);
    parts.push_back(std::move(part));
  };
  for (const auto& set : layer.sets)
    look(*set);
  if (now.tiles) look(*now.tiles);
  if (!out.isOwn) return out;
  Picture picture = composed(std::move(parts), id);
  if (layer.isStrength) std::ranges::transform(picture.samples, picture.samples.begin(), strengthOf);
  const bool isEmpty = std::ranges::all_of(picture.samples, [](Rgba8 p) { return p.a == 0; });
  out.image = isEmpty ? nullptr : textureFrom(std::move(picture), compress);
  out.level = id.level;
  out.edition = now.edition;
  return out;
}

void addNeedsOf(const ColourLayers::Layer& layer, const tiling::TileId& id, std::vector<TileNeed>& needs) {
  const std::size_t before = needs.size();
  bool mayBeOwn = false;
  const auto look = [&](LayerTiles& set) {
    if (!set.tellsPresence()) {
      mayBeOwn = mayBeOwn || id.level <= set.info().maxLevel;
      return;
    }
    const int level = set.storedLevel(id);
    mayBeOwn = mayBeOwn || level == id.level;
    addNeed(set, id, level, needs);
    if (id.level == 0 && level == 0) needs.back().mayStandIn = true;
  };
  for (const auto& set : layer.sets)
    look(*set);
  if (layer.step) {
    if (const auto tiles = layer.step->now().tiles) look(*tiles);
  }
  if (!mayBeOwn) needs.resize(before);
}

}  // namespace

std::vector<LayerPicture> ColourLayers::pictures(const tiling::TileId& id, std::span<const LayerPicture> parent) const {
  std::vector<LayerPicture> out;
  out.reserve(layers_.size());
  for (std::size_t i = 0; i < layers_.size(); ++i)
    out.push_back(pictureOf(layers_[i], compress_, id, i < parent.size() ? &parent[i] : nullptr, nearestPart));
  return out;
}

std::vector<LayerPicture> ColourLayers::standIns(const tiling::TileId& id) const {
  std::vector<LayerPicture> out;
  for (const Layer& layer : layers_)
    out.push_back(pictureOf(layer, compress_, id, nullptr, [&layer](LayerTiles& set, const tiling::TileId& root) {
      return standInOf(layer, set, root);
    }));
  return out;
}

bool ColourLayers::isBare() const {
  return std::ranges::none_of(
      layers_, [](const Layer& layer) { return !layer.sets.empty() || (layer.step && layer.step->now().tiles); });
}

void ColourLayers::addNeeds(const tiling::TileId& id, std::vector<TileNeed>& needs) const {
  for (const Layer& layer : layers_)
    addNeedsOf(layer, id, needs);
}

bool ColourLayers::followsClock() const {
  return std::ranges::any_of(layers_, [](const Layer& layer) { return layer.step != nullptr; });
}

std::vector<std::uint64_t> ColourLayers::editions() const {
  std::vector<std::uint64_t> out;
  for (const Layer& layer : layers_)
    out.push_back(layer.step ? layer.step->now().edition : 0);
  return out;
}

bool ColourLayers::areUpToDate(std::span<const LayerPicture> pictures) const {
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (layers_[i].step && pictures[i].edition != layers_[i].step->now().edition) return false;
  }
  return true;
}

std::vector<LayerPicture> ColourLayers::renewed(const tiling::TileId& id, std::span<const LayerPicture> pictures,
                                                std::span<const LayerPicture> over) const {
  std::vector<LayerPicture> out(pictures.begin(), pictures.end());
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (layers_[i].step && out[i].edition != layers_[i].step->now().edition)
      out[i] = pictureOf(layers_[i], compress_, id, &over[i], nearestPart);
  }
  return out;
}

void ColourLayers::addNeedsOfSteps(const tiling::TileId& id, std::vector<TileNeed>& needs) const {
  for (const Layer& layer : layers_) {
    if (layer.step) addNeedsOf(layer, id, needs);
  }
}

int ColourLayers::levelOfSteps(std::span<const LayerPicture> pictures) const {
  int level = -1;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (layers_[i].step) level = std::max(level, pictures[i].level);
  }
  return level;
}

}  // namespace tellurion::scene
