#include "io/url_secrets.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>

namespace tellurion::io {
namespace {

char lowerOf(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

/// Where user and password stand, with the @; empty: there are none.
std::string_view userOf(std::string_view url) {
  const std::size_t scheme = url.find("://");
  if (scheme == url.npos) return {};
  const std::size_t first = scheme + 3;
  const std::string_view authority = url.substr(first, url.find_first_of("/?#", first) - first);
  const std::size_t at = authority.rfind('@');
  return at == authority.npos ? std::string_view{} : authority.substr(0, at + 1);
}

// FNV-1a.
std::uint32_t hashOf(std::string_view text) {
  std::uint32_t hash = 0x811c9dc5;
  for (const char c : text)
    hash = (hash ^ static_cast<unsigned char>(c)) * 0x01000193;
  return hash;
}

}  // namespace

bool isSecret(std::string_view key) {
  constexpr std::array kSecrets = {"token", "key", "passw", "pwd", "secret", "sig", "auth", "credential"};
  std::string lower(key);
  std::ranges::transform(lower, lower.begin(), lowerOf);
  return std::ranges::any_of(kSecrets, [&](const char* word) { return lower.find(word) != lower.npos; });
}

std::string withoutSecrets(std::string_view url) {
  url = url.substr(0, url.find('#'));
  const std::size_t question = url.find('?');
  std::string shown(url.substr(0, question));
  if (const std::string_view user = userOf(url); !user.empty()) shown.erase(url.find("://") + 3, user.size());
  std::string_view query = question == url.npos ? std::string_view{} : url.substr(question + 1);
  char separator = '?';
  while (!query.empty()) {
    const std::size_t end = query.find('&');
    const std::string_view item = query.substr(0, end);
    query = end == query.npos ? std::string_view{} : query.substr(end + 1);
    if (item.empty()) continue;
    const std::string_view key = item.substr(0, item.find('='));
    shown += separator;
    shown += isSecret(key) ? std::string(key) + "=***" : std::string(item);
    separator = '&';
  }
  return shown;
}

std::string keptUrl(std::string_view url) {
  const std::string shown = withoutSecrets(url);
  const bool isSecretive = !userOf(url).empty() || shown.find("=***") != shown.npos;
  return isSecretive ? fmt::format("{}#{:08x}", shown, hashOf(url)) : std::string(url);
}

}  // namespace tellurion::io
