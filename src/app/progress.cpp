#include "app/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>

#include "scene/layer_sources.h"

namespace tellurion::app {
namespace {

using namespace std::chrono_literals;

constexpr auto kRedrawInterval = 100ms;
constexpr auto kSignalInterval = 20ms;

/// Written by the signal, read by the watcher's thread.
std::atomic<bool> interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free);

void onInterrupt(int signal) {
  if (interrupted.exchange(true)) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
}

}  // namespace

std::string durationText(double seconds) {
  const auto whole = static_cast<std::int64_t>(seconds + 0.5);
  if (whole < 90) return fmt::format("{} s", whole);
  const std::int64_t minutes = (whole + 30) / 60;
  if (minutes < 90) return fmt::format("{} min", minutes);
  return fmt::format("{} h {} min", minutes / 60, minutes % 60);
}

ProgressLine::ProgressLine(std::string what) : what_(std::move(what)), isTerminal_(isatty(STDERR_FILENO) == 1) {}
ProgressLine::~ProgressLine() {
  clear();
}

void ProgressLine::show(std::uint64_t done, std::uint64_t total, std::string_view unit, std::uint64_t doneBefore) {
  const auto now = std::chrono::steady_clock::now();
  if (!isTerminal_ || now - last_ < kRedrawInterval) return;
  last_ = now;
  const double seconds = std::chrono::duration<double>(now - start_).count();
  const double share = total == 0 ? 0.0 : 100.0 * static_cast<double>(done) / static_cast<double>(total);
  std::string line = fmt::format("{}: {} of about {} {} ({:.0f} %)", what_, done, total, unit, share);
  if (done > doneBefore && seconds > 1.0) {
    const double rate = static_cast<double>(done - doneBefore) / seconds;
    line += fmt::format(", {} left", durationText(static_cast<double>(total - std::min(done, total)) / rate));
  }
  const std::size_t length = line.size();
  if (length < shown_) line.append(shown_ - length, ' ');
  shown_ = length;
  fmt::print(stderr, "\r{}", line);
  std::fflush(stderr);
}

void ProgressLine::clear() {
  if (shown_ == 0) return;
  fmt::print(stderr, "\r{}\r", std::string(shown_, ' '));
  shown_ = 0;
}

void BuildLines::operator()(std::string_view what, double share) {
  constexpr std::uint64_t kWhole = 100;
  if (share == scene::kWarningShare) {
    line_.reset();
    fmt::print(stderr, "warning: {}\n", what);
    return;
  }
  if (!line_ || what != what_) {
    line_.reset();
    what_ = what;
    line_.emplace(what_);
  }
  line_->show(static_cast<std::uint64_t>(share * kWhole), kWhole, "parts");
  if (share >= 1.0) line_.reset();
}

InterruptStop::InterruptStop() {
  interrupted = false;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    if (std::signal(signal, onInterrupt) == SIG_IGN) {
      std::signal(signal, SIG_IGN);
    } else {
      taken_.push_back(signal);
    }
  }
  watcher_ = std::jthread([this](std::stop_token over) {
    while (!over.stop_requested()) {
      if (interrupted) source_.request_stop();
      std::this_thread::sleep_for(kSignalInterval);
    }
  });
}

InterruptStop::~InterruptStop() {
  watcher_.request_stop();
  watcher_.join();
  for (const int signal : taken_)
    std::signal(signal, SIG_DFL);
}

}  // namespace tellurion::app
