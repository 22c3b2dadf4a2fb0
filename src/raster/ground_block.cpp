#include "raster/ground_block.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>

#include "raster/raster.h"

namespace tellurion::raster {
namespace {

constexpr int kBins = 48;          ///< a side
constexpr double kInside = -1e-9;  ///< of a barycentric coordinate, for rounding

int binOf(double share) {
  return std::clamp(static_cast<int>(share * kBins), 0, kBins - 1);
}

}  // namespace

GroundBlock::GroundBlock(const StereographicPlane& plane, std::vector<Corner> corners, std::vector<Triangle> triangles)
    : plane_(plane), corners_(std::move(corners)), triangles_(std::move(triangles)) {
  if (triangles_.empty()) return;
  whole_ = boxOf(triangles_.front());
  for (const Triangle& triangle : triangles_) {
    const StereographicPlane::Box box = boxOf(triangle);
    whole_ = {std::min(whole_.minX, box.minX), std::min(whole_.minY, box.minY), std::max(whole_.maxX, box.maxX),
              std::max(whole_.maxY, box.maxY)};
  }
  starts_.assign(kBins * kBins + 1, 0);
  forAllBins([&](std::size_t bin, std::uint32_t) { ++starts_[bin + 1]; });
  std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
  inBins_.resize(starts_.back());
  std::vector<std::uint32_t> next(starts_.begin(), std::prev(starts_.end()));
  forAllBins([&](std::size_t bin, std::uint32_t triangle) { inBins_[next[bin]++] = triangle; });
}

StereographicPlane::Box GroundBlock::boxOf(const Triangle& triangle) const {
  return plane_.boxAround(
      std::array{corners_[triangle[0]].place, corners_[triangle[1]].place, corners_[triangle[2]].place});
}

int GroundBlock::columnOf(double x) const {
  return binOf((x - whole_.minX) / (whole_.maxX - whole_.minX));
}

int GroundBlock::rowOf(double y) const {
  return binOf((y - whole_.minY) / (whole_.maxY - whole_.minY));
}

template <class Visit>
void GroundBlock::forAllBins(const Visit& visit) const {
  for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
    const StereographicPlane::Box box = boxOf(triangles_[i]);
    for (int row = rowOf(box.minY); row <= rowOf(box.maxY); ++row) {
      for (int column = columnOf(box.minX); column <= columnOf(box.maxX); ++column)
        visit(static_cast<std::size_t>(row) * kBins + static_cast<std::size_t>(column), i);
    }
  }
}

float GroundBlock::heightAt(const geo::Direction& place) const {
  if (triangles_.empty() || !plane_.holds(place)) return kNoData;
  const StereographicPlane::Place at = plane_.at(place);
  if (at.x < whole_.minX || at.x > whole_.maxX || at.y < whole_.minY || at.y > whole_.maxY) return kNoData;
  const std::size_t bin = static_cast<std::size_t>(rowOf(at.y)) * kBins + static_cast<std::size_t>(columnOf(at.x));
  for (std::uint32_t i = starts_[bin]; i < starts_[bin + 1]; ++i) {
    const Triangle& triangle = triangles_[inBins_[i]];
    const Corner& first = corners_[triangle[0]];
    const Corner& second = corners_[triangle[1]];
    const Corner& third = corners_[triangle[2]];
    // From the place itself: small differences, whose products keep their digits.
    const geo::Vec3 a = first.place.n - place.n;
    const geo::Vec3 b = second.place.n - place.n;
    const geo::Vec3 c = third.place.n - place.n;
    const double ofA = geo::dot(geo::cross(b, c), place.n);
    const double ofB = geo::dot(geo::cross(c, a), place.n);
    const double ofC = geo::dot(geo::cross(a, b), place.n);
    const double sum = ofA + ofB + ofC;
    if (!(sum > 0.0) || std::min({ofA, ofB, ofC}) < kInside * sum) continue;
    return static_cast<float>((ofA * static_cast<double>(first.height_m) + ofB * static_cast<double>(second.height_m) +
                               ofC * static_cast<double>(third.height_m)) /
                              sum);
  }
  return kNoData;
}

std::uint64_t GroundBlock::bytes() const {
  return sizeof(GroundBlock) + corners_.capacity() * sizeof(Corner) + triangles_.capacity() * sizeof(Triangle) +
         (starts_.capacity() + inBins_.capacity()) * sizeof(std::uint32_t);
}

}  // namespace tellurion::raster
