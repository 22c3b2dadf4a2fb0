#include "scene/source_openers.h"

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <string>

#include "scene/late_globe_test.h"

namespace tellurion::scene {
namespace {

using namespace std::chrono_literals;
using tiling::Scheme;

/// Servers by name, some of which hang until the test lets them go; counts who is asked at a time.
class Servers {
 public:
  /// In any case before what opens them ends, which waits for its threads.
  class LetGo {
   public:
    explicit LetGo(Servers& servers) : servers_(servers) {}
    ~LetGo() { servers_.letGo(); }
    LetGo(const LetGo&) = delete;
    LetGo& operator=(const LetGo&) = delete;

   private:
    Servers& servers_;
  };

  LayerSource source(const std::string& server, const std::string& what, LayerSource::Pointer opened) {
    return {[this, server, opened]() -> io::Result<LayerSource::Pointer> {
              std::unique_lock lock(mutex_);
              Count& count = counts_[server];
              ++count.asked;
              count.most = std::max(count.most, ++count.now);
              changed_.wait(lock, [&] { return isLetGo_ || server.find("hangs") == server.npos; });
              --count.now;
              return opened;
            },
            server + what};
  }
  int most(const std::string& server) {
    const std::lock_guard lock(mutex_);
    return counts_[server].most;
  }
  int asked(const std::string& server) {
    const std::lock_guard lock(mutex_);
    return counts_[server].asked;
  }
  void letGo() {
    const std::lock_guard lock(mutex_);
    isLetGo_ = true;
    changed_.notify_all();
  }

 private:
  struct Count {
    int now = 0, most = 0, asked = 0;
  };
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, Count> counts_;
  bool isLetGo_ = false;
};

LayerSource::Pointer imagery(int depth = 2) {
  return std::make_shared<ProceduralSource>(raster::Kind::imagery, Scheme::cube, depth);
}

const std::string kHangs = "http://hangs";
const std::string kWell = "https://well:8080";

/// What is let go of keeps its place until its thread is free again, and no other server's.
TEST(SourceOpeners, areTwoAServerWhateverIsLetGoOf) {
  Servers servers;
  Doorbell bell;
  SourceOpeners openers(3, bell);
  const Servers::LetGo atTheEnd(servers);
  for (int i = 0; i < 2; ++i) {
    const LayerSource each = servers.source(kHangs, "/wms?layer=" + std::to_string(i), imagery());
    ASSERT_TRUE(openers.mayOpen(each));
    openers.open(each);
  }
  for (const char* path : {"", "/", "/other?a=b", "?x", "#y"})
    EXPECT_FALSE(openers.mayOpen(servers.source(kHangs, path, imagery()))) << path;
  for (int i = 0; i < 10; ++i) {
    const LayerSource each = servers.source(kWell, "/" + std::to_string(i), imagery());
    ASSERT_TRUE(openers.mayOpen(each));
    const auto opening = openers.open(each);
    const auto end = std::chrono::steady_clock::now() + 10s;
    std::optional<io::Result<LayerSource::Pointer>> source;
    while (!(source = opening->take()) && std::chrono::steady_clock::now() < end) {
      bell.wait(100ms);
      bell.quiet();
    }
    ASSERT_TRUE(source && *source);
  }
  EXPECT_FALSE(openers.mayOpen(servers.source(kHangs, "/", imagery())));
  servers.letGo();
  const auto end = std::chrono::steady_clock::now() + 10s;
  while (!openers.mayOpen(servers.source(kHangs, "/", imagery())) && std::chrono::steady_clock::now() < end)
    bell.wait(10ms);
  EXPECT_TRUE(openers.mayOpen(servers.source(kHangs, "/", imagery())));
}

/// The clock runs over steps of a server that hangs, beside layers of it and steps and layers of one that is well.
TEST(SourceOpeners, ofLayersAndOfTheirTimeStepsHaveOneRule) {
  constexpr int kSteps = 12;
  Servers servers;
  const auto steps = [&](const std::string& server) {
    GlobeLayers::Imagery layer;
    layer.steps.push_back({.time_s = 0.0, .source = imagery()});
    for (int i = 1; i < kSteps; ++i)
      layer.steps.push_back(
          {.time_s = i * 100.0, .source = servers.source(server, "/step" + std::to_string(i), imagery())});
    return layer;
  };
  GlobeLayers layers;
  for (int i = 0; i < 3; ++i) {
    layers.imagery.push_back(steps(kHangs));
    layers.imagery.push_back({.source = servers.source(kHangs, "/layer" + std::to_string(i), imagery())});
  }
  layers.imagery.push_back(steps(kWell));
  layers.imagery.push_back({.source = servers.source(kWell, "/layer", imagery())});
  Scene scene;
  scene.clock.start_s = 0.0;
  const auto globe = Globe::fromLayers(scene, std::move(layers), roomy()).value();
  const Servers::LetGo atTheEnd(servers);
  const View view = viewFrom(20.0, 40.0, 1.5e6, 0, -90, kViewport);
  const auto showsSoMany = [&](std::uint32_t count) {
    return comesTrue(*globe, view, [&](const Frame& frame) {
      return !frame.tiles.empty() &&
             std::ranges::all_of(frame.tiles, [&](const DrawnTile& tile) { return tile.pictureCount == count; });
    });
  };
  // Three steps of what hangs and one of what is well are of this machine, and the layer that is well.
  EXPECT_TRUE(showsSoMany(5));
  for (int i = 1; i < kSteps; ++i) {
    globe->setClock(i * 100.0);
    EXPECT_TRUE(comesTrue(*globe, view, [&](const Frame&) { return servers.asked(kWell) > i; })) << "step " << i;
  }
  EXPECT_EQ(servers.most(kHangs), 2);
  EXPECT_LE(servers.most(kWell), 2);
}

}  // namespace
}  // namespace tellurion::scene
