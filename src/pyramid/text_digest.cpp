#include "pyramid/text_digest.h"

#include <fmt/format.h>

#include <cstdint>

namespace tellurion::pyramid {

std::string digestOf(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : text) {
    hash ^= static_cast<std::uint8_t>(c);
    hash *= 0x100000001b3u;
  }
  return fmt::format("{:016x}", hash);
}

}  // namespace tellurion::pyramid
