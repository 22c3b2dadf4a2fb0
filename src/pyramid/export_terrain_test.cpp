#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <random>
#include <set>
#include <sstream>

#include "geo/seed_test.h"
#include "pyramid/export_fixture_test.h"
#include "pyramid/quantized_mesh.h"

namespace tellurion::pyramid::testing {
namespace {

using raster::Kind;
using tiling::Scheme;

/// A tile as a reader of the format sees it, written from the format's description alone.
struct Terrain {
  geo::Vec3 centre{0.0}, sphereCentre{0.0}, occlusion{0.0};
  double radius_m = 0.0;
  float min_m = 0.0f, max_m = 0.0f;
  std::vector<int> u, v, h;
  std::vector<std::uint32_t> triangles;
  std::array<std::vector<std::uint32_t>, 4> edges;  ///< west, south, east, north

  double height_m(std::size_t i) const {
    return static_cast<double>(min_m) + (static_cast<double>(max_m) - static_cast<double>(min_m)) * h[i] / 32767.0;
  }
};

class Reader {
 public:
  explicit Reader(std::string bytes) : bytes_(std::move(bytes)) {}
  template <class T>
  T get() {
    T value{};
    if (at_ + sizeof(T) > bytes_.size()) {
      ADD_FAILURE() << "the tile ends early";
      return value;
    }
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  geo::Vec3 vector() {
    const double x = get<double>();
    const double y = get<double>();
    const double z = get<double>();
    return {x, y, z};
  }
  std::vector<int> deltas(std::uint32_t count) {
    std::vector<int> values;
    int value = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      const int coded = get<std::uint16_t>();
      value += (coded >> 1) ^ -(coded & 1);
      values.push_back(value);
    }
    return values;
  }
  bool isAtEnd() const { return at_ == bytes_.size(); }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

Terrain decoded(const std::filesystem::path& path) {
  Reader reader(bytesOf(path));
  Terrain tile;
  tile.centre = reader.vector();
  tile.min_m = reader.get<float>();
  tile.max_m = reader.get<float>();
  tile.sphereCentre = reader.vector();
  tile.radius_m = reader.get<double>();
  tile.occlusion = reader.vector();
  const auto vertices = reader.get<std::uint32_t>();
  EXPECT_LE(vertices, 65536u);
  tile.u = reader.deltas(vertices);
  tile.v = reader.deltas(vertices);
  tile.h = reader.deltas(vertices);
  const auto triangles = reader.get<std::uint32_t>();
  std::uint32_t highest = 0;
  for (std::uint32_t i = 0; i < 3 * triangles; ++i) {
    const std::uint32_t code = reader.get<std::uint16_t>();
    tile.triangles.push_back(highest - code);
    if (code == 0) ++highest;
  }
  EXPECT_EQ(highest, vertices);
  for (auto& edge : tile.edges) {
    const auto count = reader.get<std::uint32_t>();
    for (std::uint32_t i = 0; i < count; ++i)
      edge.push_back(reader.get<std::uint16_t>());
  }
  EXPECT_TRUE(reader.isAtEnd()) << path;
  return tile;
}

class ExportTerrain : public ExportSuite {
 protected:
  Terrain tileOf(const std::string& folder, int zoom, int x, int y) const {
    return decoded(folder_ / (folder + "/" + std::to_string(zoom) + "/" + std::to_string(x) + "/" + std::to_string(y) +
                              ".terrain"));
  }
  ExportOptions terrain(const std::filesystem::path& database, int zoom) const {
    return {.input = database, .output = folder_ / "terrain", .format = ExportFormat::quantizedMesh, .maxLevel = zoom};
  }
};

double longitude(int zoom, int x, int u) {
  return -180.0 + 180.0 / (1 << zoom) * (x + u / 32767.0);
}
double latitude(int zoom, int y, int v) {
  return -90.0 + 180.0 / (1 << zoom) * (y + v / 32767.0);
}

TEST_P(ExportTerrain, HeightsAreTheQuerys) {
  const auto database = hillyDatabase();
  const ExportReport report = exported({.input = database,
                                        .output = folder_ / "terrain",
                                        .format = ExportFormat::quantizedMesh,
                                        .maxLevel = std::nullopt});
  EXPECT_EQ(report.tiles, (std::uint64_t{2} * ((1u << (2 * (report.maxZoom + 1))) - 1)) / 3);
  const auto query = HeightQuery::create(*PyramidReader::open(database));
  const int zoom = report.maxZoom;
  for (int x = 0; x < 2 << zoom; x += 3) {
    for (int y = 0; y < 1 << zoom; y += 2) {
      const Terrain tile = tileOf("terrain", zoom, x, y);
      ASSERT_EQ(tile.u.size(), 65u * 65u);
      const double step_m = (static_cast<double>(tile.max_m) - static_cast<double>(tile.min_m)) / 32767.0;
      EXPECT_LE(step_m, 0.5);
      for (std::size_t i = 0; i < tile.u.size(); i += 13) {
        const auto answer =
            *query->at(geo::directionFromDegrees(latitude(zoom, y, tile.v[i]), longitude(zoom, x, tile.u[i])));
        ASSERT_TRUE(answer.has_value());
        ASSERT_NEAR(tile.height_m(i), answer->height_m, step_m / 2 + 1e-3) << x << " " << y << " " << i;
      }
    }
  }
}

TEST_P(ExportTerrain, NeighboursMeetToTheLastBit) {
  const auto database = hillyDatabase();
  constexpr int kZoom = 2;
  exported(terrain(database, kZoom));
  for (int y = 0; y < 1 << kZoom; ++y) {
    for (int x = 0; x < 2 << kZoom; ++x) {
      const Terrain tile = tileOf("terrain", kZoom, x, y);
      const Terrain east = tileOf("terrain", kZoom, (x + 1) % (2 << kZoom), y);  // around the date line too
      ASSERT_EQ(tile.edges[2].size(), east.edges[0].size());
      const auto heightsAlong = [](const Terrain& t, std::size_t edge) {
        std::map<int, double> heights;
        const bool isUpright = edge == 0 || edge == 2;
        for (const std::uint32_t i : t.edges[edge])
          heights[isUpright ? t.v[i] : t.u[i]] = t.height_m(i);
        return heights;
      };
      EXPECT_EQ(heightsAlong(tile, 2), heightsAlong(east, 0)) << x << " " << y;
      for (const std::uint32_t i : tile.edges[2])
        EXPECT_EQ(tile.u[i], 32767);
      for (const std::uint32_t i : tile.edges[0])
        EXPECT_EQ(tile.u[i], 0);
      if (y + 1 == 1 << kZoom) continue;
      const Terrain north = tileOf("terrain", kZoom, x, y + 1);
      EXPECT_EQ(heightsAlong(tile, 3), heightsAlong(north, 1)) << x << " " << y;
      for (const std::uint32_t i : tile.edges[3])
        EXPECT_EQ(tile.v[i], 32767);
    }
  }
}

TEST_P(ExportTerrain, TrianglesCoverTheTileOnce) {
  exported(terrain(hillyDatabase(), 0));
  const Terrain tile = tileOf("terrain", 0, 1, 0);
  double area = 0.0;
  for (std::size_t t = 0; t < tile.triangles.size(); t += 3) {
    const auto [a, b, c] = std::array{tile.triangles[t], tile.triangles[t + 1], tile.triangles[t + 2]};
    const double twice = static_cast<double>(tile.u[b] - tile.u[a]) * (tile.v[c] - tile.v[a]) -
                         static_cast<double>(tile.u[c] - tile.u[a]) * (tile.v[b] - tile.v[a]);
    ASSERT_GT(twice, 0.0) << "counter-clockwise";
    area += twice / 2.0;
  }
  EXPECT_EQ(area, 32767.0 * 32767.0);
}

TEST_P(ExportTerrain, SpheresAndOcclusionPointsAreSafe) {
  exported(terrain(hillyDatabase(), 3));
  std::mt19937_64 random = geo::seededGenerator();
  const geo::Ellipsoid ellipsoid = geo::earth().ellipsoid;
  const double a = ellipsoid.semiMajorAxis_m();
  const double b = ellipsoid.semiMinorAxis_m();
  const auto scaled = [&](const geo::Vec3& p) { return geo::Vec3{p.x / a, p.y / a, p.z / b}; };
  // Whether the unit sphere hides `point` from `eye`: the line between them runs into it.
  const auto isHidden = [](const geo::Vec3& eye, const geo::Vec3& point) {
    const geo::Vec3 along = point - eye;
    const double t = -geo::dot(eye, along) / geo::dot(along, along);
    if (t <= 0.0 || t >= 1.0) return false;
    const geo::Vec3 nearest = eye + along * t;
    return geo::dot(nearest, nearest) < 1.0;
  };
  std::size_t hidden = 0;
  for (int x = 0; x < 16; x += 3) {
    for (int y = 0; y < 8; ++y) {
      const Terrain tile = tileOf("terrain", 3, x, y);
      std::vector<geo::Vec3> points;
      for (std::size_t i = 0; i < tile.u.size(); i += 7) {
        const auto p = ellipsoid.bodyFromDirection(
            geo::directionFromDegrees(latitude(3, y, tile.v[i]), longitude(3, x, tile.u[i])), tile.height_m(i));
        const geo::Vec3 from = p.m - tile.sphereCentre;
        ASSERT_LE(std::sqrt(geo::dot(from, from)), tile.radius_m + 1e-6);
        points.push_back(scaled(p.m));
      }
      for (int k = 0; k < 60; ++k) {
        const geo::Vec3 eye{geo::uniform(random, -3.0, 3.0), geo::uniform(random, -3.0, 3.0),
                            geo::uniform(random, -3.0, 3.0)};
        if (geo::dot(eye, eye) < 1.01 || !isHidden(eye, tile.occlusion)) continue;
        ++hidden;
        for (const geo::Vec3& p : points) {
          if (geo::dot(p, p) < 1.0) continue;  // below the ellipsoid: that is no occluder there
          ASSERT_TRUE(isHidden(eye, p)) << x << " " << y;
        }
      }
    }
  }
  EXPECT_GT(hidden, 200u);
}

TEST_P(ExportTerrain, LayerJsonNamesTheTilesThatAreThere) {
  writeElevation(folder_ / "line.tif", degreesGrid(170, -10, 190, 10, 200, 200),
                 [](int c, int r) { return 1000.0 + c + r; });
  const auto database = built("line.tdb", (folder_ / "line.tif").string(), Kind::elevation);
  exported(terrain(database, 5));
  std::set<std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / "terrain"))
    if (entry.path().extension() == ".terrain")
      files.insert(std::filesystem::relative(entry.path(), folder_ / "terrain").string());
  EXPECT_TRUE(files.contains("0/0/0.terrain") && files.contains("0/1/0.terrain"));
  EXPECT_FALSE(files.contains("5/32/16.terrain"));
  // Line by line: "available" has one for each zoom.
  std::istringstream json(bytesOf(folder_ / "terrain/layer.json"));
  std::string line;
  while (std::getline(json, line) && line.find("\"available\"") == std::string::npos) {
  }
  std::set<std::string> named;
  for (int zoom = 0; zoom <= 5; ++zoom) {
    std::getline(json, line);
    for (std::size_t at = line.find("\"startX\""); at != std::string::npos; at = line.find("\"startX\"", at + 1)) {
      int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
      ASSERT_EQ(std::sscanf(line.c_str() + at, "\"startX\": %d, \"startY\": %d, \"endX\": %d, \"endY\": %d", &x0, &y0,
                            &x1, &y1),
                4)
          << line;
      for (int x = x0; x <= x1; ++x)
        for (int y = y0; y <= y1; ++y)
          EXPECT_TRUE(
              named.insert(std::to_string(zoom) + "/" + std::to_string(x) + "/" + std::to_string(y) + ".terrain")
                  .second);
    }
  }
  EXPECT_EQ(named, files);
}

TEST_P(ExportTerrain, PicturesAndOtherBodiesAreRefused) {
  EXPECT_FALSE(exportPyramid(terrain(dateLineDatabase(), 1)).has_value());
  const auto mars = exportPyramid(terrain(hillyDatabase(geo::mars()), 1));
  ASSERT_FALSE(mars.has_value());
  EXPECT_NE(mars.error().message.find("geopackage"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(AllTilings, ExportTerrain,
                         ::testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& test) { return std::string(tiling::nameOf(test.param)); });

}  // namespace
}  // namespace tellurion::pyramid::testing
