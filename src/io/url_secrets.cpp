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

bool isLetterOrDigit(char c) {
  return (c >= '0' && c <= '9') || (lowerOf(c) >= 'a' && lowerOf(c) <= 'z');
}

/// Nobody calls a folder or a layer so.
bool looksLikeAKey(std::string_view part) {
  constexpr std::size_t kShortestKey = 24;
  constexpr std::size_t kUuid = 36;
  const auto isDigit = [](char c) { return c >= '0' && c <= '9'; };
  const bool hasBoth = std::ranges::any_of(part, isDigit) &&
                       std::ranges::any_of(part, [&](char c) { return isLetterOrDigit(c) && !isDigit(c); });
  if (part.size() >= kShortestKey && hasBoth && std::ranges::all_of(part, isLetterOrDigit)) return true;
  if (part.size() != kUuid) return false;
  for (std::size_t i = 0; i < kUuid; ++i) {
    const bool isDash = i == 8 || i == 13 || i == 18 || i == 23;
    const bool isHex = isDigit(part[i]) || (lowerOf(part[i]) >= 'a' && lowerOf(part[i]) <= 'f');
    if (isDash ? part[i] != '-' : !isHex) return false;
  }
  return true;
}

/// A part of a path that says what the next one is.
bool announcesASecret(std::string_view part) {
  constexpr std::array kNames = {"token",    "access_token", "key",  "apikey",    "api_key", "api-key",    "secret",
                                 "password", "passwd",       "auth", "signature", "sig",     "credentials"};
  std::string lower(part);
  std::ranges::transform(lower, lower.begin(), lowerOf);
  return std::ranges::any_of(kNames, [&](const char* name) { return lower == name; });
}

/// What follows scheme and host, up to the query.
std::string pathWithoutSecrets(std::string_view path) {
  std::string shown;
  bool isAnnounced = false;
  while (true) {
    const std::size_t slash = path.find('/');
    const std::string_view part = path.substr(0, slash);
    const std::size_t equals = part.find('=');
    if (!part.empty() && (isAnnounced || looksLikeAKey(part))) {
      shown += "***";
    } else if (equals != part.npos && isSecret(part.substr(0, equals))) {
      shown.append(part.substr(0, equals)).append("=***");
    } else {
      shown += part;
    }
    if (slash == path.npos) return shown;
    isAnnounced = announcesASecret(part);
    shown += '/';
    path = path.substr(slash + 1);
  }
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
  const std::string_view place = url.substr(0, question);
  const std::size_t scheme = place.find("://");
  std::string shown;
  if (scheme == place.npos || place.starts_with("file://")) {
    shown = place;  // a file of this machine lets nobody in
  } else {
    const std::size_t host = scheme + 3 + userOf(place).size();
    const std::size_t path = std::min(place.find('/', host), place.size());
    shown.append(place.substr(0, scheme + 3)).append(place.substr(host, path - host));
    shown += pathWithoutSecrets(place.substr(path));
  }
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
  const bool isSecretive = !userOf(url).empty() || shown.find("***") != shown.npos;
  return isSecretive ? fmt::format("{}#{:08x}", shown, hashOf(url)) : std::string(url);
}

std::string quotedWithoutSecrets(std::string_view text) {
  constexpr std::string_view kBetween = " \t\r\n\"'<>(),";
  std::string shown;
  while (!text.empty()) {
    const std::size_t length = std::min(text.find_first_of(kBetween), text.size());
    const std::string_view word = text.substr(0, length);
    // Neither a path nor a query needs its host to be known.
    constexpr std::string_view kAnyHost = "http://h/";
    const std::size_t key = word.find_first_of("/=?");
    if (key == word.npos) {
      shown += word;
    } else if (word.find("://") != word.npos) {
      shown += withoutSecrets(word);
    } else {
      const std::string_view place = word[key] == '=' ? "?" : "";
      shown += withoutSecrets(std::string(kAnyHost).append(place).append(word)).substr(kAnyHost.size() + place.size());
    }
    if (length < text.size()) shown += text[length];
    text = text.substr(std::min(length + 1, text.size()));
  }
  return shown;
}

}  // namespace tellurion::io
