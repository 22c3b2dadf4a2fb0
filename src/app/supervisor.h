#pragma once

#include <functional>
#include <optional>
#include <string>

namespace tellurion::app {

/// What a launcher of many processes (mpirun, srun) says in the environment.
struct Launched {
  int rank = 0;       ///< of this process
  int size = 1;       ///< processes in all
  int localSize = 1;  ///< of them on this machine
};
/// Nothing where this process was started alone.
std::optional<Launched> launched();

/// Goes on in a child of this process, which returns. This process itself waits for it, starts it again when a signal
/// has killed it, after telling so, and ends as it ends: it never returns. To be called while there is one thread.
void superviseThis(const std::function<void(const std::string&)>& tell);

}  // namespace tellurion::app
