#include "raster/grid_tile_source.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>
#include <type_traits>
#include <unordered_set>
#include <utility>

#include "raster/grid_fetch.h"
#include "raster/grid_sampling.h"
#include "raster/image_check.h"
#include "raster/live_tiles.h"
#include "raster/service_image.h"
#include "raster/shared_cache.h"

namespace tellurion::raster {
namespace {

/// As LevelImages, a tenth: pixels must be finer by this than a tile's samples to be worth tiles below it.
constexpr double kFiner = 1.1;

/// A worker waits so long for the server to mend an image that could not be decoded: some tries of its backoff.
constexpr double kSecondPatience_s = 10.0;

/// An overview has so many images in any case; more, up to the other, where roots would ask for so many times as many.
constexpr std::int64_t kFewImages = 2;
constexpr std::int64_t kMostOfOverview = 16;
constexpr std::int64_t kFewerTimes = 3;
constexpr std::uint64_t kOverview_bytes = std::uint64_t{4} << 20;  ///< decoded; more where it takes more

template <class T>
using ImageCache = SharedCache<GridImageId, Raster<T>, GridImageIdHash>;

template <class T>
std::uint64_t bytesOf(const Raster<T>& image) {
  return image.samples.size() * sizeof(T);
}

template <class T>
std::optional<io::Failure> failureOf(const io::Result<T>& result) {
  return result ? std::nullopt : std::optional(result.error());
}

/// Images whose bytes looked right and could not be decoded. Thread-safe.
class Suspects {
 public:
  /// False: it was one already.
  bool add(const GridImageId& id) {
    const std::scoped_lock lock(mutex_);
    return ids_.insert(id).second;
  }
  bool contains(const GridImageId& id) const {
    const std::scoped_lock lock(mutex_);
    return ids_.contains(id);
  }

 private:
  mutable std::mutex mutex_;
  std::unordered_set<GridImageId, GridImageIdHash> ids_;
};

/// A service, and its requests with a check that what comes is an image: by what its file tells (the protocol's own
/// check, which knows most; else that it is a picture of the right size), and of suspects by decoding it, so that a
/// damaged one is a bad answer of the server's as any other.
struct Service {
  GridService service;
  std::shared_ptr<const GridGeometry> geometry;
  std::shared_ptr<Suspects> suspects = std::make_shared<Suspects>();

  io::ResourceRequest request(const GridImageId& id) const {
    io::ResourceRequest request = service.request(id);
    const GridLevel& level = geometry->level(id.level);
    request.check = [own = std::move(request.check), width = level.imageWidth, height = level.imageHeight,
                     kind = service.kind, heights = service.heights, body = service.body,
                     decodes = suspects->contains(id)](const io::Resource& resource) {
      auto looked = own ? own(resource) : checkImage(resource, {.kind = kind, .width = width, .height = height});
      if (!looked || !*looked || !decodes) return looked;
      const auto failure = kind == Kind::elevation
                               ? failureOf(decodeServiceHeights(resource, width, height, heights, body))
                               : failureOf(decodeServiceImage(resource, width, height, std::nullopt));
      if (failure) return io::Result<bool>(tl::unexpected(*failure));
      return looked;
    };
    return request;
  }

  io::Result<Raster<float>> decode(const io::Resource& resource, const GridLevel& level, float /*sample*/) const {
    return decodeServiceHeights(resource, level.imageWidth, level.imageHeight, service.heights, service.body);
  }
  io::Result<Raster<Rgba8>> decode(const io::Resource& resource, const GridLevel& level, Rgba8 /*sample*/) const {
    return decodeServiceImage(resource, level.imageWidth, level.imageHeight, service.transparentColour);
  }
};

template <class T>
class GridTileSource final : public TileSource {
 public:
  GridTileSource(Service service, tiling::Scheme scheme, const std::shared_ptr<io::Resources>& resources,
                 const GridTileOptions& options)
      : service_(std::make_shared<const Service>(std::move(service))),
        geometry_(service_->geometry),
        tiling_(scheme),
        resources_(resources),
        cache_(std::make_shared<ImageCache<T>>(options.memoryBytes)),
        fetch_(std::make_shared<GridFetch>(
            geometry_, [service = service_](const GridImageId& id) { return service->request(id); }, resources,
            [cache = cache_](const GridImageId& id) -> std::optional<std::shared_ptr<const void>> {
              return cache->find(id);
            })) {
    const GridService& s = service_->service;
    info_ = {.name = s.name,
             .kind = s.kind,
             .scheme = scheme,
             .body = s.body,
             .tileCells = options.tileCells > 0 ? options.tileCells : usualCells(s.kind),
             .maxLevel = 0,
             .bounds = s.bounds};
    info_.isNested = false;
    while (info_.maxLevel < tiling::kMaxLevel && isCoarse(info_.maxLevel, s.bounds))
      ++info_.maxLevel;
  }

  const TileSourceInfo& info() const override { return info_; }

  std::shared_ptr<const TileSource> overview() const override {
    if (!coarsestIsCheap()) return nullptr;
    const GridLevel& level = geometry_->level(0);
    const auto pixels = static_cast<std::uint64_t>(imagesOf(0)) * static_cast<std::uint64_t>(level.imageWidth) *
                        static_cast<std::uint64_t>(level.imageHeight);
    GridService service = service_->service;
    service.levels.resize(1);
    auto source =
        gridTileSource(std::move(service), tiling_.scheme(), resources_,
                       {.memoryBytes = std::max(kOverview_bytes, pixels * sizeof(T)), .tileCells = info_.tileCells});
    return source ? *source : nullptr;
  }

  std::optional<io::Failure> complaint() const override {
    const std::scoped_lock lock(coarsestMutex_);
    if (!absentOfCoarsest_) return std::nullopt;
    return io::Failure{io::Failure::Code::notFound,
                       "the server has none of the images that were asked for, not even of the coarsest level; is the "
                       "address right?",
                       service_->service.request(*absentOfCoarsest_).url};
  }

  std::optional<TilePresence> presence(const tiling::TileId& id) const override {
    return livePresence(
        id, [this](const tiling::TileId& tile) { return info_.bounds.intersects(tiling_.bounds(tile)); },
        [this](const tiling::TileId& tile) { return isCoarse(tile.level, tiling_.bounds(tile)); });
  }

  std::unique_ptr<Preparation> prepare(const tiling::TileId& id, double priority,
                                       std::function<void()> ready) const override {
    if (!presence(id)->stored) return nullptr;
    return fetch_->fetchPlanned([geometry = geometry_, tiling = tiling_, id, kind = info_.kind,
                                 cells = info_.tileCells] { return imagesFor(*geometry, tiling, id, kind, cells); },
                                priority, std::move(ready));
  }

  io::Result<std::optional<SourceTile>> load(const tiling::TileId& id) const override {
    const TilePresence presence = *this->presence(id);
    if (!presence.stored) return std::optional<SourceTile>{};
    const auto held = fetch_->fetchAndWait(imagesFor(*geometry_, tiling_, id, info_.kind, info_.tileCells));
    if (!held) return tl::unexpected(held.error());
    const GridImages<T> images = [this](const GridImageId& image) { return decoded(image); };
    auto made = sampleGrid(*geometry_, tiling_, id, info_.tileCells, images);
    if (!made) return tl::unexpected(std::move(made.error()));
    // What is too small or too fine for this level's samples is found below it.
    const bool leadsDown = !made->isReached && presence.childMask != 0;
    if (id.level > 0 && !made->addsDetail && !leadsDown) return std::optional<SourceTile>{};
    if constexpr (std::is_same_v<T, float>) {
      return std::optional(liveTile(std::move(made->samples), presence.childMask, id, info_));
    } else {
      return std::optional(liveTile(std::move(made->samples), presence.childMask));
    }
  }

 private:
  std::int64_t imagesOf(int level) const {
    return std::int64_t{geometry_->window(level).imageColumns} * geometry_->window(level).imageRows;
  }

  /// It is not the level that roots are read on, and asks for far fewer images than that does for all of them.
  bool coarsestIsCheap() const {
    const GridFit ofRoots = geometry_->fit(sampleSpacing(tiling_, 0, info_.tileCells), tiling_.scheme(), 1.0);
    const std::int64_t images = imagesOf(0);
    return ofRoots.level > 0 &&
           (images <= kFewImages || (images <= kMostOfOverview && kFewerTimes * images <= imagesOf(ofRoots.level)));
  }

  /// Whether there are finer pixels, somewhere in a part of the service, than the samples of a level.
  bool isCoarse(int level, const geo::GeoRect& part) const {
    const geo::Angle south = std::max(part.south, info_.bounds.south);
    const geo::Angle north = std::min(part.north, info_.bounds.north);
    const double farthest = std::max(std::abs(south.radians()), std::abs(north.radians()));
    // The last latitude of Mercator; other planes do not mind.
    const double narrowing = std::max(std::cos(farthest), 0.086);
    const geo::Angle finest = geometry_->pixelSide(geometry_->levels() - 1, narrowing);
    return finest * kFiner < sampleSpacing(tiling_, level, info_.tileCells);
  }

  io::Result<typename ImageCache<T>::Pointer> decoded(const GridImageId& id) const {
    return cache_->get(
        id, [&] { return decode(id); }, bytesOf<T>);
  }

  io::Result<typename ImageCache<T>::Pointer> decode(const GridImageId& id) const {
    const auto arrival = fetch_->arrived(id);
    const GridFetch::Arrival came = arrival ? *arrival : fetch_->wait(id);
    noteOfCoarsest(id, came);
    auto image = decode(id, came);
    if (image || !came || image.error().code == io::Failure::Code::unsupported) return image;
    const bool isFirst = service_->suspects->add(id);
    fetch_->reject(id);
    // Whoever prepares it from now on waits for a good one without a thread; who is here already has waited once.
    return isFirst ? decode(id, fetch_->wait(id, kSecondPatience_s)) : image;
  }

  io::Result<typename ImageCache<T>::Pointer> decode(const GridImageId& id, const GridFetch::Arrival& resource) const {
    if (!resource) return tl::unexpected(resource.error());
    if (!*resource) return nullptr;
    auto image = service_->decode(**resource, geometry_->level(id.level), T{});
    if (!image) {
      return io::fail(image.error().code, std::move(image.error().message), service_->service.request(id).url);
    }
    const auto shared = std::make_shared<Raster<T>>();
    std::swap(*shared, *image);
    return shared;
  }

  /// A right address may lack some images, and every other level, but not all of the first.
  void noteOfCoarsest(const GridImageId& id, const GridFetch::Arrival& came) const {
    if (id.level != 0) return;
    const std::scoped_lock lock(coarsestMutex_);
    hasOfCoarsest_ = hasOfCoarsest_ || !came || *came != nullptr;
    if (hasOfCoarsest_) {
      absentOfCoarsest_.reset();
    } else {
      absentOfCoarsest_ = id;
    }
  }

  std::shared_ptr<const Service> service_;
  std::shared_ptr<const GridGeometry> geometry_;
  tiling::Tiling tiling_;
  TileSourceInfo info_;
  std::shared_ptr<io::Resources> resources_;
  std::shared_ptr<ImageCache<T>> cache_;
  std::shared_ptr<GridFetch> fetch_;
  mutable std::mutex coarsestMutex_;
  mutable bool hasOfCoarsest_ = false;                   ///< something other than absence was an answer
  mutable std::optional<GridImageId> absentOfCoarsest_;  ///< one of them, where none is there
};

}  // namespace

io::Result<std::shared_ptr<const TileSource>> gridTileSource(GridService service, tiling::Scheme scheme,
                                                             const std::shared_ptr<io::Resources>& resources,
                                                             const GridTileOptions& options) {
  auto geometry = GridGeometry::make(service);
  if (!geometry) return tl::unexpected(std::move(geometry.error()));
  const Kind kind = service.kind;
  Service checked{std::move(service), std::move(*geometry)};
  if (kind == Kind::elevation) {
    return std::make_shared<const GridTileSource<float>>(std::move(checked), scheme, resources, options);
  }
  return std::make_shared<const GridTileSource<Rgba8>>(std::move(checked), scheme, resources, options);
}

}  // namespace tellurion::raster
