#include "pyramid/memory_budget.h"

#include <algorithm>

namespace tellurion::pyramid {
namespace {

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20u;

constexpr std::uint64_t kProgram = 88 * kMiB;      // with its libraries and their tables, and the database's pages
constexpr std::uint64_t kWorker = 6 * kMiB;        // tiles in the making, compressors, a file's decoder
constexpr std::uint64_t kLeastShared = 24 * kMiB;  // less would read everything again and again
constexpr std::uint64_t kMostBlockCache = 256 * kMiB;
constexpr std::uint64_t kMostPerFile = 64 * kMiB;
constexpr std::uint64_t kLeastPerFile = 2 * kMiB;  // a tile needs some blocks at once
constexpr std::uint64_t kLattice = kMiB / 4;
constexpr std::uint64_t kPiece = 4 * kMiB;  // of work: a block's tiles, the records that a tile is made of
constexpr std::uint64_t kMostOpenFiles = 16;
constexpr std::uint64_t kMostLattices = 96;

}  // namespace

MemoryBudget memoryBudget(std::uint64_t bytes, int jobs, std::size_t inputs) {
  const auto workers = static_cast<std::uint64_t>(std::max(jobs, 1));
  const std::uint64_t taken = kProgram + workers * kWorker;
  const std::uint64_t shared = std::max(bytes > taken ? bytes - taken : 0, kLeastShared);
  const std::uint64_t pixels = shared / 2 / workers;
  const std::uint64_t files = std::min<std::uint64_t>(std::max<std::size_t>(inputs, 1), kMostOpenFiles);
  const std::uint64_t openFiles = std::clamp<std::uint64_t>(pixels / kLeastPerFile, 1, files);
  return {.blockCacheBytes = std::min(shared / 4, kMostBlockCache),
          .openFiles = openFiles,
          .bytesPerFile = std::min(pixels / openFiles, kMostPerFile),
          .lattices = std::clamp<std::uint64_t>(shared / 8 / workers / kLattice, 4, kMostLattices),
          .window = std::clamp<std::uint64_t>(shared / 8 / kPiece, 2, 4 * workers + 8)};
}

}  // namespace tellurion::pyramid
