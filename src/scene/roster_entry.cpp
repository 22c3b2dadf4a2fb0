#include "scene/roster_entry.h"

#include <algorithm>

#include "scene/ground_layers.h"

namespace tellurion::scene {

std::uint32_t rootsHere(const RosterEntry& entry) {
  std::uint32_t here = GroundLayers::kAllRoots;
  for (const RosterEntry::Root& root : entry.roots)
    here &= root.fetch->isReady() ? GroundLayers::kAllRoots : ~(std::uint32_t{1} << root.root);
  return here;
}

bool overviewIsHere(const RosterEntry& entry) {
  return entry.overview && std::ranges::all_of(entry.overviewRoots, [](const auto& fetch) { return fetch->isReady(); });
}

bool mayTakePart(const RosterEntry& entry, std::span<const double> rootShares) {
  const std::uint32_t here = rootsHere(entry);
  if (here == GroundLayers::kAllRoots || overviewIsHere(entry)) return true;
  return !rootShares.empty() && std::ranges::any_of(entry.roots, [&](const RosterEntry::Root& root) {
    return ((here >> root.root) & 1u) != 0 && rootShares[root.root] > 0.0;
  });
}

bool lacksRoots(const RosterEntry& entry) {
  return entry.kind == raster::Kind::elevation && entry.isTold && entry.toldRoots != GroundLayers::kAllRoots;
}

bool hasMoreToTell(const RosterEntry& entry, std::span<const double> rootShares, bool isPending) {
  if (entry.state != RosterEntry::State::ready || entry.asideUntil) return false;
  if (!entry.isTold) return true;
  if (!lacksRoots(entry)) return false;
  const std::uint32_t here = rootsHere(entry);
  if (here == GroundLayers::kAllRoots) return true;
  return !isPending && std::ranges::any_of(entry.roots, [&](const RosterEntry::Root& root) {
    return ((here & ~entry.toldRoots) >> root.root & 1u) != 0 && !rootShares.empty() && rootShares[root.root] > 0.0;
  });
}

bool joins(const RosterEntry& entry) {
  return entry.isTold && (!entry.isShown || entry.toldRoots != entry.shownRoots);
}

bool mayFetchRoots(const RosterEntry& entry, RosterEntry::Clock::time_point now) {
  return entry.state == RosterEntry::State::looking && (overviewIsHere(entry) || now >= entry.rootsAt);
}

bool isComing(const RosterEntry& entry) {
  return entry.state != RosterEntry::State::failed && (!entry.isTold || lacksRoots(entry));
}

}  // namespace tellurion::scene
