#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "io/http_headers.h"
#include "io/resources.h"

namespace tellurion::io {

/// What all transfers of a fetcher hold of bodies that are not whole yet. One thread only.
struct BytesInFlight {
  std::uint64_t budget = 0;  ///< above it transfers wait, but for those that may exceed it
  std::uint64_t now = 0;
  std::uint64_t most = 0;
};

/// One request to a server.
struct TransferRequest {
  std::string url;
  std::uint64_t maxBytes = 0;
  std::string etag;          ///< of what we have: the server may say that it is still good
  std::string lastModified;  ///< likewise
  std::string authorities;   ///< a file of certificates; empty: those of the system
  double connectTimeout_s = 10.0;
  double stallTimeout_s = 30.0;
};

/// How a request ended.
struct TransferEnd {
  enum class Kind {
    body,         ///< resource
    nothing,      ///< there is nothing at this place
    notModified,  ///< what we have is still good
    refused,      ///< asking again would not help
    badAnswer,    ///< something else than what was asked for: this URL is asked again later
    hostTrouble,  ///< a failure that says something of the whole host
  };
  Kind kind = Kind::hostTrouble;
  Resource resource;
  HttpHeaders headers;
  std::string reason;  ///< of a failure: half a sentence
};

/// A libcurl transfer: its settings, and what has come so far. One thread only, and pinned: libcurl holds its address.
class Transfer {
 public:
  Transfer(TransferRequest request, BytesInFlight& inFlight);
  ~Transfer();
  Transfer(const Transfer&) = delete;
  Transfer& operator=(const Transfer&) = delete;

  void* handle() const { return handle_; }  ///< a CURL*
  std::uint64_t receivedBytes() const { return receivedBytes_; }
  /// It waits for others to end, since what all hold together is over the budget.
  bool isPaused() const { return isPaused_; }
  /// Whether it goes on whatever the budget, from now on; one at least must be able to end.
  void setMayExceed(bool may) { mayExceed_ = may; }
  void resume();  ///< lets it go on
  /// After its end, with libcurl's result code; takes the body out.
  TransferEnd end(int curlCode);

 private:
  static std::size_t onHeader(const char* data, std::size_t size, std::size_t count, void* self);
  static std::size_t onBody(const char* data, std::size_t size, std::size_t count, void* self);
  void configure();

  TransferRequest request_;
  void* handle_ = nullptr;
  void* lines_ = nullptr;  // request header, a curl_slist*
  HttpHeaders headers_;
  std::vector<std::byte> body_;
  std::uint64_t headerBytes_ = 0;
  std::uint64_t receivedBytes_ = 0;
  bool tooLarge_ = false;
  BytesInFlight& inFlight_;
  bool isPaused_ = false;
  bool mayExceed_ = false;
  std::uint64_t counted_ = 0;  ///< of inFlight_
};

/// "http://host:port" of an http or https URL; a failure says what is wrong with it.
Result<std::string> hostOf(const std::string& url);

}  // namespace tellurion::io
