#include "io/thread_share.h"

#ifdef __linux__
#include <sched.h>
#include <sys/resource.h>
#endif

namespace tellurion::io {

void stepBack() {
#ifdef __linux__
  // What POSIX says of the process is so of the thread on Linux. Each step is a quarter.
  constexpr int kSteps = 5;
  const int now = getpriority(PRIO_PROCESS, 0);
  setpriority(PRIO_PROCESS, 0, now + kSteps);
  // Who wakes such a thread goes on itself: else each task that is handed over may take the core from who hands it
  // over.
  const sched_param none{};
  sched_setscheduler(0, SCHED_BATCH, &none);
#endif
}

}  // namespace tellurion::io
