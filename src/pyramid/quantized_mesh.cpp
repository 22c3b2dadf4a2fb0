#include "pyramid/quantized_mesh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>

namespace tellurion::pyramid {
namespace {

constexpr int kSide = kTerrainCells + 1;
constexpr int kMost = 32767;  // of u, v and height
constexpr double kLeastStep_m = 1.0 / 128.0;
constexpr double kFloatIntegers = 8388608.0;  // 2^23: multiples of a step up to here are exact in a float
constexpr double kFarthestOcclusion = 1e6;    // in radii: for tiles so wide that no nearer point stands for them

int quantizedShare(int i) {
  return static_cast<int>(std::lround(static_cast<double>(i) * kMost / kTerrainCells));
}

/// Little-endian, as this program's machines are.
static_assert(std::endian::native == std::endian::little);

class Bytes {
 public:
  template <class T>
  void put(T value) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof(T));
    std::memcpy(bytes_.data() + at, &value, sizeof(T));
  }
  void put(const geo::Vec3& v) {
    put(v.x);
    put(v.y);
    put(v.z);
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

/// Triangles of a grid, and its vertices in the order of their first use, which the format's way to write indices
/// wants.
struct Grid {
  std::vector<std::uint16_t> indices;   ///< three a triangle, counter-clockwise from above
  std::vector<std::uint16_t> vertices;  ///< of each new number, row * kSide + column
  std::vector<std::uint16_t> numbers;   ///< and back
};

Grid gridOfTriangles() {
  constexpr std::uint16_t kNone = 0xffff;
  Grid grid;
  grid.numbers.assign(kSide * kSide, kNone);
  const auto use = [&grid](int column, int row) {
    const auto place = static_cast<std::uint16_t>(row * kSide + column);
    std::uint16_t& number = grid.numbers[place];
    if (number == kNone) {
      number = static_cast<std::uint16_t>(grid.vertices.size());
      grid.vertices.push_back(place);
    }
    grid.indices.push_back(number);
  };
  for (int row = 0; row < kTerrainCells; ++row) {
    for (int column = 0; column < kTerrainCells; ++column) {
      use(column, row);
      use(column, row + 1);
      use(column + 1, row);
      use(column + 1, row);
      use(column, row + 1);
      use(column + 1, row + 1);
    }
  }
  return grid;
}

struct Sphere {
  geo::Vec3 centre{0.0};
  double radius_m = 0.0;
};

Sphere sphereAround(const std::vector<geo::BodyPosition>& points) {
  geo::Vec3 low = points.front().m;
  geo::Vec3 high = low;
  for (const geo::BodyPosition& p : points) {
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], p.m[k]);
      high[k] = std::max(high[k], p.m[k]);
    }
  }
  Sphere sphere{.centre = (low + high) * 0.5};
  for (const geo::BodyPosition& p : points) {
    const geo::Vec3 to = p.m - sphere.centre;
    sphere.radius_m = std::max(sphere.radius_m, std::sqrt(dot(to, to)));
  }
  return sphere;
}

/// A point, in a space where the ellipsoid is the unit sphere, that is below the horizon only where all of `points`
/// are: along the direction of `centre`, so far out that its tangent cone holds theirs. A point at distance r, at an
/// angle a from there, sees acos(1/r) around itself, so 1/cos(a + acos(1/r)).
geo::Vec3 occlusionPoint(const std::vector<geo::BodyPosition>& points, const geo::Vec3& centre,
                         const geo::Ellipsoid& ellipsoid) {
  const geo::Vec3 scale{1.0 / ellipsoid.semiMajorAxis_m(), 1.0 / ellipsoid.semiMajorAxis_m(),
                        1.0 / ellipsoid.semiMinorAxis_m()};
  const geo::Vec3 scaled = centre * scale;
  const geo::Vec3 along = scaled / std::sqrt(dot(scaled, scaled));
  double farthest = 1.0;
  for (const geo::BodyPosition& p : points) {
    const geo::Vec3 q = p.m * scale;
    const double r = std::sqrt(dot(q, q));
    const double from = std::acos(std::clamp(dot(q, along) / r, -1.0, 1.0));
    const double sees = r > 1.0 ? std::acos(1.0 / r) : 0.0;
    const double cosine = std::cos(std::min(from + sees, geo::kPi));
    farthest = std::max(farthest, cosine > 1.0 / kFarthestOcclusion ? 1.0 / cosine : kFarthestOcclusion);
  }
  return along * farthest;
}

std::uint16_t zigzag(int value) {
  return static_cast<std::uint16_t>((value << 1) ^ (value >> 31));
}

/// Differences between values that follow each other.
template <class Value>
void putDeltas(Bytes& bytes, const Grid& grid, const Value& value) {
  int before = 0;
  for (const std::uint16_t place : grid.vertices) {
    const int now = value(place % kSide, place / kSide);
    bytes.put(zigzag(now - before));
    before = now;
  }
}

/// Each index as its distance from the highest so far, plus one.
void putIndices(Bytes& bytes, const Grid& grid) {
  bytes.put(static_cast<std::uint32_t>(grid.indices.size() / 3));
  int next = 0;
  for (const std::uint16_t index : grid.indices) {
    bytes.put(static_cast<std::uint16_t>(next - index));
    if (index == next) ++next;
  }
}

void putEdges(Bytes& bytes, const Grid& grid) {
  const auto put = [&](auto placeOf) {
    bytes.put(std::uint32_t{kSide});
    for (int i = 0; i < kSide; ++i)
      bytes.put(grid.numbers[static_cast<std::size_t>(placeOf(i))]);
  };
  put([](int i) { return i * kSide; });                  // west
  put([](int i) { return kTerrainCells * kSide + i; });  // south
  put([](int i) { return i * kSide + kTerrainCells; });  // east
  put([](int i) { return i; });                          // north
}

}  // namespace

PlaceGrid terrainPlaces(const MapTile& tile) {
  PlaceGrid grid;
  const double side = 180.0 / static_cast<double>(mapRows(MapScheme::geodetic, tile.zoom));
  for (int i = 0; i < kSide; ++i) {
    const double share = static_cast<double>(quantizedShare(i)) / kMost;
    // Rows from the north: the format's v, which counts from the south, of row i is that of kTerrainCells - i.
    const double fromSouth = static_cast<double>(quantizedShare(kTerrainCells - i)) / kMost;
    grid.longitudes_degrees.push_back(-180.0 + side * (static_cast<double>(tile.x) + share));
    grid.latitudes_degrees.push_back(90.0 - side * (static_cast<double>(tile.y) + 1.0 - fromSouth));
    grid.steps_degrees.push_back(side / kTerrainCells);
  }
  return grid;
}

double terrainStep_m(double lowest_m, double highest_m) {
  const double range = (highest_m - lowest_m) / (kMost - 1);
  const double largest = std::max(std::abs(lowest_m), std::abs(highest_m)) / (kFloatIntegers - kMost);
  double step = kLeastStep_m;
  while (step < std::max(range, largest))
    step *= 2.0;
  return step;
}

std::vector<std::byte> encodeQuantizedMesh(const raster::Raster<float>& heights, const MapTile& tile,
                                           const geo::Ellipsoid& ellipsoid, double step_m) {
  static const Grid grid = gridOfTriangles();
  const PlaceGrid places = terrainPlaces(tile);
  std::vector<std::int64_t> steps;
  std::vector<geo::BodyPosition> points;
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      const float h = heights.at(column, row);
      steps.push_back(raster::isNoData(h) ? 0 : std::llround(static_cast<double>(h) / step_m));
      points.push_back(ellipsoid.bodyFromDirection(
          geo::directionFromDegrees(places.latitudes_degrees[static_cast<std::size_t>(row)],
                                    places.longitudes_degrees[static_cast<std::size_t>(column)]),
          static_cast<double>(steps.back()) * step_m));
    }
  }
  const std::int64_t lowest = *std::ranges::min_element(steps);
  const Sphere sphere = sphereAround(points);
  Bytes bytes;
  bytes.put(sphere.centre);
  bytes.put(static_cast<float>(static_cast<double>(lowest) * step_m));
  bytes.put(static_cast<float>(static_cast<double>(lowest + kMost) * step_m));
  bytes.put(sphere.centre);
  bytes.put(sphere.radius_m);
  bytes.put(occlusionPoint(points, sphere.centre, ellipsoid));
  bytes.put(static_cast<std::uint32_t>(grid.vertices.size()));
  putDeltas(bytes, grid, [](int column, int) { return quantizedShare(column); });
  putDeltas(bytes, grid, [](int, int row) { return quantizedShare(kTerrainCells - row); });
  putDeltas(bytes, grid, [&](int column, int row) {
    const std::int64_t above = steps[static_cast<std::size_t>(row * kSide + column)] - lowest;
    return static_cast<int>(std::min<std::int64_t>(above, kMost));
  });
  putIndices(bytes, grid);
  putEdges(bytes, grid);
  return bytes.take();
}

}  // namespace tellurion::pyramid
