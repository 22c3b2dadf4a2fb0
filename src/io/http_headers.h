#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace tellurion::io {

/// Times by the clock on the wall: seconds since 1970-01-01T00:00:00Z.
using UnixSeconds = std::int64_t;

UnixSeconds wallClock();  ///< now

/// What an answer's header says about keeping the answer. Times as the server wrote them, unchecked.
struct HttpHeaders {
  std::string contentType;
  std::string cacheControl;
  std::string expires;
  std::string date;
  std::string age;
  std::string retryAfter;
  std::string etag;
  std::string lastModified;

  /// Takes in one line as it came, "Name: value" with any line end; a status line begins a new answer (after a
  /// redirect or an interim answer) and forgets the last one's. Lines of no interest pass.
  void read(std::string_view line);
};

/// Whether an answer may be kept, and until when it is good without asking again.
struct Freshness {
  bool store = true;
  UnixSeconds expires = 0;
};

/// RFC 9111 as a private cache reads it: Cache-Control (no-store, no-cache, max-age) before Expires, Age taken off. A
/// header that says nothing or nonsense: a day. Never further ahead than a year.
Freshness freshnessOf(const HttpHeaders& headers, UnixSeconds now);

/// Retry-After in seconds from now, given as seconds or as a date; 0 .. 600, what is more counts as 600. Nothing: not
/// said, or nonsense.
std::optional<double> retryAfter_s(const HttpHeaders& headers, UnixSeconds now);

/// "Image/PNG; charset=x" -> "image/png".
std::string mimeType(std::string_view contentType);

}  // namespace tellurion::io
