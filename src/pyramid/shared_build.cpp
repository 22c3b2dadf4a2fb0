// Who makes which part: fixed shares, or whoever comes first (docs/decisions/0014-parts-and-locks.md).
#include <fmt/format.h>

#include <chrono>
#include <optional>
#include <set>
#include <thread>

#include "io/file_lock.h"
#include "pyramid/parted_build.h"

namespace tellurion::pyramid {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;

constexpr std::chrono::milliseconds kWait{200};

io::Result<void> makeFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return io::fail(Code::ioError, "cannot be made: " + error.message(), folder.string());
  return {};
}

tl::unexpected<io::Failure> stopped(const PartedBuild& build) {
  return io::fail(Code::cancelled, "stopped; the same command goes on where it was", build.folder().string());
}

fs::path lockOf(const PartedBuild& build, std::size_t part) {
  return build.shard(part).replace_extension(".lock");
}

fs::path joinedFolder(const PartedBuild& build) {
  fs::path folder = build.folder();
  folder += ".joined";
  return folder;
}

std::vector<fs::path> allShards(const PartedBuild& build) {
  std::vector<fs::path> shards;
  for (std::size_t part = 0; part < build.parts().size(); ++part)
    shards.push_back(build.shard(part));
  return shards;
}

/// Makes parts, one after the other.
class PartMaker {
 public:
  PartMaker(const PartedBuild& build, const PartsSink& sink, const std::stop_token& stop)
      : build_(build), sink_(sink), stop_(stop) {}

  /// Unless another process does. False: one does.
  io::Result<bool> makeUnlessTaken(std::size_t part) {
    std::error_code error;
    // One that is there is only looked at, and nobody is kept from it.
    if (fs::exists(build_.shard(part), error)) return make(part);
    const auto lock = io::FileLock::tryTake(lockOf(build_, part));
    if (!lock) return tl::unexpected(lock.error());
    if (!*lock) return false;
    if (!(*lock)->leftBy().empty() && !fs::exists(build_.shard(part), error) && sink_.tell) {
      sink_.tell(fmt::format("part {} of {}: {}, which made it, is gone; it is redone", part + 1, build_.parts().size(),
                             (*lock)->leftBy()));
    }
    return make(part);
  }

 private:
  io::Result<bool> make(std::size_t part) {
    const auto warnings = build_.make(part, stop_);
    if (!warnings) return tl::unexpected(warnings.error());
    for (const std::string& warning : *warnings) {
      if (told_.insert(warning).second && sink_.tell) sink_.tell("warning: " + warning);
    }
    return true;
  }

  const PartedBuild& build_;
  const PartsSink& sink_;
  const std::stop_token& stop_;
  std::set<std::string> told_;  ///< each part would say them again
};

/// Takes parts until all are made, by whomever.
io::Result<void> makeAll(const PartedBuild& build, const PartsSink& sink, const std::stop_token& stop) {
  std::vector<std::size_t> open(build.parts().size());
  for (std::size_t part = 0; part < open.size(); ++part)
    open[part] = part;
  std::size_t made = 0;
  PartMaker maker(build, sink, stop);
  while (!open.empty()) {
    std::vector<std::size_t> taken;
    for (const std::size_t part : open) {
      if (stop.stop_requested()) return stopped(build);
      const auto isMade = maker.makeUnlessTaken(part);
      if (!isMade) return tl::unexpected(isMade.error());
      if (!*isMade) taken.push_back(part);
      if (*isMade && sink.progress) sink.progress(++made, build.parts().size());
    }
    open = std::move(taken);
    if (!open.empty()) std::this_thread::sleep_for(kWait);
  }
  return {};
}

/// What a process that was killed while it removed joined parts has left of them.
void removeJoined(const PartedBuild& build) {
  std::error_code error;
  fs::remove_all(joinedFolder(build), error);
}

/// Renamed first: a process that still waits makes files in the folder while it has its name.
void removeFolder(const PartedBuild& build) {
  removeJoined(build);
  std::error_code error;
  fs::rename(build.folder(), joinedFolder(build), error);
  removeJoined(build);
}

}  // namespace

io::Result<void> buildShare(const BuildOptions& options, std::size_t index, std::size_t count, const PartsSink& sink,
                            std::stop_token stop) {
  if (count == 0 || index >= count) return io::fail(Code::invalidArgument, "a share is I of N, I from 1 to N");
  const auto build = PartedBuild::plan(options, stop);
  if (!build) return tl::unexpected(build.error());
  const auto finished = build->finished();
  if (!finished) return tl::unexpected(finished.error());
  if (*finished) {
    removeJoined(*build);
    return {};
  }
  if (auto ok = makeFolder(build->folder()); !ok) return ok;
  const std::size_t parts = build->parts().size();
  const std::size_t ours = index < parts ? (parts - index + count - 1) / count : 0;
  std::size_t made = 0;
  PartMaker maker(*build, sink, stop);
  std::optional<std::size_t> taken;
  for (std::size_t part = index; part < parts; part += count) {
    const auto ok = maker.makeUnlessTaken(part);
    if (!ok) return tl::unexpected(ok.error());
    if (!*ok && !taken) taken = part;
    if (*ok && sink.progress) sink.progress(++made, ours);
  }
  if (!taken) return {};
  return io::fail(Code::ioError,
                  "another process makes this part, all others of the share are made; wait for it to end",
                  build->shard(*taken).string());
}

io::Result<BuildReport> buildTogether(const BuildOptions& options, const PartsSink& sink, const ProgressSink& joining,
                                      std::stop_token stop) {
  const auto build = PartedBuild::plan(options, stop);
  if (!build) return tl::unexpected(build.error());
  auto finished = build->finished();
  if (finished && *finished) removeJoined(*build);
  if (!finished || *finished) return finished ? io::Result<BuildReport>(**finished) : tl::unexpected(finished.error());
  if (auto ok = makeFolder(build->folder()); !ok) return tl::unexpected(ok.error());
  // Others may have joined all parts, and removed the folder, since the last look.
  finished = build->finished();
  if (finished && *finished) removeFolder(*build);
  if (!finished || *finished) return finished ? io::Result<BuildReport>(**finished) : tl::unexpected(finished.error());
  const auto made = makeAll(*build, sink, stop);
  while (true) {
    auto lock = made ? io::FileLock::tryTake(build->folder() / "join.lock") : tl::unexpected(made.error());
    // Another process may have joined the parts, and removed the folder: then that was the failure.
    finished = build->finished();
    if (!finished) return tl::unexpected(finished.error());
    if (*finished) return **finished;
    if (!lock) return tl::unexpected(lock.error());
    if (*lock) {
      auto report = build->join(allShards(*build), joining, stop);
      if (report) removeFolder(*build);
      return report;
    }
    if (stop.stop_requested()) return stopped(*build);
    std::this_thread::sleep_for(kWait);
  }
}

}  // namespace tellurion::pyramid
