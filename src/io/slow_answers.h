#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/failure.h"
#include "io/host_health.h"

namespace tellurion::io {

/// A request that a server has been sent and has not answered wholly, as far as the answer has come.
struct OpenAnswer {
  std::string host;
  SteadyTime since;
  std::uint64_t bytes = 0;
};

/// Of hosts whose answers hardly come (a second or more under way at less than 1 KiB a second), what people are told: a
/// failure each. They may be well all the same: whether they are given up is decided elsewhere.
std::vector<Failure> slowAnswers(const std::vector<OpenAnswer>& open, SteadyTime now);

}  // namespace tellurion::io
