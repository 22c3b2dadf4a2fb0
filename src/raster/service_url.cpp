#include "raster/service_url.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace tellurion::raster {
namespace {

constexpr std::string_view kFileScheme = "file://";

struct UrlParts {
  std::string_view beforeQuery, query, fragment;  ///< without ? and #
};

UrlParts partsOf(std::string_view url) {
  UrlParts parts;
  const std::size_t hash = url.find('#');
  if (hash != url.npos) parts.fragment = url.substr(hash + 1);
  url = url.substr(0, hash);
  const std::size_t question = url.find('?');
  parts.beforeQuery = url.substr(0, question);
  if (question != url.npos) parts.query = url.substr(question + 1);
  return parts;
}

std::vector<std::string_view> itemsOf(std::string_view query) {
  std::vector<std::string_view> items;
  while (!query.empty()) {
    const std::size_t end = query.find('&');
    if (end != 0) items.push_back(query.substr(0, end));
    query = end == query.npos ? std::string_view{} : query.substr(end + 1);
  }
  return items;
}

std::string_view keyOf(std::string_view item) {
  return item.substr(0, item.find('='));
}

/// Where the path begins: after scheme and host.
std::size_t pathStart(std::string_view url) {
  const std::size_t scheme = url.find("://");
  if (scheme == url.npos) return 0;
  return std::min(url.find_first_of("/?#", scheme + 3), url.size());
}

struct Authority {
  std::string_view user, host;  ///< user:password, host:port
};

Authority authorityOf(std::string_view url) {
  const std::size_t scheme = url.find("://");
  if (scheme == url.npos) return {};
  const std::string_view all = url.substr(scheme + 3, pathStart(url) - scheme - 3);
  const std::size_t at = all.rfind('@');
  return at == all.npos ? Authority{{}, all} : Authority{all.substr(0, at), all.substr(at + 1)};
}

}  // namespace

std::string lowered(std::string_view text) {
  std::string lower(text);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return lower;
}

std::string percentEncoded(std::string_view text, std::string_view keep) {
  std::string encoded;
  for (const char c : text) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       std::string_view("-._~").find(c) != std::string_view::npos || keep.find(c) != keep.npos;
    if (plain) {
      encoded += c;
    } else {
      encoded += fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
  }
  return encoded;
}

std::string percentDecoded(std::string_view text) {
  const auto digit = [](char c) {
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
                                  : -1;
  };
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '%' && i + 2 < text.size() && digit(text[i + 1]) >= 0 && digit(text[i + 2]) >= 0) {
      decoded += static_cast<char>(digit(text[i + 1]) * 16 + digit(text[i + 2]));
      i += 2;
    } else {
      decoded += text[i];
    }
  }
  return decoded;
}

std::string withQuery(std::string_view base, const QueryItems& items) {
  if (base.size() > io::kLongestUrl) return std::string(base);
  const UrlParts parts = partsOf(base);
  std::string url(parts.beforeQuery);
  char separator = '?';
  for (const std::string_view item : itemsOf(parts.query)) {
    const std::string key = lowered(keyOf(item));
    if (std::ranges::any_of(items, [&](const auto& mine) { return lowered(mine.first) == key; })) continue;
    url += separator;
    url += item;
    separator = '&';
  }
  for (const auto& [key, value] : items) {
    url += separator;
    url += key + '=' + percentEncoded(value, ",:/");
    separator = '&';
  }
  return url;
}

std::optional<std::string> queryValue(std::string_view url, std::string_view key) {
  for (const std::string_view item : itemsOf(partsOf(url).query)) {
    if (lowered(keyOf(item)) != lowered(key)) continue;
    const std::size_t equals = item.find('=');
    return percentDecoded(equals == item.npos ? std::string_view{} : item.substr(equals + 1));
  }
  return std::nullopt;
}

std::string_view withoutQuery(std::string_view url) {
  return partsOf(url).beforeQuery;
}

std::optional<std::string> localPath(std::string_view source) {
  if (source.starts_with(kFileScheme)) return percentDecoded(source.substr(kFileScheme.size()));
  if (source.find("://") != source.npos) return std::nullopt;
  return std::string(source);
}

std::string fileUrl(const std::string& path) {
  std::error_code ignored;
  const std::filesystem::path absolute = std::filesystem::absolute(path, ignored);
  return std::string(kFileScheme) + percentEncoded(absolute.lexically_normal().string(), "/{}:");
}

std::string withCredentialsOf(std::string_view source, std::string_view url) {
  if (std::max(source.size(), url.size()) > io::kLongestUrl) return std::string(url);
  const Authority mine = authorityOf(source);
  const Authority theirs = authorityOf(url);
  if (mine.host.empty() || lowered(mine.host) != lowered(theirs.host)) return std::string(url);
  const std::string scheme = lowered(url.substr(0, url.find("://")));
  if (scheme != "https" && scheme != lowered(source.substr(0, source.find("://")))) return std::string(url);
  std::string result(url);
  if (!mine.user.empty() && theirs.user.empty()) result.insert(url.find("://") + 3, std::string(mine.user) + '@');
  for (const std::string_view item : itemsOf(partsOf(source).query)) {
    if (!io::isSecret(keyOf(item)) || queryValue(url, keyOf(item))) continue;
    result += (result.find('?') == result.npos ? "?" : result.ends_with('?') || result.ends_with('&') ? "" : "&");
    result += item;
  }
  return result;
}

std::string resolvedUrl(std::string_view base, std::string_view reference) {
  if (reference.find("://") != reference.npos) return std::string(reference);
  const std::string_view document = partsOf(base).beforeQuery;
  if (reference.starts_with("//")) return std::string(document.substr(0, document.find("://") + 1)).append(reference);
  if (reference.starts_with('/')) return std::string(document.substr(0, pathStart(document))).append(reference);
  const std::size_t slash = document.rfind('/');
  if (slash == document.npos || slash < pathStart(document))
    return std::string(document) + '/' + std::string(reference);
  return std::string(document.substr(0, slash + 1)).append(reference);
}

}  // namespace tellurion::raster
