#include "app/supervisor.h"

#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string_view>

namespace tellurion::app {
namespace {

constexpr int kFailed = 1;
constexpr int kMostRestarts = 5;  // what kills a process again and again is no accident

/// The child that a signal is handed on to.
std::atomic<pid_t> child = 0;
std::atomic<bool> isAskedToStop = false;
static_assert(std::atomic<pid_t>::is_always_lock_free && std::atomic<bool>::is_always_lock_free);

void handOn(int signal) {
  isAskedToStop = true;
  const pid_t to = child;
  if (to > 0) ::kill(to, signal);
}

std::optional<int> numberOf(const char* variable) {
  const char* text = std::getenv(variable);
  if (text == nullptr) return std::nullopt;
  const std::string_view digits(text);
  int number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  const std::string_view rest = digits.substr(static_cast<std::size_t>(end - digits.data()));
  if (error != std::errc{} || number < 0 || !(rest.empty() || rest.front() == '(' || rest.front() == ','))
    return std::nullopt;  // "4(x2),3"
  return number;
}

struct Variables {
  const char* rank;
  const char* size;
  const char* localSize;
};

}  // namespace

std::optional<Launched> launched() {
  constexpr Variables kLaunchers[] = {{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_LOCAL_SIZE"},
                                      {"PMI_RANK", "PMI_SIZE", "MPI_LOCALNRANKS"},
                                      {"SLURM_PROCID", "SLURM_STEP_NUM_TASKS", "SLURM_STEP_TASKS_PER_NODE"}};
  for (const Variables& launcher : kLaunchers) {
    const auto rank = numberOf(launcher.rank);
    const auto size = numberOf(launcher.size);
    if (!rank || !size || *size < 2) continue;
    const int local = numberOf(launcher.localSize).value_or(1);
    return Launched{.rank = *rank, .size = *size, .localSize = std::clamp(local, 1, *size)};
  }
  return std::nullopt;
}

void superviseThis(const std::function<void(const std::string&)>& tell) {
  const pid_t self = ::getpid();
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    if (std::signal(signal, handOn) == SIG_IGN) std::signal(signal, SIG_IGN);
  }
  for (int restarts = 0;; ++restarts) {
    const pid_t worker = ::fork();
    if (worker < 0) {
      tell(fmt::format("no process can be started: {}", std::strerror(errno)));
      std::_Exit(kFailed);
    }
    if (worker == 0) {
      for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        if (std::signal(signal, SIG_DFL) == SIG_IGN) std::signal(signal, SIG_IGN);
      }
      // A launcher that kills this process's parent outright means all of it.
      ::prctl(PR_SET_PDEATHSIG, SIGTERM);
      if (::getppid() != self) std::_Exit(kFailed);
      return;
    }
    child = worker;
    int status = 0;
    while (::waitpid(worker, &status, 0) < 0 && errno == EINTR) {
    }
    child = 0;
    if (WIFEXITED(status)) std::_Exit(WEXITSTATUS(status));
    if (isAskedToStop) std::_Exit(kFailed);
    tell(fmt::format("process {} was killed by signal {} ({})", worker, WTERMSIG(status),
                     ::strsignal(WTERMSIG(status))));
    if (restarts == kMostRestarts) {
      tell("that was too often: this one is not started again");
      std::_Exit(kFailed);
    }
  }
}

}  // namespace tellurion::app
