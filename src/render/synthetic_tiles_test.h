#pragma once

// Frames made by hand for the tests of this room: no data, no cut, no workers. Test code only.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "geo/ellipsoid.h"
#include "render/context.h"
#include "render/renderer.h"
#include "scene/frame.h"

namespace tellurion::render::synthetic {

/// Metres above the ellipsoid at a direction.
using HeightFunction = std::function<double(const geo::Direction&)>;

inline std::uint64_t nextSerial() {
  static std::uint64_t last = std::uint64_t{1} << 40u;
  return ++last;
}

/// A point on the grid of 2^-10 m, where mesh origins and vertices lie exactly.
inline geo::BodyPosition onGrid(const geo::BodyPosition& p) {
  const auto snap = [](double m) { return std::round(m * 1024.0) / 1024.0; };
  return {{snap(p.m.x), snap(p.m.y), snap(p.m.z)}};
}

/// A regular grid of `cells` a side as a mesh with its edge strips, built the plainest way.
class GridMesh {
 public:
  GridMesh(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const tiling::TileId& id, int cells,
           const HeightFunction& height)
      : cells_(cells), mesh_(std::make_shared<scene::TerrainMesh>()) {
    mesh_->serial = nextSerial();
    const auto place = [&](double s, double t) {
      const geo::Direction d = tiling.direction(tiling::rootPointIn(id, s, t));
      return std::pair(d, onGrid(ellipsoid.bodyFromDirection(d, height ? height(d) : 0.0)));
    };
    mesh_->origin = place(0.5, 0.5).second;
    for (int row = 0; row <= cells; ++row) {
      for (int col = 0; col <= cells; ++col) {
        const double s = static_cast<double>(col) / cells;
        const double t = static_cast<double>(row) / cells;
        const auto [up, point] = place(s, t);
        mesh_->vertices.push_back(vertex(up, point - mesh_->origin, s, t));
      }
    }
    addInterior();
    for (const tiling::Edge edge : tiling::kEdges)
      mesh_->fineEdge[static_cast<std::size_t>(edge)] = strip(edge, 1);
    for (const tiling::Edge edge : tiling::kEdges)
      mesh_->coarseEdge[static_cast<std::size_t>(edge)] = strip(edge, 2);
  }

  std::shared_ptr<const scene::TerrainMesh> take() { return mesh_; }

 private:
  static scene::TerrainVertex vertex(const geo::Direction& up, const geo::Vec3& offset, double s, double t) {
    const auto signedShort = [](double v) { return static_cast<std::int16_t>(std::lround(v * 32767.0)); };
    scene::TerrainVertex v;
    v.position_tile = geo::Vec3f(offset);
    v.up_body = {signedShort(up.n.x), signedShort(up.n.y), signedShort(up.n.z)};
    v.s = static_cast<std::uint16_t>(std::lround(s * scene::kPlaceUnits));
    v.t = static_cast<std::uint16_t>(std::lround(t * scene::kPlaceUnits));
    return v;
  }

  std::uint16_t at(int col, int row) const { return static_cast<std::uint16_t>(row * (cells_ + 1) + col); }

  void triangle(std::uint16_t a, std::uint16_t b, std::uint16_t c) {
    mesh_->indices.insert(mesh_->indices.end(), {a, b, c});
  }

  void addInterior() {
    for (int row = 1; row < cells_ - 1; ++row) {
      for (int col = 1; col < cells_ - 1; ++col) {
        triangle(at(col, row), at(col, row + 1), at(col + 1, row));
        triangle(at(col + 1, row), at(col, row + 1), at(col + 1, row + 1));
      }
    }
    mesh_->interior = {0, static_cast<std::uint32_t>(mesh_->indices.size())};
  }

  /// The i-th vertex along an edge, clockwise from outside, `depth` rows inwards.
  std::uint16_t along(tiling::Edge edge, int i, int depth) const {
    const int n = cells_;
    switch (edge) {
      case tiling::Edge::top:
        return at(i, depth);
      case tiling::Edge::right:
        return at(n - depth, i);
      case tiling::Edge::bottom:
        return at(n - i, n - depth);
      case tiling::Edge::left:
        return at(depth, n - i);
    }
    return 0;
  }

  /// Fills between every `step`-th vertex of the edge and the first chain inside.
  scene::IndexRange strip(tiling::Edge edge, int step) {
    const auto first = static_cast<std::uint32_t>(mesh_->indices.size());
    int outer = 0;
    int inner = 1;
    while (outer < cells_ || inner < cells_ - 1) {
      const bool advanceOuter = inner == cells_ - 1 || (outer < cells_ && outer + step <= inner + 1);
      if (advanceOuter) {
        triangle(along(edge, outer, 0), along(edge, inner, 1), along(edge, outer + step, 0));
        outer += step;
      } else {
        triangle(along(edge, outer, 0), along(edge, inner, 1), along(edge, inner + 1, 1));
        ++inner;
      }
    }
    return {first, static_cast<std::uint32_t>(mesh_->indices.size()) - first};
  }

  int cells_;
  std::shared_ptr<scene::TerrainMesh> mesh_;
};

inline scene::DrawnTile gridTile(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid,
                                 const tiling::TileId& id, int cells, const HeightFunction& height = {}) {
  scene::DrawnTile tile;
  tile.id = id;
  tile.mesh = GridMesh(tiling, ellipsoid, id, cells, height).take();
  return tile;
}

/// All tiles of a level.
inline std::vector<scene::DrawnTile> wholeBody(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, int level,
                                               int cells, const HeightFunction& height = {}) {
  std::vector<scene::DrawnTile> tiles;
  const auto side = 1u << static_cast<unsigned>(level);
  for (int root = 0; root < tiling.rootCount(); ++root) {
    for (std::uint32_t y = 0; y < side; ++y) {
      for (std::uint32_t x = 0; x < side; ++x) {
        const tiling::TileId id{static_cast<std::uint8_t>(level), static_cast<std::uint8_t>(root), x, y};
        tiles.push_back(gridTile(tiling, ellipsoid, id, cells, height));
      }
    }
  }
  return tiles;
}

using Image = std::shared_ptr<const scene::TextureImage>;

/// Gives a tile of the frame its one picture, of a layer that is shown as it is.
inline void paint(scene::Frame& frame, scene::DrawnTile& tile, Image image, const scene::TextureWindow& window = {}) {
  if (frame.looks.empty()) frame.looks.emplace_back();
  tile.firstPicture = static_cast<std::uint32_t>(frame.pictures.size());
  tile.pictureCount = 1;
  frame.pictures.push_back({.image = std::move(image), .window = window, .layer = 0});
}

/// A tile with its picture, before there is a frame.
struct PaintedTile {
  scene::DrawnTile tile;
  Image colour = {};
  scene::TextureWindow colourWindow = {};
};

inline void setTiles(scene::Frame& frame, const std::vector<PaintedTile>& tiles) {
  frame.tiles.clear();
  frame.pictures.clear();
  for (const PaintedTile& painted : tiles) {
    frame.tiles.push_back(painted.tile);
    if (painted.colour) paint(frame, frame.tiles.back(), painted.colour, painted.colourWindow);
  }
}

/// As it comes from a worker, without further mip levels; not multiplied with its coverage here.
inline Image imageOf(raster::Raster<raster::Rgba8> picture) {
  auto image = std::make_shared<scene::TextureImage>();
  image->serial = nextSerial();
  image->isOpaque = std::ranges::all_of(picture.samples, [](raster::Rgba8 p) { return p.a == 255; });
  image->mips.push_back(std::move(picture));
  return image;
}

/// One colour all over, without further mip levels.
inline Image plainImage(raster::Rgba8 colour, int size = 4) {
  return imageOf(raster::Raster<raster::Rgba8>(size, size, colour));
}

inline scene::View viewAt(const geo::Ellipsoid& ellipsoid, double lat, double lon, double height_m, double heading,
                          double pitch, scene::Viewport viewport, double fov = 45.0) {
  const scene::Camera camera{
      .position = {.lat = geo::Angle::degrees(lat), .lon = geo::Angle::degrees(lon), .height_m = height_m},
      .heading = geo::Angle::degrees(heading),
      .pitch = geo::Angle::degrees(pitch),
      .roll = geo::Angle::degrees(0.0)};
  return scene::viewOf(camera, ellipsoid, geo::Angle::degrees(fov), viewport);
}

/// A context and a renderer for a test; skips the test where there is no OpenGL.
class GlTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { start(); }

  void SetUp() override {
    if (!context()) GTEST_SKIP() << "no OpenGL here: " << io::describe(context().error());
  }

  static io::Result<HeadlessContext>& context() { return start(); }

  static Renderer makeRenderer(const RendererOptions& options = {}) {
    auto renderer = Renderer::create(options);
    if (!renderer) ADD_FAILURE() << io::describe(renderer.error());
    return std::move(*renderer);
  }

  static RenderTarget makeTarget(scene::Viewport size) {
    auto target = RenderTarget::create(size);
    if (!target) ADD_FAILURE() << io::describe(target.error());
    return std::move(*target);
  }

 private:
  static io::Result<HeadlessContext>& start() {
    static io::Result<HeadlessContext> context = HeadlessContext::create();
    return context;
  }
};

}  // namespace tellurion::render::synthetic
