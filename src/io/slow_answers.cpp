#include "io/slow_answers.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string_view>

namespace tellurion::io {
namespace {

constexpr double kPatience_s = 1.0;
constexpr double kSlow_bytes = 1024.0;  ///< a second

struct OfAHost {
  int count = 0;
  std::uint64_t bytes = 0;
  double longest_s = 0.0;
};

}  // namespace

std::vector<Failure> slowAnswers(const std::vector<OpenAnswer>& open, SteadyTime now) {
  std::map<std::string_view, OfAHost> hosts;
  for (const OpenAnswer& answer : open) {
    const double time_s = std::chrono::duration<double>(now - answer.since).count();
    if (time_s < kPatience_s || static_cast<double>(answer.bytes) >= kSlow_bytes * time_s) continue;
    OfAHost& host = hosts[answer.host];
    ++host.count;
    host.bytes += answer.bytes;
    host.longest_s = std::max(host.longest_s, time_s);
  }
  std::vector<Failure> out;
  for (const auto& [name, host] : hosts)
    out.push_back({Failure::Code::ioError,
                   fmt::format("hardly answers: {} of its answers under way, {} bytes of them in {:.0f} s", host.count,
                               host.bytes, host.longest_s),
                   std::string(name)});
  return out;
}

}  // namespace tellurion::io
