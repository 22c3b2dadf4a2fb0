#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "scene/globe_layers.h"
#include "scene/source_openers.h"
#include "scene/tile_fetching.h"

namespace tellurion::scene {

/// How far a source of a scene has come on its way into the picture. LayerRoster's, and of its thread.
struct RosterEntry {
  using Clock = std::chrono::steady_clock;
  enum class State : std::uint8_t {
    opening,   ///< on a thread, or waiting to be tried again
    looking,   ///< at its overview, before roots take the places of the line
    fetching,  ///< its roots
    ready,     ///< may take part
    failed,    ///< never will
  };
  raster::Kind kind = raster::Kind::elevation;
  LayerSource source;
  std::size_t layer = 0;  ///< of its kind
  State state = State::opening;
  bool isTold = false;   ///< LayerRoster::maker() has it
  bool isShown = false;  ///< what is drawn has it
  /// While what holds others up is set aside: until then, and the longer the more often it did.
  std::optional<Clock::time_point> asideUntil;
  static constexpr std::chrono::seconds kAsideFirst{2};
  std::chrono::seconds asideFor = kAsideFirst;
  std::shared_ptr<LayerTiles> tiles;
  struct Root {
    std::size_t root = 0;
    std::shared_ptr<TileFetch> fetch;
  };
  std::vector<Root> roots;       ///< on their way, or held until contents are made of them
  std::uint32_t toldRoots = 0;   ///< of elevation, those that maker() has: GroundLayers::Layer
  std::uint32_t shownRoots = 0;  ///< and those that what is drawn has
  /// What imagery shows until its roots are here; null: nothing. Held until all roots are here, in sight or not.
  std::shared_ptr<LayerTiles> overview;
  Clock::time_point rootsAt;  ///< while looking: when roots are asked for whether it has come or not
  std::vector<std::shared_ptr<TileFetch>> overviewRoots;
  std::shared_ptr<SourceOpeners::Opening> opening;  ///< while a thread is at it
  /// Of a layer whose steps are not known yet: what the thread that opens it fills in, too.
  struct Steps {
    std::vector<TimedSource> all;
    std::size_t first = 0;
  };
  std::shared_ptr<Steps> steps;
  Clock::time_point retryAt;
  std::chrono::seconds retryIn{1};
  std::optional<io::Failure> trouble;
};

/// A bit each: the roots whose data need not be waited for.
std::uint32_t rootsHere(const RosterEntry& entry);
bool overviewIsHere(const RosterEntry& entry);
/// Its overview has come, or has not for long enough: the roots' turn.
bool mayFetchRoots(const RosterEntry& entry, RosterEntry::Clock::time_point now);
/// There is something to show of it. rootShares: Selection's.
bool mayTakePart(const RosterEntry& entry, std::span<const double> rootShares);
/// Of elevation that takes part: not with all its roots.
bool lacksRoots(const RosterEntry& entry);
/// It may take part, and does not yet or with fewer roots than it could. Roots out of sight count when they are all.
bool hasMoreToTell(const RosterEntry& entry, std::span<const double> rootShares, bool isPending);
/// What is drawn lacks it, or roots of it, and maker() has it.
bool joins(const RosterEntry& entry);
/// Not all of it takes part, and it may still come.
bool isComing(const RosterEntry& entry);

}  // namespace tellurion::scene
