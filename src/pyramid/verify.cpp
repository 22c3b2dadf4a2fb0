#include "pyramid/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "pyramid/database_file.h"
#include "pyramid/geometric_error.h"
#include "pyramid/ordered_work.h"

namespace tellurion::pyramid {
namespace {

using raster::HeightStatistics;
using raster::isNoData;
using Code = io::Failure::Code;
using Faults = std::vector<std::string>;

constexpr std::uint64_t kReportEvery = 64;

bool same(float a, float b) {
  return a == b || (isNoData(a) && isNoData(b));
}
bool same(const HeightStatistics& a, const HeightStatistics& b) {
  return same(a.min_m, b.min_m) && same(a.max_m, b.max_m) && same(a.error_m, b.error_m);
}

/// Whether the range holds the other; a range without data holds none but its like.
bool holds(const HeightStatistics& range, const HeightStatistics& other) {
  if (isNoData(other.min_m)) return true;
  return range.min_m <= other.min_m && range.max_m >= other.max_m;
}

/// What is wrong inside one row: payload and statistics. Runs on a worker.
Faults faultsInside(const TileRecord& record, raster::Kind kind, int cells, float maxError_m) {
  Faults faults;
  const auto complain = [&](const std::string& what) { faults.push_back(nameOf(record.id) + ": " + what); };
  const auto tile = decoded(record, kind, cells);
  if (!tile) {
    complain("its payload does not decode: " + tile.error().message);
    return faults;
  }
  if (kind == raster::Kind::imagery) return faults;
  const HeightStatistics& stated = record.statistics;
  const HeightStatistics own = raster::ownRangeOf(std::get<raster::ElevationTile>(tile->payload).samples);
  if (!holds(stated, own)) complain("its samples are outside its minimum and maximum");
  if (!(stated.error_m >= 0.0f)) complain("its error is negative or not a number");
  if (record.childMask == 0 && stated.error_m != maxError_m) {
    complain("it has no children but another error than its samples may have");
  }
  if (record.childMask == 0 && !(same(stated.min_m, own.min_m) && same(stated.max_m, own.max_m))) {
    complain("its minimum or maximum is not that of its samples");
  }
  for (unsigned q = 0; q < 4; ++q) {
    if ((record.childMask & (1u << q)) == 0) continue;
    if (!holds(stated, record.children[q])) complain("a child is outside its minimum and maximum");
    if (record.children[q].error_m > stated.error_m) complain("its error is smaller than a child's");
  }
  return faults;
}

class Verification {
 public:
  Verification(TileDatabase& database, io::SqliteStatement family, const VerifyOptions& options,
               const VerifySink& progress, const std::stop_token& stop)
      : database_(database),
        family_(std::move(family)),
        options_(options),
        progress_(progress),
        stop_(stop),
        work_(jobs(options), 4 * static_cast<std::size_t>(jobs(options)) + 8) {}

  io::Result<VerifyReport> run() {
    checkFile();
    const auto walked = walk();
    while (!work_.isEmpty())
      add(work_.pop());
    if (stop_.stop_requested()) return stopped();
    if (!walked) add({"the walk over the tiles ended early: " + walked.error().message});
    checkMeta();
    return std::move(report_);
  }

 private:
  static int jobs(const VerifyOptions& options) {
    return options.jobs > 0 ? options.jobs : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  }

  void add(const Faults& faults) {
    report_.faultCount += faults.size();
    for (const std::string& fault : faults) {
      if (report_.faults.size() < options_.maxFaults) report_.faults.push_back(fault);
    }
  }

  tl::unexpected<io::Failure> stopped() const {
    return io::fail(Code::cancelled,
                    fmt::format("stopped before the end: {} tiles were looked at, {} faults found until then",
                                report_.tiles, report_.faultCount),
                    database_.connection().path());
  }

  /// SQLite's own check of its pages.
  void checkFile() {
    auto check = database_.connection().prepare("PRAGMA integrity_check(20)");
    while (check) {
      const auto row = check->step();
      if (stop_.stop_requested()) return;
      if (!row) {
        add({"the database file is damaged: " + row.error().message});
        return;
      }
      if (!*row) return;
      const std::string text = check->text(0);
      if (text != "ok") add({"the database file is damaged: " + text});
    }
  }

  io::Result<void> walk() {
    const auto total = database_.connection().integer("SELECT count(*) FROM tiles");
    if (!total) return tl::unexpected(total.error());
    auto rows = database_.connection().prepare(fmt::format("SELECT {} FROM tiles ORDER BY id", kTileColumns));
    if (!rows) return tl::unexpected(rows.error());
    while (!stop_.stop_requested()) {
      const auto row = rows->step();
      if (!row) return tl::unexpected(row.error());
      if (!*row) return {};
      if (auto ok = checkRow(*rows); !ok) return ok;
      if (progress_ && report_.tiles % kReportEvery == 0) progress_(report_.tiles, static_cast<std::uint64_t>(*total));
    }
    return {};
  }

  io::Result<void> checkRow(const io::SqliteStatement& row) {
    const DatabaseMeta& meta = database_.meta();
    ++report_.tiles;
    auto record = recordFrom(row, meta.kind, database_.connection().path());
    if (!record) {
      add({record.error().message});
      return {};
    }
    report_.payloadBytes += record->payload.size();
    deepest_ = std::max(deepest_, static_cast<int>(record->id.level));
    if (auto ok = checkFamily(*record); !ok) return ok;
    if (meta.kind == raster::Kind::elevation) {
      if (const auto depths = database_.depths(record->id); !depths) add({depths.error().message});
    }
    if (work_.isFull()) add(work_.pop());
    work_.push([shared = std::make_shared<const TileRecord>(std::move(*record)), kind = meta.kind,
                cells = meta.tileCells,
                maxError_m = roundedUp(meta.maxError_m)] { return faultsInside(*shared, kind, cells, maxError_m); });
    return {};
  }

  /// Its parent knows it, and the children that it knows are there.
  io::Result<void> checkFamily(const TileRecord& record) {
    const auto complain = [&](const std::string& what) { add({nameOf(record.id) + ": " + what}); };
    const std::uint32_t side = std::uint32_t{1} << record.id.level;
    const bool isPlaced = record.id.root < tiling::Tiling(database_.meta().scheme).rootCount() && record.id.x < side &&
                          record.id.y < side;
    if (!isPlaced) {
      complain("there is no such tile in this tiling");
      return {};
    }
    if (auto ok = checkParent(record); !ok) return ok;
    for (int q = 0; q < 4; ++q) {
      if ((record.childMask & (1 << q)) == 0) continue;
      if (record.id.level == tiling::kMaxLevel) {
        complain("it names a child below the deepest level");
        continue;
      }
      const auto found = database_.contains(record.id.child(q));
      if (!found) return tl::unexpected(found.error());
      if (!*found) complain(fmt::format("its child {} is missing", nameOf(record.id.child(q))));
    }
    return {};
  }

  io::Result<void> checkParent(const TileRecord& record) {
    if (record.id.level == 0) return {};
    const auto complain = [&](const std::string& what) { add({nameOf(record.id) + ": " + what}); };
    family_.bind(1, rowNumberOf(record.id.parent()));
    const auto found = family_.step();
    if (!found) return tl::unexpected(found.error());
    if (!*found) {
      complain("its parent is missing");
      return {};
    }
    const auto quadrant = static_cast<unsigned>(record.id.quadrant());
    if ((family_.integer(0) & (1 << quadrant)) == 0) complain("its parent does not know it");
    const std::span<const std::byte> bytes = family_.blob(1);
    if (bytes.size() == kChildrenBytes && database_.meta().kind == raster::Kind::elevation) {
      const auto children = childrenFromBytes(bytes.first<kChildrenBytes>());
      if (!same(children[quadrant], record.statistics))
        complain("its statistics are not those that its parent has of it");
    }
    family_.reset();
    return {};
  }

  void checkMeta() {
    if (report_.faultCount == 0 && deepest_ != database_.meta().maxLevel) {
      add({fmt::format("the deepest level is {}, not {} as stated", deepest_, database_.meta().maxLevel)});
    }
  }

  TileDatabase& database_;
  io::SqliteStatement family_;
  const VerifyOptions& options_;
  const VerifySink& progress_;
  const std::stop_token& stop_;
  VerifyReport report_;
  int deepest_ = 0;
  OrderedWork<Faults> work_;
};

}  // namespace

io::Result<VerifyReport> verifyPyramid(const std::filesystem::path& path, const VerifyOptions& options,
                                       const VerifySink& progress, const std::stop_token& stop) {
  if (auto ok = checkDatabaseFile(path); !ok) return tl::unexpected(ok.error());
  auto database = TileDatabase::open(path, io::SqliteConnection::Mode::read);
  if (!database) return tl::unexpected(database.error());
  if (!database->meta().complete) return tl::unexpected(unfinished(*database));
  auto family = database->connection().prepare("SELECT child_mask, children FROM tiles WHERE id = ?");
  if (!family) return tl::unexpected(family.error());
  const std::stop_callback interrupt(stop, [&database] { database->connection().interrupt(); });
  return Verification(*database, std::move(*family), options, progress, stop).run();
}

}  // namespace tellurion::pyramid
