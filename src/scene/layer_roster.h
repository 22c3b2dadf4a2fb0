#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "scene/globe_layers.h"
#include "scene/layer_series.h"
#include "scene/scene_file.h"
#include "scene/source_openers.h"
#include "scene/tile_content.h"
#include "scene/tile_fetching.h"

namespace tellurion::scene {

struct RosterEntry;

/// Which layers of a scene take part: those of this machine from the start, those on a server from when they are open
/// and the data of one root tile that may be seen are here, or of imagery its overview (TileSource::overview). Of
/// elevation only the roots that are here take part: when more of them are, the layer joins anew. So what is drawn
/// never waits for a server. One thread only; opens sources on threads of its own.
class LayerRoster {
 public:
  using Clock = std::chrono::steady_clock;

  /// Fails when sources that are open do not fit the scene or each other. budgetBytes: for all decoded tiles. The
  /// fetches and the bell must outlive it.
  static io::Result<std::unique_ptr<LayerRoster>> create(const Scene& scene, GlobeLayers layers,
                                                         std::uint64_t budgetBytes, TileFetches& fetches,
                                                         Doorbell& bell);
  /// One more layer of imagery, which takes part once it can, with a share of the budget that is as large as the
  /// others'. Fails, and changes nothing, when sources of it that are open do not fit.
  io::Result<void> addImagery(GlobeLayers::Imagery layer);
  ~LayerRoster();
  LayerRoster(const LayerRoster&) = delete;
  LayerRoster& operator=(const LayerRoster&) = delete;

  /// Takes in what has been opened or has come, and opens again what failed. rootShares: Selection's, as far as there
  /// is one: roots with the largest come first. isPending: what maker() made the last time is not drawn yet; then more
  /// roots of a layer that it knows are no reason for another, unless they are all. True: more may take part than
  /// maker() told the last time.
  bool advance(Clock::time_point now, std::span<const double> rootShares, bool isPending);
  /// A source that failed is to be opened again: advance() has something to do.
  bool isDue(Clock::time_point now) const;
  /// What maker() made the last time waits for data of these: layers of it that are not shown yet are left out for a
  /// while, those that are shown with fewer roots go back to them. False: no layer would join without them, so nothing
  /// was done; else maker() is to be asked again.
  bool setAside(std::span<const LayerTiles* const> waitedFor, Clock::time_point now);
  /// What maker() made the last time is drawn from now on.
  void isShown();
  /// What makes contents of all layers that may take part now; the others are left out.
  ContentMaker maker(bool regularMesh, bool compressTextures);
  /// Of all elevation that maker() told: samples of parents are samples of their children.
  bool groundIsNested() const;
  /// The time that layers with time steps show; forwards: which way it goes.
  void setClock(double time_s, bool forwards);
  /// The steps that come next in the direction of the clock, as far as they are open.
  std::vector<std::shared_ptr<LayerTiles>> upcoming() const;
  /// Layers whose step of the clock is not open yet.
  int stepsComing() const;
  /// Roots of what maker() told have been made, so their data may go.
  void rootsAreMade();

  /// Layers that maker() does not know yet, or not all roots of, and that may still come.
  int coming() const;
  /// What of them is waited for, a sentence each: which layer, where it comes from, what to do.
  std::vector<io::Failure> lateLayers() const;
  std::uint64_t bytes() const;  ///< of decoded tiles
  LoadLedger& ledger() { return *ledger_; }
  /// Layers that cannot be opened now, and why; they are tried again.
  std::vector<io::Failure> troubles() const;
  /// What is wrong with layers as a whole that take part.
  std::vector<io::Failure> complaints() const;

 private:
  using Entry = RosterEntry;
  LayerRoster(const Scene& scene, TileFetches& fetches, Doorbell& bell);
  Entry& add(raster::Kind kind, LayerSource source, std::size_t layer);
  std::optional<io::Failure> take(raster::Kind kind, LayerSource source, std::size_t layer);
  void layOut(GlobeLayers::Imagery& layer);
  std::size_t sourcesToOpen() const;
  std::optional<io::Failure> takeImagery(GlobeLayers::Imagery layer, std::size_t index);
  std::shared_ptr<LayerSeries> seriesOf(std::vector<TimedSource> steps, std::size_t first, std::size_t layer);
  void openFirstStep(Entry& entry, const GlobeLayers::Imagery& layer);
  int cellsOf(const Entry& entry) const;
  void takeOpened(Entry& entry, io::Result<LayerSource::Pointer> source, Clock::time_point now,
                  std::span<const double> rootShares);
  bool mayOpen(const Entry& entry, Clock::time_point now) const;
  void begin(Entry& entry, Clock::time_point now, std::span<const double> rootShares);
  void fetchRoots(Entry& entry, std::span<const double> rootShares);
  void join(Entry& entry, ColourLayers::Layer& layer);
  void hurryRoots(Entry& entry, std::span<const double> rootShares);
  void fetchOverview(Entry& entry);
  bool hasAllRoots(const Entry& entry) const;
  bool isOf(const Entry& entry, const LayerTiles* tiles) const;

  tiling::Tiling tiling_;
  geo::Body body_;
  TileFetches& fetches_;
  Doorbell& bell_;
  double time_s_;         ///< of the clock
  bool forwards_ = true;  ///< which way it goes
  std::shared_ptr<LoadLedger> ledger_;
  std::uint64_t layerBudgetBytes_ = 0;
  int cells_ = raster::kElevationCells;
  struct ImageryLayout {
    int pixels = raster::kImageryPixels;  ///< a side of a tile, of all data sets of the layer
    bool isStrength = false;
    std::shared_ptr<LayerSeries> series;  ///< of a layer that follows the clock
  };
  std::vector<ImageryLayout> layout_;  ///< an imagery layer each
  std::vector<std::unique_ptr<Entry>> elevation_;
  std::vector<std::unique_ptr<Entry>> imagery_;  ///< a data set each, those of a layer next to each other
  std::unique_ptr<SourceOpeners> openers_;       ///< null: all sources are open from the start
};

}  // namespace tellurion::scene
