#include "pyramid/pyramid_reader.h"

#include <fmt/format.h>

#include <mutex>

#include "pyramid/database_file.h"

namespace tellurion::pyramid {

using Code = io::Failure::Code;

namespace {

/// A root that is not stored is fine where nothing below it is: parents of stored tiles are always stored.
io::Result<void> checkMissingRoot(TileDatabase& database, const tiling::TileId& root) {
  for (int q = 0; q < 4; ++q) {
    const auto found = database.contains(root.child(q));
    if (!found) return tl::unexpected(found.error());
    if (*found) {
      return io::fail(Code::corrupt,
                      fmt::format("{} is missing though {}, below it, is stored; build it again", nameOf(root),
                                  nameOf(root.child(q))),
                      database.connection().path());
    }
  }
  return {};
}

io::Result<std::optional<TileRecord>> readOrSayWhatIsMissing(TileDatabase& database, const tiling::TileId& id) {
  auto record = database.read(id);
  if (!record || *record || id.level != 0) return record;
  if (const auto ok = checkMissingRoot(database, id); !ok) return tl::unexpected(ok.error());
  return record;
}

}  // namespace

struct PyramidReader::State {
  std::filesystem::path path;
  raster::TileSourceInfo info;
  DatabaseMeta meta;
  mutable std::mutex mutex;
  mutable std::vector<TileDatabase> idle;  ///< connections that no thread uses right now

  io::Result<TileDatabase> borrow() const {
    {
      const std::scoped_lock lock(mutex);
      if (!idle.empty()) {
        TileDatabase database = std::move(idle.back());
        idle.pop_back();
        return database;
      }
    }
    return TileDatabase::open(path, io::SqliteConnection::Mode::read);
  }
  void giveBack(TileDatabase database) const {
    const std::scoped_lock lock(mutex);
    idle.push_back(std::move(database));
  }
  /// Nothing where no tile is stored.
  io::Result<std::optional<TileRecord>> read(const tiling::TileId& id) const {
    if (id.level > info.maxLevel) return std::optional<TileRecord>{};
    auto database = borrow();
    if (!database) return tl::unexpected(database.error());
    auto record = readOrSayWhatIsMissing(*database, id);
    giveBack(std::move(*database));
    return record;
  }
};

namespace {

io::Result<std::vector<LevelSummary>> levelsOf(const TileDatabase& database) {
  const DatabaseMeta& meta = database.meta();
  auto select =
      database.connection().prepare("SELECT count(*), sum(length(payload)) FROM tiles WHERE id BETWEEN ? AND ?");
  if (!select) return tl::unexpected(select.error());
  std::vector<LevelSummary> levels;
  for (int level = 0; level <= meta.maxLevel; ++level) {
    const RowRange rows = rowsOfLevel(level);
    select->bind(1, rows.first).bind(2, rows.last);
    const auto row = select->step();
    if (!row) return tl::unexpected(row.error());
    const auto tiles = static_cast<std::uint64_t>(select->integer(0));
    const auto bytes = static_cast<std::uint64_t>(select->integer(1));
    select->reset();
    if (tiles == 0) continue;
    const geo::Angle spacing = tiling::Tiling(meta.scheme).metrics(level).meanEdge / meta.tileCells;
    levels.push_back({.level = level, .tiles = tiles, .payloadBytes = bytes, .spacing = spacing});
  }
  return levels;
}

}  // namespace

PyramidReader::PyramidReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
PyramidReader::~PyramidReader() = default;

io::Result<std::shared_ptr<const PyramidReader>> PyramidReader::open(const std::filesystem::path& path) {
  if (auto ok = checkDatabaseFile(path); !ok) return tl::unexpected(ok.error());
  auto database = TileDatabase::open(path, io::SqliteConnection::Mode::read);
  if (!database) return tl::unexpected(database.error());
  if (!database->meta().complete) return tl::unexpected(unfinished(*database));
  auto state = std::make_unique<State>();
  state->path = path;
  state->meta = database->meta();
  state->info = sourceInfoOf(path.string(), database->meta());
  state->giveBack(std::move(*database));
  return std::shared_ptr<const PyramidReader>(new PyramidReader(std::move(state)));
}

const raster::TileSourceInfo& PyramidReader::info() const {
  return state_->info;
}

io::Result<std::optional<raster::SourceTile>> PyramidReader::load(const tiling::TileId& id) const {
  const auto record = state_->read(id);
  if (!record) return tl::unexpected(record.error());
  if (!*record) return std::optional<raster::SourceTile>{};
  auto tile = decoded(**record, state_->info.kind, state_->info.tileCells);
  if (!tile) {
    return io::fail(tile.error().code, fmt::format("{}: {}", nameOf(id), tile.error().message), state_->info.name);
  }
  return std::optional(std::move(*tile));
}

io::Result<raster::TilePresence> PyramidReader::lookUp(const tiling::TileId& id) const {
  const auto record = state_->read(id);
  if (!record) return tl::unexpected(record.error());
  return *record ? raster::TilePresence{.stored = true, .childMask = (*record)->childMask} : raster::TilePresence{};
}

io::Result<std::optional<raster::Raster<float>>> PyramidReader::depths(const tiling::TileId& id) const {
  auto database = state_->borrow();
  if (!database) return tl::unexpected(database.error());
  auto depths = database->depths(id);
  state_->giveBack(std::move(*database));
  return depths;
}

io::Result<PyramidSummary> PyramidReader::summary() const {
  auto database = state_->borrow();
  if (!database) return tl::unexpected(database.error());
  auto levels = levelsOf(*database);
  state_->giveBack(std::move(*database));
  if (!levels) return tl::unexpected(levels.error());
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(state_->path, error);
  return PyramidSummary{.heightStep_m = state_->meta.heightStep_m,
                        .fillVoids_m = state_->meta.fillVoids_m,
                        .maxError_m = state_->meta.maxError_m,
                        .fileBytes = error ? 0 : bytes,
                        .levels = std::move(*levels),
                        .sources = state_->meta.sources};
}

}  // namespace tellurion::pyramid
