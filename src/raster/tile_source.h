#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "geo/body.h"
#include "io/failure.h"
#include "raster/tile.h"
#include "tiling/tiling.h"

namespace tellurion::raster {

struct TileSourceInfo {
  std::string name;  ///< for messages: a path or a URL
  Kind kind = Kind::elevation;
  tiling::Scheme scheme = tiling::Scheme::cube;
  geo::Body body = geo::earth();
  int tileCells = kElevationCells;  ///< cells (elevation) or pixels (imagery) a side
  int maxLevel = 0;                 ///< the deepest level that holds a tile
  geo::GeoRect bounds = geo::GeoRect::whole();
  /// Elevation: samples of a tile are samples of its children too, the same numbers. Else each level is made of its own
  /// (images of servers, rasters that are drawn as they are), and one place may have as many heights as levels.
  bool isNested = true;
};

/// What is known of a tile that is not loaded.
struct TilePresence {
  bool stored = false;
  std::uint8_t childMask = 0;  ///< bit q: the child in quadrant q is stored
};

/// What load() of a tile needs, on its way or here. Destroying it cancels what is on its way, and lets go of the rest.
class Preparation {
 public:
  Preparation() = default;
  virtual ~Preparation() = default;
  Preparation(const Preparation&) = delete;
  Preparation& operator=(const Preparation&) = delete;
  virtual void setPriority(double priority) = 0;  ///< larger comes first
};

/// Where tiles come from: one interface for both kinds of samples. Thread-safe.
class TileSource {
 public:
  virtual ~TileSource() = default;
  virtual const TileSourceInfo& info() const = 0;
  /// What can be told of a tile at once, without waiting for anything; nothing: load() has to be asked.
  virtual std::optional<TilePresence> presence(const tiling::TileId& /*id*/) const { return std::nullopt; }
  /// The same, where it may be waited for: what load(id) would tell but the samples, at less cost where the source can.
  /// Fails on what load() fails on, but for samples that cannot be decoded.
  virtual io::Result<TilePresence> lookUp(const tiling::TileId& id) const {
    if (const auto told = presence(id)) return *told;
    const auto tile = load(id);
    if (!tile) return tl::unexpected(tile.error());
    return *tile ? TilePresence{.stored = true, .childMask = (*tile)->childMask} : TilePresence{};
  }
  /// Begins to bring what load(id) reads from a network. `ready` is called once, on any thread but not from within,
  /// when load(id) will not wait for it any more; it must be quick. While a server is failing it is not called. Not
  /// after the preparation is destroyed, which must live until load(id) has returned. Null: there is nothing to wait
  /// for, and `ready` is not called.
  virtual std::unique_ptr<Preparation> prepare(const tiling::TileId& /*id*/, double /*priority*/,
                                               std::function<void()> /*ready*/) const {
    return nullptr;
  }
  /// Nothing: there is no such tile (not the same as one without data). May block on disk or network.
  virtual io::Result<std::optional<SourceTile>> load(const tiling::TileId& id) const = 0;
  /// Its roots alone, coarser and out of far fewer bytes, for the time until load() can have them; null: there is no
  /// cheaper look than the roots themselves. Not for more than a first look: no other tile has anything to do with it.
  virtual std::shared_ptr<const TileSource> overview() const { return nullptr; }
  /// What is wrong with the source as a whole, as far as its answers tell, though no tile of it has failed.
  virtual std::optional<io::Failure> complaint() const { return std::nullopt; }
};

}  // namespace tellurion::raster
