#include "pyramid/colour_query.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pyramid/query_tiles.h"
#include "raster/colour.h"

namespace tellurion::pyramid {
namespace {

using raster::Rgba8;

Rgba8 nearest(const raster::Raster<Rgba8>& pixels, const TilePlace& place) {
  const int size = pixels.width - 2 * raster::kGutter;
  const auto pixelOf = [size](double at) {
    return std::clamp(static_cast<int>(at * size), 0, size - 1) + raster::kGutter;
  };
  return pixels.at(pixelOf(place.s), pixelOf(place.t));
}

/// Between the centres of the four pixels around a place, those of the gutter among them.
Rgba8 bilinear(const raster::Raster<Rgba8>& pixels, const TilePlace& place) {
  const int size = pixels.width - 2 * raster::kGutter;
  const auto fromFirstCentre = [size](double at) {
    return std::clamp(at * size + raster::kGutter - 0.5, 0.0, static_cast<double>(size + 1));
  };
  const double x = fromFirstCentre(place.s);
  const double y = fromFirstCentre(place.t);
  const int column = std::min(static_cast<int>(x), size);
  const int row = std::min(static_cast<int>(y), size);
  std::array<double, 3> light{};
  double coverage = 0.0;
  for (int i = 0; i < 4; ++i) {
    const bool isRight = (i & 1) != 0;
    const bool isBelow = (i & 2) != 0;
    const Rgba8 pixel = pixels.at(column + (isRight ? 1 : 0), row + (isBelow ? 1 : 0));
    const double weight = (isRight ? x - column : column + 1 - x) * (isBelow ? y - row : row + 1 - y) * pixel.a;
    coverage += weight;
    light[0] += weight * raster::linearFromSrgb(pixel.r);
    light[1] += weight * raster::linearFromSrgb(pixel.g);
    light[2] += weight * raster::linearFromSrgb(pixel.b);
  }
  const auto alpha = static_cast<std::uint8_t>(std::lround(coverage));
  if (alpha == 0) return {};
  const auto byte = [&](double sum) {
    return raster::srgbFromLinear(static_cast<std::uint16_t>(std::lround(sum / coverage)));
  };
  return {byte(light[0]), byte(light[1]), byte(light[2]), alpha};
}

}  // namespace

struct ColourQuery::State {
  QueryTiles tiles;

  std::optional<ColourAnswer> answer(const tiling::RootPoint& p, const QueryTile* tile,
                                     const ColourQuestion& question) const {
    if (tile == nullptr) return std::nullopt;
    const TilePlace place = placeIn(tile->id, p);
    const bool isNearest = question.sampling == Sampling::nearest;
    const Rgba8 colour = isNearest ? nearest(tile->pixels, place) : bilinear(tile->pixels, place);
    if (colour.a == 0) return std::nullopt;
    return ColourAnswer{.colour = colour,
                        .level = tile->id.level,
                        .spacing_m = tiles.spacing_m(tile->id.level),
                        .hasFiner = tile->hasFiner(p)};
  }

  auto answering(const ColourQuestion& question) const {
    return [this, &question](const tiling::RootPoint& p, const QueryTile* tile) { return answer(p, tile, question); };
  }
};

ColourQuery::ColourQuery(std::unique_ptr<State> state) : state_(std::move(state)) {}
ColourQuery::~ColourQuery() = default;
ColourQuery::ColourQuery(ColourQuery&&) noexcept = default;
ColourQuery& ColourQuery::operator=(ColourQuery&&) noexcept = default;

io::Result<ColourQuery> ColourQuery::create(std::shared_ptr<const raster::TileSource> source,
                                            std::uint64_t cacheBytes) {
  if (source->info().kind != raster::Kind::imagery) {
    return io::fail(io::Failure::Code::invalidArgument, "holds elevation; colours are asked of a database of imagery",
                    source->info().name);
  }
  return ColourQuery(std::make_unique<State>(State{.tiles = QueryTiles(std::move(source), cacheBytes)}));
}

io::Result<std::optional<ColourAnswer>> ColourQuery::at(const geo::Direction& place,
                                                        const ColourQuestion& question) const {
  return state_->tiles.ask<ColourAnswer>(place, question.level.value_or(tiling::kMaxLevel),
                                         state_->answering(question));
}

io::Result<void> ColourQuery::at(std::span<const geo::Direction> places, std::span<std::optional<ColourAnswer>> answers,
                                 const ColourQuestion& question) const {
  return state_->tiles.ask(places, answers, question.level.value_or(tiling::kMaxLevel), state_->answering(question));
}

}  // namespace tellurion::pyramid
