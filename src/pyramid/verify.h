#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "io/failure.h"

namespace tellurion::pyramid {

struct VerifyOptions {
  int jobs = 0;                 ///< worker threads; 0: one for each core
  std::size_t maxFaults = 100;  ///< no more than this many are kept as text; all are counted
};

struct VerifyReport {
  std::uint64_t tiles = 0;
  std::uint64_t payloadBytes = 0;
  std::uint64_t faultCount = 0;
  std::vector<std::string> faults;  ///< a sentence each, the tile first
  bool sound() const { return faultCount == 0; }
};

/// Tiles checked so far and their number.
using VerifySink = std::function<void(std::uint64_t done, std::uint64_t total)>;

/// Checks everything that a tile database promises: the SQLite file itself, every row's place in the tree, checksum and
/// payload, statistics against samples, against children and in the parent. Safe on untrusted files. Fails, rather than
/// reports, only when the file cannot be walked at all (no database, wrong version, unreadable), or when a stop is
/// asked for before the end (Code::cancelled), also within SQLite's own check.
io::Result<VerifyReport> verifyPyramid(const std::filesystem::path& path, const VerifyOptions& options = {},
                                       const VerifySink& progress = {}, const std::stop_token& stop = {});

}  // namespace tellurion::pyramid
