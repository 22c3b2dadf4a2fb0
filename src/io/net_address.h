#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "io/failure.h"

namespace tellurion::io {

/// A place in the network to listen on or to connect to.
struct NetAddress {
  std::string host = "127.0.0.1";  ///< a name, an IPv4 or an IPv6 address without brackets
  std::uint16_t port = 0;          ///< 0: to listen on, any that is free
  friend bool operator==(const NetAddress&, const NetAddress&) = default;
};

/// "HOST:PORT", "1.2.3.4:PORT", "[::1]:PORT", or "PORT" of this machine (127.0.0.1). Says nothing about whether there
/// is such a host.
Result<NetAddress> parseNetAddress(std::string_view text);

/// What parseNetAddress reads.
std::string formatNetAddress(const NetAddress& address);

}  // namespace tellurion::io
