#include "pyramid/remote_database.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <utility>

#include "pyramid/tile_objects.h"
#include "raster/service_url.h"

namespace tellurion::pyramid {
namespace {

using Code = io::Failure::Code;

/// Who prepared nothing waits so long for a server in trouble.
constexpr double kPatience_s = 60.0;
/// Contents are small, and whoever opens is told soon.
constexpr double kOpeningPatience_s = 20.0;
constexpr std::uint64_t kMostContents_bytes = std::uint64_t{256} << 20;
constexpr std::uint64_t kMostObject_bytes = std::uint64_t{64} << 20;
constexpr std::size_t kSweepAt = 256;

/// The address of an object: what lets somebody in stands behind its path.
std::string objectUrl(std::string_view database, std::string_view name) {
  std::string_view path = raster::withoutQuery(database);
  const std::string_view query = database.substr(path.size());
  while (path.ends_with('/'))
    path.remove_suffix(1);
  return fmt::format("{}/{}{}", path, name, query);
}

io::ResourceRequest contentsRequest(const std::string& url) {
  const std::string where = objectUrl(url, kContentsObject);
  return {.url = where,
          .dataset = url,
          .maxBytes = kMostContents_bytes,
          .check = [where](const io::Resource& resource) -> io::Result<bool> {
            const auto contents = decodedContents(resource.bytes, where);
            if (!contents) return tl::unexpected(contents.error());
            return true;
          },
          .revalidate = true};
}

class Contents final : public RemoteContents {
 public:
  Contents(std::string address, ObjectContents objects)
      : url(std::move(address)), stored(std::move(objects)), info_(sourceInfoOf(url, stored.meta)) {}
  const raster::TileSourceInfo& info() const override { return info_; }

  const std::string url;
  const ObjectContents stored;

 private:
  raster::TileSourceInfo info_;
};

class RemoteDatabase final : public raster::TileSource {
 public:
  RemoteDatabase(std::shared_ptr<const Contents> contents, std::shared_ptr<io::Resources> resources)
      : contents_(std::move(contents)), url_(contents_->url), resources_(std::move(resources)) {}

  const raster::TileSourceInfo& info() const override { return contents_->info(); }

  std::optional<raster::TilePresence> presence(const tiling::TileId& id) const override {
    return contents_->stored.index.find(id);
  }

  std::unique_ptr<raster::Preparation> prepare(const tiling::TileId& id, double priority,
                                               std::function<void()> ready) const override {
    if (!contents_->stored.index.find(id).stored) return nullptr;
    auto held = std::make_unique<Held>();
    keep(id, held->arrival);
    held->ticket =
        resources_->get(requestOf(id), priority, [arrival = held->arrival, ready = std::move(ready)](Came came) {
          arrival->set(std::move(came));
          ready();
        });
    return held;
  }

  io::Result<std::optional<raster::SourceTile>> load(const tiling::TileId& id) const override {
    if (!contents_->stored.index.find(id).stored) return std::optional<raster::SourceTile>{};
    std::optional<Came> came = arrived(id);
    if (!came) came = resources_->wait(requestOf(id), kPatience_s);
    if (!*came) return tl::unexpected(withHint(came->error()));
    if (!**came) return tl::unexpected(absent(id));
    const auto record = decodedObject((**came)->bytes, id, info().kind);
    if (!record) return io::fail(record.error().code, record.error().message, url_);
    auto tile = decoded(*record, info().kind, info().tileCells);
    if (!tile) return io::fail(tile.error().code, fmt::format("{}: {}", nameOf(id), tile.error().message), url_);
    return std::optional(std::move(*tile));
  }

 private:
  using Came = io::Result<std::shared_ptr<const io::Resource>>;

  /// What comes for a preparation.
  class Arrival {
   public:
    void set(Came came) {
      const std::scoped_lock lock(mutex_);
      came_ = std::move(came);
    }
    std::optional<Came> get() const {
      const std::scoped_lock lock(mutex_);
      return came_;
    }

   private:
    mutable std::mutex mutex_;
    std::optional<Came> came_;
  };

  struct Held final : raster::Preparation {
    void setPriority(double priority) override { ticket.setPriority(priority); }
    std::shared_ptr<Arrival> arrival = std::make_shared<Arrival>();
    io::Resources::Ticket ticket;
  };

  io::ResourceRequest requestOf(const tiling::TileId& id) const {
    return {.url = objectUrl(url_, objectName(contents_->stored.revision, id)),
            .dataset = url_,
            .maxBytes = kMostObject_bytes,
            .check = [id, kind = info().kind](const io::Resource& resource) -> io::Result<bool> {
              const auto record = decodedObject(resource.bytes, id, kind);
              if (!record) return tl::unexpected(record.error());
              return true;
            }};
  }

  void keep(const tiling::TileId& id, const std::shared_ptr<Arrival>& arrival) const {
    const std::scoped_lock lock(mutex_);
    if (arrivals_.size() >= sweepAt_) {
      std::erase_if(arrivals_, [](const auto& each) { return each.second.expired(); });
      sweepAt_ = std::max(kSweepAt, 2 * arrivals_.size());
    }
    arrivals_[id] = arrival;
  }

  std::optional<Came> arrived(const tiling::TileId& id) const {
    const std::scoped_lock lock(mutex_);
    const auto found = arrivals_.find(id);
    const auto arrival = found != arrivals_.end() ? found->second.lock() : nullptr;
    return arrival ? arrival->get() : std::nullopt;
  }

  /// Most buckets refuse what they do not have.
  io::Failure withHint(io::Failure failure) const {
    if (url_.starts_with("s3://") && failure.message.find("403") != std::string::npos)
      failure.message += "; when the database was replaced, open it again";
    return failure;
  }

  io::Failure absent(const tiling::TileId& id) const {
    return {.code = Code::notFound,
            .message = fmt::format("the server has no {} though the contents list it; when the database was replaced, "
                                   "open it again, else export and upload it whole",
                                   nameOf(id)),
            .where = url_};
  }

  std::shared_ptr<const Contents> contents_;
  const std::string& url_;  ///< of contents_
  std::shared_ptr<io::Resources> resources_;
  mutable std::mutex mutex_;
  mutable std::unordered_map<tiling::TileId, std::weak_ptr<Arrival>, tiling::TileIdHash> arrivals_;
  mutable std::size_t sweepAt_ = kSweepAt;
};

}  // namespace

bool isRemoteDatabase(std::string_view url) {
  constexpr std::array<std::string_view, 4> kSchemes{"http://", "https://", "s3://", "file://"};
  if (std::ranges::none_of(kSchemes, [&](std::string_view scheme) { return url.starts_with(scheme); })) return false;
  std::string_view path = raster::withoutQuery(url);
  while (path.ends_with('/'))
    path.remove_suffix(1);
  return path.ends_with(".tdb");
}

io::Result<std::shared_ptr<const RemoteContents>> askRemoteContents(const std::string& url, io::Resources& resources) {
  const auto came = resources.wait(contentsRequest(url), kOpeningPatience_s);
  if (!came) return tl::unexpected(came.error());
  if (!*came) {
    return io::fail(Code::notFound,
                    "there are no tile objects; write them with 'tellurion export FILE.tdb FOLDER --format objects' "
                    "and put the folder there",
                    url);
  }
  auto contents = decodedContents((*came)->bytes, url);
  if (!contents) return tl::unexpected(std::move(contents.error()));
  return std::make_shared<const Contents>(url, std::move(*contents));
}

std::shared_ptr<const raster::TileSource> remoteDatabase(const std::shared_ptr<const RemoteContents>& contents,
                                                         const std::shared_ptr<io::Resources>& resources) {
  return std::make_shared<const RemoteDatabase>(std::static_pointer_cast<const Contents>(contents), resources);
}

io::Result<std::shared_ptr<const raster::TileSource>> openRemoteDatabase(
    const std::string& url, const std::shared_ptr<io::Resources>& resources) {
  auto contents = askRemoteContents(url, *resources);
  if (!contents) return tl::unexpected(std::move(contents.error()));
  return remoteDatabase(*contents, resources);
}

}  // namespace tellurion::pyramid
