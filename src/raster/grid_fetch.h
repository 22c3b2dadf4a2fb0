#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <vector>

#include "raster/grid_geometry.h"
#include "raster/tile_source.h"

namespace tellurion::raster {

/// The images of a grid on their way from io::Resources, not decoded. Where a server has none, those of the coarser
/// level under it are fetched in its place. Thread-safe.
class GridFetch : public std::enable_shared_from_this<GridFetch> {
 public:
  /// What has come: bytes, null (there is none), or why none can come.
  using Arrival = io::Result<std::shared_ptr<const io::Resource>>;
  /// An image that is at hand already, decoded: it, or null for "there is none"; nothing: it is not. What is held stays
  /// at hand.
  using Decoded = std::function<std::optional<std::shared_ptr<const void>>(const GridImageId&)>;
  using Plan = std::function<std::vector<GridImageId>()>;
  using MakeRequest = std::function<io::ResourceRequest(const GridImageId&)>;

  /// A load that nobody prepared waits so long for a server in trouble.
  static constexpr double kPatience_s = 60.0;

  GridFetch(std::shared_ptr<const GridGeometry> geometry, MakeRequest request, std::shared_ptr<io::Resources> resources,
            Decoded decoded);

  /// Asks for images and for what stands in for missing ones. `ready` is called once, as TileSource::prepare has it,
  /// when all have come. The result holds what has come, for arrived(), and what was at hand decoded. Null: all is at
  /// hand, decoded or in other preparations (which hold it no longer than they live).
  std::unique_ptr<Preparation> fetch(const std::vector<GridImageId>& ids, double priority, std::function<void()> ready);
  /// Likewise of the images that `plan` tells on a thread of io::Resources, for who has no time to find them out. Never
  /// null; `ready` is called in any case, and all that is at hand is held.
  std::unique_ptr<Preparation> fetchPlanned(Plan plan, double priority, std::function<void()> ready);
  /// As fetch(), waited for; the result holds it. Null: nothing to hold. Fails when the server is in trouble for too
  /// long.
  io::Result<std::unique_ptr<Preparation>> fetchAndWait(const std::vector<GridImageId>& ids);

  /// What some preparation holds.
  std::shared_ptr<const Arrival> arrived(const GridImageId& id) const;
  /// What came for an image is of no use: whoever asks from now on has it from the server, by a request made anew.
  void reject(const GridImageId& id);
  /// One image, waited for.
  Arrival wait(const GridImageId& id, double patience_s = kPatience_s) const;

 private:
  struct Batch;
  class Held;
  std::shared_ptr<Batch> batch(double priority, std::function<void()> ready);
  void keep(const GridImageId& id, const std::shared_ptr<const Arrival>& arrival);
  io::Failure lateness() const;

  std::shared_ptr<const GridGeometry> geometry_;
  MakeRequest request_;
  std::shared_ptr<io::Resources> resources_;
  Decoded decoded_;
  mutable std::mutex mutex_;
  std::unordered_map<GridImageId, std::weak_ptr<const Arrival>, GridImageIdHash> arrivals_;
  std::size_t sweepAt_ = 256;  ///< entries of arrivals_ at which those that nobody holds are taken out
};

}  // namespace tellurion::raster
