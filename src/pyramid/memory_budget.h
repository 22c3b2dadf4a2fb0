#pragma once

#include <cstddef>
#include <cstdint>

namespace tellurion::pyramid {

/// How the memory of a build is shared out. All that grows with the inputs has a bound here; the rest (the program, its
/// libraries, SQLite's pages) is taken off first.
struct MemoryBudget {
  std::uint64_t blockCacheBytes = 0;  ///< GDAL's, of all files together
  std::size_t openFiles = 1;          ///< of a worker
  std::uint64_t bytesPerFile = 0;     ///< decoded pixels that each of them keeps
  std::size_t lattices = 1;           ///< of finer data around voids, that a worker keeps
  std::size_t window = 1;             ///< pieces of work that are begun and not yet written
};

/// Of `bytes` in all, for so many workers and inputs.
MemoryBudget memoryBudget(std::uint64_t bytes, int jobs, std::size_t inputs);

}  // namespace tellurion::pyramid
