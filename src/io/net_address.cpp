#include "io/net_address.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

namespace tellurion::io {
namespace {

constexpr std::size_t kLongestHost = 253;  // of a name in the DNS

std::optional<std::uint16_t> portFrom(std::string_view text) {
  std::uint16_t port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  const bool isWhole = error == std::errc() && end == text.data() + text.size();
  return isWhole ? std::optional(port) : std::nullopt;
}

/// Names, and addresses with dots: no blanks, no control characters.
bool isHost(std::string_view text, bool isBracketed) {
  const auto fits = [&](char c) {
    const bool isAlphanumeric = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    return isAlphanumeric || c == '.' || c == '-' || c == '_' || (isBracketed && (c == ':' || c == '%'));
  };
  return !text.empty() && text.size() <= kLongestHost && std::ranges::all_of(text, fits);
}

}  // namespace

Result<NetAddress> parseNetAddress(std::string_view text) {
  const auto wrong = [&] {
    return fail(Failure::Code::invalidArgument,
                fmt::format("'{}' is not HOST:PORT, [IPV6]:PORT or a PORT of this machine, with a port from 0 to 65535",
                            text.substr(0, 2 * kLongestHost)));
  };
  const std::size_t colon = text.rfind(':');
  const auto port = portFrom(colon == std::string_view::npos ? text : text.substr(colon + 1));
  if (!port) return wrong();
  if (colon == std::string_view::npos) return NetAddress{.port = *port};
  std::string_view host = text.substr(0, colon);
  const bool isBracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
  if (isBracketed) host = host.substr(1, host.size() - 2);
  if (!isHost(host, isBracketed)) return wrong();
  return NetAddress{.host = std::string(host), .port = *port};
}

std::string formatNetAddress(const NetAddress& address) {
  const bool isV6 = address.host.find(':') != std::string::npos;
  return isV6 ? fmt::format("[{}]:{}", address.host, address.port) : fmt::format("{}:{}", address.host, address.port);
}

}  // namespace tellurion::io
