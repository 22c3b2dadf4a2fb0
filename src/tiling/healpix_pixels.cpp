#include "tiling/healpix_pixels.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "tiling/healpix_plane.h"
#include "tiling/morton.h"

namespace tellurion::tiling {
namespace {

constexpr std::size_t kBlock = 128;  // places whose numbers stay in the first-level cache

using Block = std::array<double, kBlock>;

// HEALPix counts ix from the south corner to the east corner and iy from the south corner to the west corner: against y
// and x.
std::uint64_t nested(int order, int root, std::uint32_t x, std::uint32_t y) {
  const std::uint32_t last = (std::uint32_t{1} << order) - 1u;
  return (static_cast<std::uint64_t>(root) << (2 * order)) | interleaved(last - y, last - x);
}

TileId tileOf(int order, std::uint64_t pixel) {
  assert(order >= 0 && order <= kMaxLevel && (pixel >> (2 * order)) < healpix::kRoots);
  const std::uint32_t last = (std::uint32_t{1} << order) - 1u;
  const std::uint64_t inRoot = pixel & ((std::uint64_t{1} << (2 * order)) - 1u);
  return {static_cast<std::uint8_t>(order), static_cast<std::uint8_t>(pixel >> (2 * order)),
          last - evenBits(inRoot >> 1u), last - evenBits(inRoot)};
}

std::uint64_t pixelAt(const geo::Direction& d, int order) {
  const RootPoint p = healpix::rootPoint(d);
  return nested(order, p.root, tileCoordinate(p.u, order), tileCoordinate(p.v, order));
}

RootPoint middleOf(std::uint64_t pixel, int order) {
  return rootPointIn(tileOf(order, pixel), 0.5, 0.5);
}

}  // namespace

std::uint64_t healpixNested(const TileId& id) {
  return nested(id.level, id.root, id.x, id.y);
}

TileId tileFromHealpixNested(int order, std::uint64_t pixel) {
  return tileOf(order, pixel);
}

std::uint64_t healpixNestedAt(const geo::Direction& d, int order) {
  assert(order >= 0 && order <= kMaxLevel);
  return pixelAt(d, order);
}

void healpixNestedAt(std::span<const geo::Direction> directions, int order, std::span<std::uint64_t> pixels) {
  assert(order >= 0 && order <= kMaxLevel && pixels.size() == directions.size());
  Block x{};
  Block y{};
  Block z{};
  Block u{};
  Block v{};
  Block root{};
  Block fromBorder{};
  for (std::size_t start = 0; start < directions.size(); start += kBlock) {
    const std::size_t count = std::min(kBlock, directions.size() - start);
    for (std::size_t i = 0; i < count; ++i) {
      x[i] = directions[start + i].n.x;
      y[i] = directions[start + i].n.y;
      z[i] = directions[start + i].n.z;
    }
    for (std::size_t i = 0; i < kBlock; ++i) {
      const healpix::InsideRoot found = healpix::rootPointInside(healpix::placeOnPlane({geo::Vec3(x[i], y[i], z[i])}));
      u[i] = found.u;
      v[i] = found.v;
      root[i] = found.root;
      fromBorder[i] = found.fromBorder;
    }
    for (std::size_t i = 0; i < count; ++i) {
      pixels[start + i] =
          fromBorder[i] > healpix::kBorder
              ? nested(order, static_cast<int>(root[i]), tileCoordinate(u[i], order), tileCoordinate(v[i], order))
              : pixelAt(directions[start + i], order);
    }
  }
}

geo::Direction healpixCentre(std::uint64_t pixel, int order) {
  return healpix::directionInline(middleOf(pixel, order));
}

void healpixCentres(std::span<const std::uint64_t> pixels, int order, std::span<geo::Direction> centres) {
  assert(centres.size() == pixels.size());
  Block u{};
  Block v{};
  Block root{};
  Block x{};
  Block y{};
  Block z{};
  for (std::size_t start = 0; start < pixels.size(); start += kBlock) {
    const std::size_t count = std::min(kBlock, pixels.size() - start);
    for (std::size_t i = 0; i < count; ++i) {
      const RootPoint middle = middleOf(pixels[start + i], order);
      root[i] = middle.root;
      u[i] = middle.u;
      v[i] = middle.v;
    }
    for (std::size_t i = 0; i < kBlock; ++i) {
      const geo::Vec3 n = healpix::directionInline({static_cast<int>(root[i]), u[i], v[i]}).n;
      x[i] = n.x;
      y[i] = n.y;
      z[i] = n.z;
    }
    for (std::size_t i = 0; i < count; ++i)
      centres[start + i] = {geo::Vec3(x[i], y[i], z[i])};
  }
}

}  // namespace tellurion::tiling
