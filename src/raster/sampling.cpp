#include "raster/sampling.h"

#include <array>
#include <cmath>

#include "raster/colour.h"

namespace tellurion::raster {
namespace {

/// Half of a square, less the rounding of places on the very edge of the data.
constexpr double kHalf = 0.5 - 1e-6;

/// Written so that NaN is outside.
bool isInside(const GridTopology& grid, double col, double row) {
  return col >= 0.0 && col <= grid.width && row >= 0.0 && row <= grid.height;
}

/// Of 0 to 2^31: as std::lround, which is a call into the library, but for the one number below a half.
std::uint32_t rounded(double v) {
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(v + 0.5));
}

/// The four pixels around a place: the upper left one and the place between their middles, in [0, 1).
struct Between {
  int col;
  int row;
  double s;
  double t;
  /// Index of the nearest of the four; halfway the later one.
  std::size_t nearest() const { return (s >= 0.5 ? 1u : 0u) + (t >= 0.5 ? 2u : 0u); }
  std::array<double, 4> weights() const { return {(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t}; }
};

Between between(double col, double row) {
  const double left = std::floor(col - 0.5);
  const double top = std::floor(row - 0.5);
  return {static_cast<int>(left), static_cast<int>(top), (col - 0.5) - left, (row - 0.5) - top};
}

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
    const auto byte = [this](double sum) { return tables.srgb[rounded(sum / coverage)]; };
    const auto alpha = static_cast<std::uint8_t>(rounded(std::min(coverage / whole, 255.0)));
    return {byte(r), byte(g), byte(b), alpha};
  }
};

/// Weights that add up to 65536, of a place rounded to 1/256 pixel.
std::array<std::uint32_t, 4> wholeWeights(double s, double t) {
  const auto right = rounded(s * 256.0);
  const auto lower = rounded(t * 256.0);
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

bool bilinearHeights(PixelStore<float>& store, const PixelPlaces& places, std::span<float> out) {
  const GridTopology grid = store.levels().front();
  std::array<float, 4> v{};
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (!isInside(grid, places.col[i], places.row[i])) continue;
    const Between place = between(places.col[i], places.row[i]);
    if (!store.quad(place.col, place.row, v)) return false;
    const double top = static_cast<double>(v[0]) * (1.0 - place.s) + static_cast<double>(v[1]) * place.s;
    const double bottom = static_cast<double>(v[2]) * (1.0 - place.s) + static_cast<double>(v[3]) * place.s;
    const double height = top * (1.0 - place.t) + bottom * place.t;
    if (!std::isnan(height)) {
      out[i] = static_cast<float>(height);
    } else if (!isNoData(v[place.nearest()])) {
      out[i] = meanOfKnown(v, place.weights());
    }
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
    if ((p[0].a & p[1].a & p[2].a & p[3].a) == 255) {
      out[i] = opaqueMean(tables, p, place.s, place.t);
    } else {
      out[i] = over(partlyCoveredMean(tables, p, place), out[i]);
    }
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
