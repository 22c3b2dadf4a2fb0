#include "raster/sampling.h"

#include <array>
#include <cmath>

#include "raster/bilinear_pixels.h"

namespace tellurion::raster {
namespace {

/// Half of a square, less the rounding of places on the very edge of the data.
constexpr double kHalf = 0.5 - 1e-6;

/// Mean over those of the four that have data.
float meanOfKnown(const std::array<float, 4>& v, const std::array<double, 4>& weights) {
  double sum = 0.0;
  double weight = 0.0;
  for (std::size_t i = 0; i < v.size(); ++i) {
    if (isNoData(v[i])) continue;
    sum += weights[i] * static_cast<double>(v[i]);
    weight += weights[i];
  }
  return static_cast<float>(sum / weight);
}

/// Light of several pixels, weighted with area and coverage.
struct Light {
  ColourTables tables;
  double r = 0.0, g = 0.0, b = 0.0;
  double coverage = 0.0;  ///< sum of weight * alpha

  void add(const Rgba8& p, double weight) {
    const double w = weight * p.a;
    r += w * tables.linear[p.r];
    g += w * tables.linear[p.g];
    b += w * tables.linear[p.b];
    coverage += w;
  }
  /// `whole`: the weight that full coverage would have had.
  Rgba8 colour(double whole) const {
    const auto byte = [this](double sum) { return tables.srgb[roundedUnsigned(sum / coverage)]; };
    const auto alpha = static_cast<std::uint8_t>(roundedUnsigned(std::min(coverage / whole, 255.0)));
    return {byte(r), byte(g), byte(b), alpha};
  }
};

}  // namespace

void layHeightBesideVoid(const std::array<float, 4>& v, const Between& place, float& out) {
  if (!isNoData(v[place.nearest()])) out = meanOfKnown(v, place.weights());
}

Rgba8 partlyCoveredMean(const ColourTables& tables, const std::array<Rgba8, 4>& p, const Between& place) {
  if (p[place.nearest()].a == 0) return {};
  const auto weights = place.weights();
  Light light{.tables = tables};
  double known = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (p[i].a == 0) continue;
    light.add(p[i], weights[i]);
    known += weights[i];
  }
  return light.colour(known);
}

bool bilinearHeights(PixelStore<float>& store, const PixelPlaces& places, std::span<float> out) {
  const GridTopology grid = store.levels().front();
  std::array<float, 4> v{};
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (!isInside(grid, places.col[i], places.row[i])) continue;
    const Between place = between(places.col[i], places.row[i]);
    if (!store.quad(place.col, place.row, v)) return false;
    layHeight(v, place, out[i]);
  }
  return true;
}

bool meanHeights(PixelStore<float>& store, const PixelPlaces& places, std::span<float> out) {
  const GridTopology grid = store.levels().front();
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (!isInside(grid, places.col[i], places.row[i])) continue;
    const PixelBox box = boxAround(places.col[i], places.row[i], places.width[i], places.height[i]);
    double sum = 0.0;
    double known = 0.0;
    const auto whole = visitBox(store, box, [&](float v, double area) {
      if (isNoData(v)) return;
      sum += area * static_cast<double>(v);
      known += area;
    });
    if (!whole) return false;
    if (known > 0.0 && known >= kHalf * *whole) out[i] = static_cast<float>(sum / known);
  }
  return true;
}

bool bilinearColours(PixelStore<Rgba8>& store, const PixelPlaces& places, std::span<Rgba8> out) {
  const GridTopology grid = store.levels().front();
  const ColourTables tables = colourTables();
  std::array<Rgba8, 4> p{};
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (!isInside(grid, places.col[i], places.row[i])) continue;
    const Between place = between(places.col[i], places.row[i]);
    if (!store.quad(place.col, place.row, p)) return false;
    layColour(tables, p, place, out[i]);
  }
  return true;
}

bool meanColours(PixelStore<Rgba8>& store, const PixelPlaces& places, std::span<Rgba8> out) {
  const GridTopology grid = store.levels().front();
  const ColourTables tables = colourTables();
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (!isInside(grid, places.col[i], places.row[i])) continue;
    const PixelBox box = boxAround(places.col[i], places.row[i], places.width[i], places.height[i]);
    Light light{.tables = tables};
    const auto whole = visitBox(store, box, [&](const Rgba8& p, double area) { light.add(p, area); });
    if (!whole) return false;
    if (light.coverage > 0.0) out[i] = over(light.colour(*whole), out[i]);
  }
  return true;
}

}  // namespace tellurion::raster
