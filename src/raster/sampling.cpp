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

/// Weights that add up to 65536, of a place rounded to 1/256 pixel.
std::array<std::uint32_t, 4> wholeWeights(double s, double t) {
  const auto right = roundedUnsigned(s * 256.0);
  const auto lower = roundedUnsigned(t * 256.0);
  return {(256 - right) * (256 - lower), right * (256 - lower), (256 - right) * lower, right * lower};
}

Rgba8 opaqueMean(const ColourTables& tables, const std::array<Rgba8, 4>& p, double s, double t) {
  const auto w = wholeWeights(s, t);
  const auto mean = [&](std::uint8_t a, std::uint8_t b, std::uint8_t c, std::uint8_t d) {
    const std::uint32_t sum =
        w[0] * tables.linear[a] + w[1] * tables.linear[b] + w[2] * tables.linear[c] + w[3] * tables.linear[d] + 32768u;
    return tables.srgb[sum >> 16u];
  };
  return {mean(p[0].r, p[1].r, p[2].r, p[3].r), mean(p[0].g, p[1].g, p[2].g, p[3].g),
          mean(p[0].b, p[1].b, p[2].b, p[3].b), 255};
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

}  // namespace

void layHeight(const std::array<float, 4>& v, const Between& place, float& out) {
  const double top = static_cast<double>(v[0]) * (1.0 - place.s) + static_cast<double>(v[1]) * place.s;
  const double bottom = static_cast<double>(v[2]) * (1.0 - place.s) + static_cast<double>(v[3]) * place.s;
  const double height = top * (1.0 - place.t) + bottom * place.t;
  if (!std::isnan(height)) {
    out = static_cast<float>(height);
  } else if (!isNoData(v[place.nearest()])) {
    out = meanOfKnown(v, place.weights());
  }
}

void layColour(const ColourTables& tables, const std::array<Rgba8, 4>& p, const Between& place, Rgba8& out) {
  if ((p[0].a & p[1].a & p[2].a & p[3].a) == 255) {
    out = opaqueMean(tables, p, place.s, place.t);
  } else {
    out = over(partlyCoveredMean(tables, p, place), out);
  }
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
