#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "io/failure.h"
#include "scene/frame.h"
#include "scene/globe_layers.h"
#include "scene/residency.h"
#include "scene/scene_file.h"
#include "scene/select.h"

namespace tellurion::scene {

struct GlobeOptions {
  int workers = 0;           ///< 0: one for each core but one, at least one
  bool regularMesh = false;  ///< every sample of a tile is a vertex: the mode that meshes are compared with
  /// Pictures are compressed on the workers, with a small loss: an eighth of the memory on the GPU and here for those
  /// that are covered all over, a quarter for others. Give RendererOptions::compressedPictures too, and only where
  /// render::readsCompressedPictures().
  bool compressTextures = false;
  std::uint64_t cpuCacheBytes = std::uint64_t{256}
                                << 20;  ///< decoded tiles, meshes and textures; what is drawn is never dropped
  /// How layers of servers are fetched (Globe::open); no cache file: online.db in the cache folder.
  io::ResourceOptions online = {};
};

/// Told while rasters of a scene are built into tile databases: what is being built, and how much of it is done (0..1).
using BuildSink = std::function<void(std::string_view what, double share)>;

/// A planet on screen: keeps the tiles that the view needs, loaded by workers, and says for each view exactly what to
/// draw. Layers whose source is on a network take part once it is open and the first of the coarsest tiles that may be
/// seen has come, or of imagery its overview, and the others as they come; until then the globe is drawn without them.
/// One thread only; owns its workers, and its destruction waits for what they have begun.
class Globe {
 public:
  /// Opens the scene's sources; rasters are built into tile databases in the cache folder first
  /// ($XDG_CACHE_HOME/tellurion, else
  /// ~/.cache/tellurion), which `progress` is told about. A stop asked for meanwhile gives Failure::Code::cancelled,
  /// and the next call goes on with the build.
  static io::Result<std::unique_ptr<Globe>> open(const Scene& scene, const GlobeOptions& options = {},
                                                 const BuildSink& progress = {}, const std::stop_token& stop = {});
  /// From these sources. The scene's own lists of layers are not looked at. Fails when sources that are open do not fit
  /// the scene.
  static io::Result<std::unique_ptr<Globe>> fromLayers(const Scene& scene, GlobeLayers layers,
                                                       const GlobeOptions& options = {});
  ~Globe();

  /// One more imagery layer on top of all others, which joins as late layers do; until it can, all is drawn as it was.
  /// imageryLooks(), imageryNames() and imageryOrder() then have one more, and what they gave before is of no use.
  /// Opens as open() does, so a raster that has to be built into a tile database keeps the caller waiting; a service
  /// does not, and what is wrong with it is told by troubles() and failures(). Fails, and changes nothing, where what
  /// is open does not fit, and for what shows the scene's heights (ImageryLayer::derived without heights of its own).
  io::Result<void> addImagery(const ImageryLayer& layer);
  /// The same from these sources.
  io::Result<void> addImagery(GlobeLayers::Imagery layer);

  Globe(const Globe&) = delete;
  Globe& operator=(const Globe&) = delete;

  const geo::Body& body() const;
  Lighting& lighting();  ///< may be changed at any time; counts from the next update
  std::array<float, 3>& background();
  Air& air();          ///< likewise; the renderer must be ready for it (render::Renderer::prepareAir)
  SkySettings& sky();  ///< likewise (render::Renderer::prepareSky)
  /// How each imagery layer is shown, bottom first. May be changed at any time and counts from the next update: nothing
  /// is loaded again, and the same tiles are drawn, but for layers that become visible or are visible no more: their
  /// finer pictures begin or cease to count.
  std::span<LayerLook> imageryLooks();
  /// For people, a layer each.
  const std::vector<std::string>& imageryNames() const;
  /// In which order the imagery layers lie over each other, bottom first: indices of imageryLooks(), which stay as they
  /// are; the scene's own order at first.
  std::span<const std::uint32_t> imageryOrder() const;
  /// Takes a layer out and puts it back with `place` others below it, at most on top of all. Counts from the next
  /// update: nothing is loaded again and the same tiles are drawn. No effect for a layer that there is not.
  void moveImagery(std::size_t layer, std::size_t place);
  /// Heights above the ellipsoid are drawn, and told by groundHeight_m, this many times as high: 0..100, 1 at first;
  /// what is set must lie in there. May be changed at any time.
  double& exaggeration();
  DebugViews& debugViews();  ///< likewise

  /// The time that layers with time steps show, seconds since 1970-01-01T00:00:00Z: of each the newest step that is not
  /// after it, else its first. Counts from the next update; nothing else is loaded again. A tile keeps its old picture
  /// until the new one is here. The next step in the direction in which the clock was moved last is loaded ahead.
  void setClock(double time_s);
  /// Nothing: of each layer the last.
  std::optional<double> clock() const;

  /// From the next update on the cut stays: tiles are chosen, and loaded, for this view, whatever view is drawn. With
  /// nullopt it follows the eye again.
  void freezeCut(const std::optional<View>& at);
  bool cutIsFrozen() const;

  /// What to draw for this view out of what is loaded, whole at any time; asks the workers for what is missing. Never
  /// blocks. The frame stays valid, and its meshes and pictures alive, until the next call.
  /// With `gpu`, and a clock in the options, loaded tiles that are not there yet replace their parents only as far as
  /// CutOptions::copies_bytes allows, the rest in the next frames; such a frame is not complete. Without, all that is
  /// loaded is drawn.
  const Frame& update(const View& view, const CutOptions& options = {}, const Residency* gpu = nullptr);

  /// Sleeps until something that was asked for has arrived since the last update, or it is time for another for other
  /// reasons, at most for `timeout`. False: no need, or nothing is on its way; then it returns at once.
  bool waitForArrivals(std::chrono::milliseconds timeout);

  /// Height in metres above the ellipsoid, exaggerated as drawn, of the finest loaded ground there, bilinear between
  /// its samples (where there are no data, as GroundLayers fills them); nothing when not even the root tile is loaded.
  std::optional<double> groundHeight_m(const geo::Direction& d) const;

  /// What could not be loaded since the globe was opened, and never will be: the first of them
  /// (FrameStatistics::failures counts all), each once, though many tiles may lack the same image. The ground is drawn
  /// from coarser data there, or without the layer.
  const std::vector<io::Failure>& failures() const;
  /// Those of failures() that change the last frame: ground without what they are of is drawn. The others were asked
  /// for on the way to it, or are beside the picture. And layers of which the server has nothing at all.
  std::vector<io::Failure> failuresInFrame() const;
  /// Of each layer that FrameStatistics::layersComing counts: which it is, where it comes from, and what to do.
  std::vector<io::Failure> lateLayers() const;
  /// What cannot be loaded now and is tried again: servers in trouble, and layers that cannot be opened yet.
  std::vector<io::Failure> troubles() const;

 private:
  struct State;
  explicit Globe(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tellurion::scene
