#include "io/http_headers.h"

#include <curl/curl.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <utility>

namespace tellurion::io {
namespace {

constexpr UnixSeconds kDay_s = 86'400;
constexpr UnixSeconds kYear_s = 365 * kDay_s;
constexpr UnixSeconds kLongestRetryAfter_s = 600;

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

bool equalWithoutCase(std::string_view a, std::string_view b) {
  return std::ranges::equal(a, b, [](char x, char y) { return lower(x) == lower(y); });
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n\"";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

// Whole seconds, not negative; more digits than fit count as a lot.
std::optional<UnixSeconds> seconds(std::string_view text) {
  UnixSeconds value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size() || text.empty() || text.front() == '-') return std::nullopt;
  return error == std::errc::result_out_of_range ? kYear_s : std::min(value, kYear_s);
}

std::optional<UnixSeconds> httpDate(const std::string& text) {
  const std::int64_t time = curl_getdate(text.c_str(), nullptr);
  if (text.empty() || time < 0) return std::nullopt;
  return time;
}

struct CacheControl {
  bool noStore = false;
  bool noCache = false;
  std::optional<UnixSeconds> maxAge;
};

CacheControl readCacheControl(std::string_view text) {
  CacheControl result;
  while (!text.empty()) {
    const std::size_t comma = std::min(text.find(','), text.size());
    const std::string_view directive = trimmed(text.substr(0, comma));
    text.remove_prefix(std::min(comma + 1, text.size()));
    const std::size_t equals = std::min(directive.find('='), directive.size());
    const std::string_view name = trimmed(directive.substr(0, equals));
    if (equalWithoutCase(name, "no-store")) result.noStore = true;
    if (equalWithoutCase(name, "no-cache")) result.noCache = true;
    if (equalWithoutCase(name, "max-age") && equals < directive.size())
      result.maxAge = seconds(trimmed(directive.substr(equals + 1)));
  }
  return result;
}

}  // namespace

UnixSeconds wallClock() {
  return std::chrono::duration_cast<std::chrono::seconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

void HttpHeaders::read(std::string_view line) {
  if (line.starts_with("HTTP/")) {
    *this = {};
    return;
  }
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos) return;
  const std::array<std::pair<std::string_view, std::string*>, 8> fields{{{"content-type", &contentType},
                                                                         {"cache-control", &cacheControl},
                                                                         {"expires", &expires},
                                                                         {"date", &date},
                                                                         {"age", &age},
                                                                         {"retry-after", &retryAfter},
                                                                         {"etag", &etag},
                                                                         {"last-modified", &lastModified}}};
  for (const auto& [name, field] : fields) {
    if (!equalWithoutCase(line.substr(0, colon), name)) continue;
    // An ETag goes back as it came, quotes and all.
    const std::string_view value = line.substr(colon + 1);
    const std::size_t first = std::min(value.find_first_not_of(" \t"), value.size());
    const std::size_t last = value.find_last_not_of(" \t\r\n");
    const std::string text(last == std::string_view::npos ? "" : value.substr(first, last + 1 - first));
    // Cache-Control may be spread over several lines.
    if (field == &cacheControl && !field->empty()) {
      *field += ", " + text;
    } else {
      *field = text;
    }
  }
}

Freshness freshnessOf(const HttpHeaders& headers, UnixSeconds now) {
  const CacheControl control = readCacheControl(headers.cacheControl);
  Freshness result{.store = !control.noStore, .expires = now + kDay_s};
  const UnixSeconds age = seconds(trimmed(headers.age)).value_or(0);
  if (control.noCache) {
    result.expires = now;
  } else if (control.maxAge) {
    result.expires = now + *control.maxAge - age;
  } else if (!headers.expires.empty()) {
    // "0" and other nonsense mean: already expired (RFC 9111, 5.3).
    const UnixSeconds sent = httpDate(headers.date).value_or(now);
    const std::optional<UnixSeconds> expires = httpDate(headers.expires);
    result.expires = expires ? now + (*expires - sent) - age : now;
  }
  result.expires = std::clamp(result.expires, now, now + kYear_s);
  return result;
}

std::optional<double> retryAfter_s(const HttpHeaders& headers, UnixSeconds now) {
  std::optional<UnixSeconds> wait = seconds(trimmed(headers.retryAfter));
  if (!wait) {
    const std::optional<UnixSeconds> date = httpDate(headers.retryAfter);
    if (!date) return std::nullopt;
    wait = *date - now;
  }
  return static_cast<double>(std::clamp<UnixSeconds>(*wait, 0, kLongestRetryAfter_s));
}

std::string mimeType(std::string_view contentType) {
  std::string result(trimmed(contentType.substr(0, contentType.find(';'))));
  std::ranges::transform(result, result.begin(), lower);
  return result;
}

}  // namespace tellurion::io
