// Triangulations against what makes a triangle one of Delaunay's: no other place lies in its circle.
#include "raster/point_triangles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "geo/seed_test.h"

namespace tellurion::raster {
namespace {

using Places = std::vector<geo::Direction>;

Places scattered(std::mt19937_64& random, int count, double lat, double lon, double size) {
  Places places;
  for (int i = 0; i < count; ++i) {
    places.push_back(
        geo::directionFromDegrees(lat + geo::uniform(random, -size, size), lon + geo::uniform(random, -size, size)));
  }
  return places;
}

/// Each from its lowest corner on.
std::set<Triangle> inOrder(const std::vector<Triangle>& triangles) {
  std::set<Triangle> result;
  for (Triangle t : triangles) {
    std::ranges::rotate(t, std::ranges::min_element(t));
    result.insert(t);
  }
  return result;
}

TEST(PointTriangles, HoldNoOtherPlaceInTheirCircles) {
  auto random = geo::seededGenerator();
  for (const double lat : {0.0, 47.0, 90.0, -89.9}) {
    const Places places = scattered(random, 150, std::min(lat, 89.0), 179.9, 1.0);
    const StereographicPlane plane(places.front(), 0.01);
    const auto triangles = delaunayTriangles(places, plane);
    EXPECT_GT(triangles.size(), 200u);
    for (const auto& [i, j, k] : triangles) {
      const geo::Vec3& a = places[i].n;
      const geo::Vec3 normal = geo::cross(places[j].n - a, places[k].n - a);
      EXPECT_GT(geo::dot(normal, a), 0.0) << "runs clockwise";
      for (const geo::Direction& other : places)
        EXPECT_LT(geo::dot(normal, other.n - a), 1e-8 * geo::dot(normal, normal) + 1e-18);
    }
  }
}

// The cells of a grid of longitude and latitude have their four corners on a circle, a parallel around a pole all of
// its places.
TEST(PointTriangles, PlacesOfOneCircleAreCutTheSameWayInEveryPlane) {
  Places grid;
  for (int row = 0; row < 30; ++row) {
    for (int column = 0; column < 30; ++column)
      grid.push_back(geo::directionFromDegrees(46.0 + 0.25 * row, 7.0 + 0.25 * column));
  }
  Places ring;
  for (int i = 0; i < 360; ++i) {
    ring.push_back(geo::directionFromDegrees(89.5, i));
    ring.push_back(geo::directionFromDegrees(88.5, i));
  }
  for (Places places : {grid, ring}) {
    std::ranges::shuffle(places, std::mt19937(geo::testSeed()));
    const auto first = inOrder(delaunayTriangles(places, StereographicPlane(places[0], 0.004)));
    EXPECT_GE(first.size(), places.size());
    for (const std::size_t centre : {1u, 300u, 600u})
      EXPECT_EQ(first, inOrder(delaunayTriangles(places, StereographicPlane(places[centre], 0.007))));
  }
}

TEST(PointTriangles, AreNoneWherePlacesAreTooFewOrOnALine) {
  Places line;
  for (int i = 0; i < 20; ++i)
    line.push_back(geo::directionFromDegrees(0.0, i));
  const StereographicPlane plane(line[10], 0.1);
  EXPECT_TRUE(delaunayTriangles({}, plane).empty());
  EXPECT_TRUE(delaunayTriangles(std::span(line).first(2), plane).empty());
  EXPECT_TRUE(delaunayTriangles(line, plane).empty());
}

}  // namespace
}  // namespace tellurion::raster
