#pragma once

#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "pyramid/build_plan.h"
#include "raster/vertical_datum.h"

namespace tellurion::pyramid {

/// The inputs of a build, as one thread sees them: opened when they are first needed, the longest unused closed again
/// when many are open. One thread only.
class InputSet {
 public:
  /// At most `mostOpen` files are open at a time, at least one, each with a cache of `cacheBytes`.
  InputSet(const BuildPlan& plan, std::size_t mostOpen, std::size_t cacheBytes)
      : plan_(plan), files_(plan.inputs.size()), mostOpen_(mostOpen), cacheBytes_(cacheBytes) {}

  /// Lays the named inputs, in order, over what `out` holds, of samples of a tile as RasterFile::sampleTile; each with
  /// its own footprint. So a height depends on the place alone: neither on the tile that asks nor on its level. Colours
  /// do so where tiles meet, and within tiles but for the 1/256 of a pixel that sampleTile may be off.
  io::Result<void> heights(std::span<const int> inputs, const tiling::TileId& id, std::span<const std::size_t> indices,
                           std::span<float> out);
  io::Result<void> colours(std::span<const int> inputs, const tiling::TileId& id, std::span<const std::size_t> indices,
                           std::span<raster::Rgba8> out);

  /// Of one input alone, as RasterFile::sampleColours.
  io::Result<void> coloursAt(int input, std::span<const geo::Direction> places, geo::Angle footprint,
                             std::span<raster::Rgba8> out);

  /// As RasterFile::mayTouch; true without a look where there are more inputs than may be open, for opening each again
  /// and again would cost more than it spares.
  io::Result<bool> mayTouch(int input, const tiling::TileId& id, geo::Angle within);

  /// What the inputs have warned of so far, while they were sampled too: "PATH: sentence", each once.
  std::set<std::string> warnings() const;

 private:
  struct Slot {
    std::optional<raster::RasterFile> file;
    std::optional<raster::VerticalDatum> datum;  ///< opened with the first heights; kept, for it is small
    std::uint64_t lastUse = 0;
  };
  io::Result<raster::RasterFile*> file(int input);
  const PlannedInput& planned(int input) const { return plan_.inputs[static_cast<std::size_t>(input)]; }
  io::Result<void> ofOne(int input, const tiling::TileId& id, std::span<const std::size_t> indices,
                         std::span<const geo::Direction> places, std::span<float> out);
  io::Result<void> layAboveDatum(int input, std::span<const geo::Direction> places, std::span<const float> heights,
                                 std::span<float> out);
  template <class T>
  io::Result<void> laid(std::span<const int> inputs, const tiling::TileId& id, std::span<const std::size_t> indices,
                        std::span<T> out);
  void closeOldest();
  io::Result<void> sampled(std::span<const int> inputs, const tiling::TileId& id, std::span<const std::size_t> indices,
                           std::span<float> out);
  io::Result<void> sampled(std::span<const int> inputs, const tiling::TileId& id, std::span<const std::size_t> indices,
                           std::span<raster::Rgba8> out);
  static void collectWarnings(const raster::RasterFile& file, std::set<std::string>& warnings);

  const BuildPlan& plan_;
  std::vector<Slot> files_;
  std::size_t mostOpen_;
  std::size_t cacheBytes_;
  std::size_t openFiles_ = 0;
  std::uint64_t uses_ = 0;
  std::set<std::string> warnings_;  ///< of files that are closed again
};

}  // namespace tellurion::pyramid
