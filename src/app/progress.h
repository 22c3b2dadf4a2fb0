#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace tellurion::app {

/// One line on stderr that is written over and over: what is done, how much, and how long it will still take. Silent
/// where stderr is no terminal. One thread only.
class ProgressLine {
 public:
  explicit ProgressLine(std::string what);
  ~ProgressLine();  ///< takes the line away
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// doneBefore: of `done`, what this run did not do itself; it does not count for the speed.
  void show(std::uint64_t done, std::uint64_t total, std::string_view unit, std::uint64_t doneBefore = 0);
  void clear();

 private:
  std::string what_;
  bool isTerminal_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point last_;
  std::size_t shown_ = 0;  ///< characters on the line
};

/// Rasters of a scene being built into databases (scene::BuildSink): a line for each, one at a time;
/// warnings stay.
class BuildLines {
 public:
  void operator()(std::string_view what, double share);

 private:
  std::string what_;
  std::optional<ProgressLine> line_;
};

/// "45 s", "3 min", "2 h 10 min".
std::string durationText(double seconds);

/// Turns Ctrl-C, SIGTERM and SIGHUP into a request to stop while it lives; a second one ends the program at once. Those
/// that the program was started to ignore (nohup) stay ignored. One at a time.
class InterruptStop {
 public:
  InterruptStop();
  ~InterruptStop();
  InterruptStop(const InterruptStop&) = delete;
  InterruptStop& operator=(const InterruptStop&) = delete;
  std::stop_token token() const { return source_.get_token(); }

 private:
  std::stop_source source_;
  std::vector<int> taken_;  ///< signals
  std::jthread watcher_;
};

}  // namespace tellurion::app
