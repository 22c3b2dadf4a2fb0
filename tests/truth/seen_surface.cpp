#include "truth/seen_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <thread>

namespace tellurion::truth {
namespace {

constexpr double kUnknown = -1.0;

scene::PixelPosition middleOf(int col, int row) {
  return {col + 0.5, row + 0.5};
}

}  // namespace

void Tally::count(double miss_px, int atCamera, int atCol, int atRow) {
  ++pixels;
  withinTolerance += miss_px <= tolerance_px ? 1 : 0;
  withinPixel += miss_px <= 1.0 ? 1 : 0;
  if (miss_px <= worst_px) return;
  worst_px = miss_px;
  camera = atCamera;
  col = atCol;
  row = atRow;
}

void Tally::add(const Tally& other) {
  pixels += other.pixels;
  withinTolerance += other.withinTolerance;
  withinPixel += other.withinPixel;
  if (other.worst_px <= worst_px) return;
  worst_px = other.worst_px;
  camera = other.camera;
  col = other.col;
  row = other.row;
}

double Tally::share() const {
  return pixels == 0 ? 0.0 : static_cast<double>(withinTolerance) / static_cast<double>(pixels);
}

double Tally::enough_px() const {
  return std::min({tolerance_px, 1.0, worst_px});
}

std::string Tally::told() const {
  std::array<char, 200> text{};
  const auto percent = [&](long n) {
    return pixels == 0 ? 0.0 : 100.0 * static_cast<double>(n) / static_cast<double>(pixels);
  };
  std::snprintf(text.data(), text.size(),
                "%9ld pixels, %.4f%% within the tolerance, %.4f%% within a pixel, worst %.2f px (camera %d, pixel %d, "
                "%d)",
                pixels, percent(withinTolerance), percent(withinPixel), worst_px, camera, col, row);
  return text.data();
}

SeenSurface::SeenSurface(SeenAlong surface, const scene::View& view)
    : surface_(std::move(surface)),
      view_(view),
      centres_(view.viewport.width, view.viewport.height, exactly(kUnknown)) {}

const Seen& SeenSurface::centre(int col, int row) {
  Seen& known = centres_.at(col, row);
  if (known.nearest_m == kUnknown) known = surface_(scene::rayThrough(view_, middleOf(col, row)));
  return known;
}

Tally SeenSurface::compare(const raster::Raster<float>& drawn, double tolerance_px, int camera, const Counts& counts) {
  const double most_px = 4.0 * std::max(tolerance_px, 1.0);
  Tally sum(tolerance_px);
  Tally others(tolerance_px);
  const auto rows = [&](int first, Tally& tally) {
    for (int row = first; row < drawn.height; row += 2) {
      for (int col = 0; col < drawn.width; ++col) {
        const auto distance = static_cast<double>(drawn.at(col, row));
        if (!counts(col, row, distance)) continue;
        if (std::isnan(distance) && std::isnan(centre(col, row).nearest_m)) continue;
        const double miss =
            missOf(surface_, view_, middleOf(col, row), distance, centre(col, row), most_px, tally.enough_px());
        tally.count(miss, camera, col, row);
      }
    }
  };
  {
    const std::jthread other(rows, 1, std::ref(others));
    rows(0, sum);
  }
  sum.add(others);
  return sum;
}

}  // namespace tellurion::truth
