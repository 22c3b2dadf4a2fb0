#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "scene/current_step.h"
#include "scene/doorbell.h"
#include "scene/globe_layers.h"
#include "scene/source_openers.h"

namespace tellurion::scene {

/// Which of the steps, in the order of time, counts at a time: the newest that is not after it, else the first.
std::size_t stepAt(const std::vector<TimedSource>& steps, double time_s);

/// A layer's time steps: opens the one that the clock wants, and the one after it in the direction that the clock goes.
/// No more than two and the one that is shown are open at a time. One thread only.
class LayerSeries {
 public:
  using Clock = std::chrono::steady_clock;
  /// Of an open source; fails when it does not fit the layer.
  using MakeTiles = std::function<io::Result<std::shared_ptr<LayerTiles>>(LayerSource::Pointer)>;

  /// steps: at least one, in the order of time. shown: the step that joins first, by way of join().
  LayerSeries(std::vector<TimedSource> steps, std::size_t shown, MakeTiles makeTiles, Doorbell& bell);

  void join(std::shared_ptr<LayerTiles> tiles) { current_->set(std::move(tiles)); }
  /// forwards: which way the clock goes.
  void setClock(double time_s, bool forwards);
  /// Takes in what was opened, and opens what is wanted; openers: for what cannot be opened at once.
  void advance(Clock::time_point now, SourceOpeners& openers, LoadLedger& ledger);
  /// advance() has something to do that nothing rings the bell for.
  bool isDue(Clock::time_point now, const SourceOpeners& openers) const;

  const std::shared_ptr<CurrentStep>& current() const { return current_; }
  /// Of the step to come, once it is open; null: none.
  std::shared_ptr<LayerTiles> upcoming() const;
  /// The step that the clock wants is not the one that is shown, and may become it.
  bool isComing() const;
  std::uint64_t bytes() const;  ///< of decoded tiles

 private:
  struct Step {
    std::shared_ptr<LayerTiles> tiles;
    std::shared_ptr<SourceOpeners::Opening> opening;  ///< while a thread is at it
    bool failed = false;                              ///< never will be
    Clock::time_point retryAt;
    std::chrono::seconds retryIn{1};
  };
  std::optional<std::size_t> after() const;
  void open(std::size_t index, Step& step, Clock::time_point now, SourceOpeners& openers, LoadLedger& ledger);
  void take(Step& step, io::Result<LayerSource::Pointer> source, Clock::time_point now, LoadLedger& ledger);

  std::vector<TimedSource> sources_;
  MakeTiles makeTiles_;
  Doorbell& bell_;
  std::shared_ptr<CurrentStep> current_ = std::make_shared<CurrentStep>();
  std::size_t shown_;
  std::size_t wanted_;
  bool forwards_ = true;
  std::map<std::size_t, Step> steps_;  ///< wanted, and the one to come
};

}  // namespace tellurion::scene
