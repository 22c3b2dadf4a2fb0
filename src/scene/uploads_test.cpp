// Copies to the GPU spread over frames: what Globe makes of what a Residency tells.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <list>
#include <map>
#include <set>

#include "geo/body.h"
#include "scene/globe.h"
#include "scene/procedural_source_test.h"
#include "scene/view_from_test.h"

namespace tellurion::scene {
namespace {

using namespace std::chrono_literals;
using tiling::TileId;

constexpr std::uint64_t kTile = 1110;  ///< bytes of one with its pictures

/// A GPU without pictures: holds meshes, by serial, up to `capacity` that are not drawn; those drawn longest ago leave.
class FakeGpu final : public Residency {
 public:
  std::size_t capacity = 1u << 20u;

  std::uint64_t missingBytes(const TerrainMesh& mesh) const override { return bytesFor(mesh.serial, 1000); }
  std::uint64_t missingColourBytes(const TextureImage& image) const override {
    return bytesFor(kPicture + image.serial, 100);
  }
  std::uint64_t missingReliefBytes(const TextureImage& image) const override {
    return bytesFor(2 * kPicture + image.serial, 10);
  }
  std::uint64_t departures() const override { return departures_; }
  std::uint64_t arrivals() const override { return now_; }

  void clear() {
    held_.clear();
    ++departures_;
  }

  /// Copies what the frame draws. How many bytes that took.
  std::uint64_t draw(const Frame& frame) {
    ++now_;
    std::uint64_t copied = 0;
    const auto bring = [&](std::uint64_t name, std::uint64_t bytes) {
      copied += bytesFor(name, bytes);
      held_[name] = now_;
    };
    for (const DrawnTile& tile : frame.tiles) {
      bring(tile.mesh->serial, 1000);
      for (std::size_t i = tile.firstPicture; i < tile.firstPicture + tile.pictureCount; ++i)
        bring(kPicture + frame.pictures[i].image->serial, 100);
      if (tile.relief) bring(2 * kPicture + tile.relief->serial, 10);
    }
    const std::uint64_t drawn = copied;
    for (const DrawnTile& tile : frame.soon) {
      if (copied + kTile > drawn + frame.soonCopies_bytes) break;
      bring(tile.mesh->serial, 1000);
      for (std::size_t i = tile.firstPicture; i < tile.firstPicture + tile.pictureCount; ++i)
        bring(kPicture + frame.pictures[i].image->serial, 100);
      if (tile.relief) bring(2 * kPicture + tile.relief->serial, 10);
    }
    while (held_.size() > capacity) {
      const auto oldest = std::min_element(held_.begin(), held_.end(),
                                           [](const auto& a, const auto& b) { return a.second < b.second; });
      if (oldest->second == now_) break;
      held_.erase(oldest);
      ++departures_;
    }
    return copied;
  }

 private:
  static constexpr std::uint64_t kPicture = std::uint64_t{1} << 60;
  std::uint64_t bytesFor(std::uint64_t name, std::uint64_t bytes) const { return held_.contains(name) ? 0 : bytes; }

  std::map<std::uint64_t, std::uint64_t> held_;  ///< and when it was drawn last
  std::uint64_t now_ = 0;
  std::uint64_t departures_ = 1;
};

std::set<TileId> tilesOf(const Frame& frame) {
  std::set<TileId> out;
  for (const DrawnTile& tile : frame.tiles)
    out.insert(tile.id);
  return out;
}

/// Everything that `whole` draws is drawn once: by the tile itself, one above it, or ones below it.
bool covers(const std::set<TileId>& drawn, const std::set<TileId>& whole) {
  return std::all_of(whole.begin(), whole.end(), [&](const TileId& id) {
    int above = 0;
    for (int level = 0; level <= id.level; ++level)
      above += drawn.contains(id.ancestor(level)) ? 1 : 0;
    const bool below = std::any_of(drawn.begin(), drawn.end(),
                                   [&](const TileId& d) { return d.level > id.level && d.ancestor(id.level) == id; });
    return above == 1 ? !below : above == 0 && below;
  });
}

class Uploads : public testing::Test {
 protected:
  Uploads() {
    Scene scene;
    const auto elevation = std::make_shared<ProceduralSource>(raster::Kind::elevation, scene.tiling, 8);
    globe = Globe::fromLayers(scene, {.elevation = {elevation}, .imagery = {}}, {.cpuCacheBytes = 1u << 30u}).value();
  }

  /// Loads it all, with nothing on the GPU.
  std::set<TileId> load(const View& view) {
    const auto end = std::chrono::steady_clock::now() + 240s;
    CutOptions clocked = fine;  // what is out of view too
    for (clocked.time_s = 0.0; !globe->update(view, clocked).complete && std::chrono::steady_clock::now() < end;
         *clocked.time_s += 1.0)
      globe->waitForArrivals(100ms);
    const Frame& frame = globe->update(view, fine);
    EXPECT_TRUE(frame.complete);
    return tilesOf(frame);
  }

  CutOptions fine{.tolerance_px = 0.06};
  CutOptions with(std::uint64_t budget) const {
    CutOptions options = fine;
    options.copies_bytes = budget;
    options.time_s = 0.0;
    return options;
  }

  std::unique_ptr<Globe> globe;
  FakeGpu gpu;
};

TEST_F(Uploads, AreWithinTheBudgetOfAFrameAndThePictureIsWholeMeanwhile) {
  const View view = viewFrom(30, 15, 40e3, 0, -40);
  const auto whole = load(view);
  ASSERT_GT(whole.size(), 100u);
  for (const std::uint64_t budget : {std::uint64_t{1}, 4 * kTile, 20 * kTile}) {
    gpu.clear();
    globe->update(view);  // forgets what was drawn
    CutOptions options = with(budget);
    int frames = 0;
    while (frames < 2000) {
      *options.time_s += 1.0;
      const Frame& frame = globe->update(view, options, &gpu);
      const auto drawn = tilesOf(frame);
      const std::uint64_t copied = gpu.draw(frame);
      ASSERT_TRUE(covers(drawn, whole)) << frames;
      if (frames == 0) {
        // The roots come at once.
        EXPECT_LE(copied, std::max(budget + 4 * kTile, 6 * kTile));
      } else {
        // One split goes in, however small the budget.
        EXPECT_LE(copied, std::max(budget, 4 * kTile)) << frames;
      }
      if (frame.statistics.tilesHeldBack > 0) {
        EXPECT_FALSE(frame.complete) << frames;
        EXPECT_GT(copied, 0u) << frames;
      }
      ++frames;
      if (frame.complete) break;
    }
    EXPECT_EQ(tilesOf(globe->update(view, options, &gpu)), whole);
    EXPECT_GE(static_cast<std::uint64_t>(frames) * std::max(budget, 4 * kTile) + 8 * kTile, whole.size() * kTile);
    std::printf("budget %.1f tiles: %zu tiles in %d frames\n", double(budget) / kTile, whole.size(), frames);
  }
}

TEST_F(Uploads, WhatIsOnTheGpuIsDrawnAtOnceAfterATurn) {
  const View there = viewFrom(30, 15, 40e3, 0, -40);
  const View away = viewFrom(30, 15, 40e3, 180, -40);
  const auto whole = load(there);
  load(away);
  CutOptions options = with(8 * kTile);
  for (const View* view : {&there, &away}) {
    bool complete = false;
    for (int i = 0; i < 200 && !complete; ++i) {
      *options.time_s += 1.0;
      const Frame& frame = globe->update(*view, options, &gpu);
      gpu.draw(frame);
      complete = frame.complete;
    }
    EXPECT_TRUE(complete);
  }
  *options.time_s += 1.0;
  const Frame& frame = globe->update(there, options, &gpu);
  EXPECT_TRUE(frame.complete);
  EXPECT_EQ(tilesOf(frame), whole);
}

/// Turns, climbs and dives, with a memory of the last frame, on a GPU that holds little more than one view.
TEST_F(Uploads, AFlightOnALittleGpuStaysWithinTheBudgetAndEndsComplete) {
  constexpr int kLast = 120;
  fine.tolerance_px = 0.3;
  const auto viewAt = [](int i) {
    const double t = static_cast<double>(i) / kLast;
    return viewFrom(30, 15, 40e3 * std::exp(4.0 * std::pow(std::sin(t * geo::kPi), 2)), 720.0 * t, -40 - 20 * t);
  };
  for (int i = 0; i <= kLast; i += 2)
    load(viewAt(i));
  const View last = viewAt(kLast);
  const auto whole = load(last);
  for (const std::size_t capacity : {std::size_t{0}, 2 * whole.size(), 8 * whole.size()}) {
    gpu.clear();
    gpu.capacity = capacity;
    CutOptions options = with(16 * kTile);
    std::uint64_t most = 0, sum = 0;
    int beyond = 0;
    bool complete = false;
    for (int i = 0; i < 1200 && !complete; ++i) {
      options.time_s = i / 60.0;
      const View view = viewAt(std::min(i, kLast));
      const Frame& frame = globe->update(view, options, &gpu);
      const auto drawn = tilesOf(frame);
      for (const TileId& id : drawn) {
        for (int level = 0; level < id.level; ++level)
          ASSERT_FALSE(drawn.contains(id.ancestor(level)));
      }
      const std::uint64_t copied = gpu.draw(frame);
      if (i > 0) {
        most = std::max(most, copied);
        sum += copied;
        beyond += copied > options.copies_bytes ? 1 : 0;
      }
      complete = i >= kLast && frame.complete;
    }
    EXPECT_TRUE(complete);
    EXPECT_EQ(tilesOf(globe->update(last, options, &gpu)), whole);
    // Beside finer ground a tile or two come in any case; and at six degrees a frame what was just out of the picture
    // comes in faster than it can be copied before.
    EXPECT_LE(most, 3 * options.copies_bytes);
    std::printf("GPU of %zu, view of %zu: most in a frame %.1f tiles, all %.1f, over the budget in %d frames\n",
                capacity, 3 * whole.size(), double(most) / kTile, double(sum) / kTile, beyond);
  }
}

}  // namespace
}  // namespace tellurion::scene
