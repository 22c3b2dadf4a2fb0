#include "raster/weight_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tellurion::raster {
namespace {

constexpr double kPole_deg = 90.0 - 1e-9;
constexpr double kFar = 1e30;

/// For each node of a column how far the nearest unmarked one of the column is, squared metres.
void alongColumns(const LonLatGrid& grid, const Raster<std::uint8_t>& marked, double step_m, bool borderCounts,
                  Raster<float>& squares) {
  const bool northCounts = borderCounts && grid.bounds.north.degrees() < kPole_deg;
  const bool southCounts = borderCounts && grid.bounds.south.degrees() > -kPole_deg;
  const auto squared = [&](double steps) {
    return steps >= kFar ? std::numeric_limits<float>::max() : static_cast<float>(steps * step_m * steps * step_m);
  };
  std::vector<double> steps(static_cast<std::size_t>(grid.height));
  for (int col = 0; col < grid.width; ++col) {
    // The border lies half a step beyond the outer nodes.
    double since = northCounts ? -0.5 : kFar;
    for (int row = 0; row < grid.height; ++row) {
      since = marked.at(col, row) == 0 ? 0.0 : since + 1.0;
      steps[static_cast<std::size_t>(row)] = since;
    }
    since = southCounts ? -0.5 : kFar;
    for (int row = grid.height - 1; row >= 0; --row) {
      since = marked.at(col, row) == 0 ? 0.0 : since + 1.0;
      squares.at(col, row) = squared(std::min(since, steps[static_cast<std::size_t>(row)]));
    }
  }
}

/// The least of value[j] + (step (i - j))^2 over all j, for every i: the lower envelope of parabolas, in linear time.
class Envelope {
 public:
  void compute(const std::vector<double>& values, double step) {
    const std::size_t count = values.size();
    feet_.assign(count, 0);
    from_.assign(count + 1, 0.0);
    least.assign(count, kFar);
    std::size_t used = 0;
    const double square = step * step;
    for (std::size_t j = 0; j < count; ++j) {
      if (values[j] >= kFar) continue;
      const auto crossing = [&](std::size_t foot) {
        const auto a = static_cast<double>(foot);
        const auto b = static_cast<double>(j);
        return ((values[j] - values[foot]) / square + b * b - a * a) / (2.0 * (b - a));
      };
      while (used > 0 && crossing(feet_[used - 1]) <= from_[used - 1])
        --used;
      from_[used] = used == 0 ? -kFar : crossing(feet_[used - 1]);
      feet_[used++] = j;
    }
    if (used == 0) return;
    std::size_t k = 0;
    for (std::size_t i = 0; i < count; ++i) {
      while (k + 1 < used && from_[k + 1] < static_cast<double>(i))
        ++k;
      const double away = (static_cast<double>(i) - static_cast<double>(feet_[k])) * step;
      least[i] = values[feet_[k]] + away * away;
    }
  }
  std::vector<double> least;

 private:
  std::vector<std::size_t> feet_;
  std::vector<double> from_;
};

}  // namespace

double WeightMap::at(const geo::Direction& place) const {
  const LonLatGrid::Spot s = grid.spotOf(place);
  const auto weight = [&](int col, int row) { return static_cast<double>(weights.at(col, row)); };
  const double top = weight(s.col0, s.row0) * (1.0 - s.right) + weight(s.col1, s.row0) * s.right;
  const double bottom = weight(s.col0, s.row1) * (1.0 - s.right) + weight(s.col1, s.row1) * s.right;
  return (top * (1.0 - s.down) + bottom * s.down) / 255.0;
}

Raster<float> distancesToUnmarked(const LonLatGrid& grid, const Raster<std::uint8_t>& marked, const geo::Body& body,
                                  double most_m, bool borderCounts) {
  Raster<float> distances(grid.width, grid.height);
  alongColumns(grid, marked, grid.rowStep_m(body), borderCounts, distances);
  Envelope envelope;
  std::vector<double> row;
  for (int r = 0; r < grid.height; ++r) {
    const double step_m = std::max(grid.columnStep_m(body, r), 1e-6);
    // What lies farther than the most is of no account; a row that goes around begins again on both sides.
    const int pad = grid.wraps() ? static_cast<int>(std::min(most_m / step_m + 1.0, grid.width * 1.0)) : 0;
    row.clear();
    for (int c = -pad; c < grid.width + pad; ++c) {
      const float square = distances.at(((c % grid.width) + grid.width) % grid.width, r);
      row.push_back(square == std::numeric_limits<float>::max() ? kFar : static_cast<double>(square));
    }
    envelope.compute(row, step_m);
    for (int c = 0; c < grid.width; ++c) {
      double square = envelope.least[static_cast<std::size_t>(c + pad)];
      if (borderCounts && !grid.wraps()) {
        const double toBorder_m = (std::min(c, grid.width - 1 - c) + 0.5) * step_m;
        square = std::min(square, toBorder_m * toBorder_m);
      }
      distances.at(c, r) = marked.at(c, r) == 0 ? 0.0f : static_cast<float>(std::min(std::sqrt(square), most_m));
    }
  }
  return distances;
}

double rampOf(double distance_m, double width_m) {
  if (!(width_m > 0.0)) return distance_m > 0.0 ? 1.0 : 0.0;
  const double t = std::clamp(distance_m / width_m, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

}  // namespace tellurion::raster
