#pragma once

#include <array>
#include <string>
#include <string_view>

#include "io/failure.h"

namespace tellurion::io {

using Digest = std::array<char, 32>;

/// HMAC-SHA256 (RFC 2104, FIPS 180-4). Any thread.
Digest keyedHash(std::string_view key, std::string_view text);

/// Takes as long wherever they differ.
bool isSameDigest(std::string_view a, std::string_view b);

/// 32 bytes that nobody can guess, of the system's generator.
Result<Digest> unguessableBytes();

inline std::string_view textOf(const Digest& digest) {
  return {digest.data(), digest.size()};
}

}  // namespace tellurion::io
