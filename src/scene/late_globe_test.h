#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "geo/body.h"
#include "scene/globe.h"
#include "scene/remote_source_test.h"
#include "scene/view_from_test.h"

namespace tellurion::scene {

inline constexpr Viewport kViewport{.width = 640, .height = 480};

/// Some way down to hills, oblique.
inline View hillsView() {
  return viewFrom(46.6, 8.0, 60e3, 20, -35, kViewport);
}

/// A planet and its server.
struct Remote {
  explicit Remote(raster::Kind kind, tiling::Scheme scheme = tiling::Scheme::cube, int depth = 6)
      : planet(std::make_shared<ProceduralSource>(kind, scheme, depth)),
        server(std::make_shared<FakeServer>()),
        source(std::make_shared<RemoteSource>(planet, server)) {}
  std::shared_ptr<ProceduralSource> planet;
  std::shared_ptr<FakeServer> server;
  std::shared_ptr<RemoteSource> source;
};

/// With room for all, so that nothing has to be asked for again.
inline GlobeOptions roomy() {
  return {.workers = 2, .cpuCacheBytes = std::uint64_t{4} << 30};
}

inline std::unique_ptr<Globe> globeOf(GlobeLayers layers, tiling::Scheme scheme = tiling::Scheme::cube,
                                      const GlobeOptions& options = roomy()) {
  Scene scene;
  scene.tiling = scheme;
  return Globe::fromLayers(scene, std::move(layers), options).value();
}

/// Places all over the picture that see the ellipsoid.
inline std::vector<geo::Direction> placesIn(const View& view, int columns = 24, int rows = 18) {
  const geo::Ellipsoid earth = geo::earth().ellipsoid;
  const geo::Mat3 bodyFromView = glm::transpose(view.viewFromBody);
  const double y = std::tan(view.verticalFov.radians() / 2);
  const double x = y * view.viewport.width / view.viewport.height;
  std::vector<geo::Direction> out;
  for (int row = 0; row < rows; ++row) {
    for (int col = 0; col < columns; ++col) {
      const geo::Vec3 sight =
          bodyFromView * geo::Vec3(x * (2.0 * (col + 0.5) / columns - 1.0), y * (1.0 - 2.0 * (row + 0.5) / rows), -1.0);
      if (const auto hit = earth.intersect({view.eye, sight}))
        out.push_back(earth.directionFromBody(view.eye + sight * *hit));
    }
  }
  return out;
}

/// Every place is on exactly one drawn tile. The lowest edge of mountains beyond the horizon is left out by taking only
/// views from above.
inline void expectWhole(const Frame& frame, const tiling::Tiling& tiling, const std::vector<geo::Direction>& places) {
  std::set<tiling::TileId> drawn;
  for (const DrawnTile& tile : frame.tiles) {
    ASSERT_TRUE(drawn.insert(tile.id).second);
    ASSERT_TRUE(tile.mesh);
  }
  for (const geo::Direction& d : places) {
    int covers = 0;
    const tiling::TileId deepest = tiling.tileAt(d, 20);
    for (int level = 0; level <= 20; ++level)
      covers += drawn.count(deepest.ancestor(level)) != 0 ? 1 : 0;
    ASSERT_EQ(covers, 1);
  }
}

/// Updates, each server answering so many between two frames, until the frame is complete.
inline const Frame& completed(Globe& globe, const View& view, const std::vector<std::shared_ptr<FakeServer>>& servers,
                              int answers = 1000, const CutOptions& options = {}) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(240);
  const Frame* frame = &globe.update(view, options);
  while (!frame->complete && std::chrono::steady_clock::now() < end) {
    for (const auto& server : servers)
      server->serve(answers);
    globe.waitForArrivals(std::chrono::milliseconds(20));
    frame = &globe.update(view, options);
  }
  EXPECT_TRUE(frame->complete) << frame->statistics.tilesWanted << " wanted, " << frame->statistics.layersComing
                               << " layers coming";
  return *frame;
}

/// Updates for some frames, whatever comes.
inline const Frame& passed(Globe& globe, const View& view, int frames = 30, const CutOptions& options = {}) {
  const Frame* frame = nullptr;
  for (int i = 0; i < frames; ++i) {
    frame = &globe.update(view, options);
    globe.waitForArrivals(std::chrono::milliseconds(5));
  }
  return *frame;
}

/// Updates until it comes true, for as long as a test waits; servers do nothing meanwhile.
inline bool comesTrue(Globe& globe, const View& view, const std::function<bool(const Frame&)>& condition) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(240);
  while (std::chrono::steady_clock::now() < end) {
    if (condition(globe.update(view))) return true;
    globe.waitForArrivals(std::chrono::milliseconds(10));
  }
  return false;
}

inline bool showsPictures(const Frame& frame) {
  return std::ranges::any_of(frame.tiles, [](const DrawnTile& tile) { return tile.pictureCount > 0; });
}

/// What is drawn, told apart by tile and by the bytes of its ground and of its colour.
inline std::map<tiling::TileId, std::uint64_t> pictureOf(const Frame& frame) {
  std::map<tiling::TileId, std::uint64_t> out;
  for (const DrawnTile& tile : frame.tiles) {
    std::uint64_t hash = 1469598103934665603u;
    const auto mix = [&](const void* data, std::size_t bytes) {
      for (std::size_t i = 0; i < bytes; ++i)
        hash = (hash ^ static_cast<const unsigned char*>(data)[i]) * 1099511628211u;
    };
    mix(tile.mesh->vertices.data(), tile.mesh->vertices.size() * sizeof(TerrainVertex));
    for (std::uint32_t i = tile.firstPicture; i < tile.firstPicture + tile.pictureCount; ++i) {
      const auto& finest = frame.pictures[i].image->mips.front().samples;
      mix(finest.data(), finest.size() * sizeof(finest.front()));
    }
    out[tile.id] = hash;
  }
  return out;
}

/// Nothing was asked for twice but what was turned away from before it was used.
inline void expectAskedOnce(const FakeServer& server) {
  int again = 0;
  for (const auto& [id, count] : server.asked())
    again += count - 1;
  EXPECT_LE(again, server.cancelled());
}

}  // namespace tellurion::scene
