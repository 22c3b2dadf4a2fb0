#include "io/transfer.h"

#include <curl/curl.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <new>
#include <span>
#include <utility>

#include "io/s3_address.h"
#include "io/url_secrets.h"

namespace tellurion::io {
namespace {

constexpr long kMostRedirects = 5;
constexpr std::uint64_t kMostHeaderBytes = 256 << 10;
// Slower than this for the time of a stall is a stall.
constexpr long kStalled_bytesPerSecond = 256;

// What S3 wants to be told of a request's body, which is signed with it: SHA-256 of nothing.
constexpr const char* kNoBody =
    "x-amz-content-sha256: e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";

std::string sizeText(std::uint64_t bytes) {
  return bytes >= 1 << 20 ? fmt::format("{} MiB", bytes >> 20) : fmt::format("{} bytes", bytes);
}

TransferEnd ended(TransferEnd::Kind kind, std::string reason) {
  return {.kind = kind, .reason = std::move(reason)};
}

TransferEnd endOfStatus(long status) {
  using Kind = TransferEnd::Kind;
  switch (status) {
    case 200:
    case 203:
      return ended(Kind::body, {});
    case 204:
    case 404:
    case 410:
      return ended(Kind::nothing, {});
    case 304:
      return ended(Kind::notModified, {});
    case 401:
      return ended(Kind::refused, "the server wants a name and password, or a key (status 401)");
    case 403:
      return ended(Kind::refused, "the server does not allow this (status 403)");
    case 429:
      return ended(Kind::hostTrouble, "the server asks for fewer requests (status 429)");
    case 202:
    case 408:
    case 425:
      return ended(Kind::badAnswer, fmt::format("the server is not ready to answer (status {})", status));
    default:
      if (status / 100 == 3)
        return ended(Kind::refused, fmt::format("the bucket is somewhere else, set AWS_REGION or AWS_ENDPOINT_URL "
                                                "(status {})",
                                                status));
      if (status >= 500) return ended(Kind::badAnswer, fmt::format("the server failed (status {})", status));
      return ended(Kind::refused, fmt::format("the server refused the request (status {})", status));
  }
}

TransferEnd endOfFailure(CURLcode code, const TransferRequest& request, bool connected, bool redirected) {
  using Kind = TransferEnd::Kind;
  switch (code) {
    case CURLE_URL_MALFORMAT:
    case CURLE_UNSUPPORTED_PROTOCOL:
      if (redirected)
        return ended(Kind::refused,
                     fmt::format("the server redirects to what cannot be asked ({})", curl_easy_strerror(code)));
      return ended(Kind::badAnswer, "the server answered with something else than HTTP");
    case CURLE_FILESIZE_EXCEEDED:
      return ended(Kind::badAnswer,
                   "the answer is larger than the " + sizeText(request.maxBytes) + " that are allowed");
    case CURLE_PARTIAL_FILE:
      return ended(Kind::badAnswer, "the answer broke off before its end");
    case CURLE_TOO_MANY_REDIRECTS:
      return ended(Kind::badAnswer, fmt::format("the server redirected more than {} times", kMostRedirects));
    case CURLE_BAD_CONTENT_ENCODING:
      return ended(Kind::badAnswer, "the answer's compression is damaged");
    case CURLE_OPERATION_TIMEDOUT:
      if (!connected)
        return ended(Kind::hostTrouble, fmt::format("no connection within {:g} s", request.connectTimeout_s));
      return ended(Kind::badAnswer, fmt::format("nothing to speak of came for {:g} s", request.stallTimeout_s));
    case CURLE_COULDNT_RESOLVE_HOST:
      return ended(Kind::hostTrouble, "no such host, or no network");
    case CURLE_COULDNT_CONNECT:
      return ended(Kind::hostTrouble, "no server answers there");
    case CURLE_SSL_CONNECT_ERROR:
    case CURLE_PEER_FAILED_VERIFICATION:
      return ended(Kind::hostTrouble, fmt::format("no secure connection ({})", curl_easy_strerror(code)));
    case CURLE_GOT_NOTHING:
    case CURLE_RECV_ERROR:
    case CURLE_SEND_ERROR:
      return ended(Kind::badAnswer, fmt::format("the connection broke ({})", curl_easy_strerror(code)));
    default:
      return ended(connected ? Kind::badAnswer : Kind::hostTrouble, curl_easy_strerror(code));
  }
}

void initialise() {
  static std::once_flag once;
  std::call_once(once, [] { curl_global_init(CURL_GLOBAL_DEFAULT); });
}

}  // namespace

Transfer::Transfer(TransferRequest request, BytesInFlight& inFlight)
    : request_(std::move(request)), inFlight_(inFlight) {
  initialise();
  handle_ = curl_easy_init();
  if (handle_ == nullptr) throw std::bad_alloc();
  configure();
}

Transfer::~Transfer() {
  inFlight_.now -= counted_;
  curl_easy_cleanup(handle_);
  curl_slist_free_all(static_cast<curl_slist*>(lines_));
}

void Transfer::configure() {
  CURL* const easy = handle_;
  // One that cannot be asked for has no host, and so never comes here.
  const HttpAddress address = httpAddress(request_.url).value_or(HttpAddress{});
  curl_easy_setopt(easy, CURLOPT_URL, address.url.c_str());
  curl_easy_setopt(easy, CURLOPT_USERAGENT, "Tellurion/0.1");
  curl_easy_setopt(easy, CURLOPT_NOSIGNAL, 1L);
  // A slow name server must not hold up the thread of all transfers when one of them is given up.
  curl_easy_setopt(easy, CURLOPT_QUICK_EXIT, 1L);
  curl_easy_setopt(easy, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(easy, CURLOPT_REDIR_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(easy, CURLOPT_FOLLOWLOCATION, 1L);
  curl_easy_setopt(easy, CURLOPT_MAXREDIRS, kMostRedirects);
  curl_easy_setopt(easy, CURLOPT_HTTP_VERSION, static_cast<long>(CURL_HTTP_VERSION_2TLS));
  // Wait for a connection that can carry many requests, but only where there may be one.
  curl_easy_setopt(easy, CURLOPT_PIPEWAIT, address.url.starts_with("https") ? 1L : 0L);
  if (!request_.authorities.empty()) curl_easy_setopt(easy, CURLOPT_CAINFO, request_.authorities.c_str());
  curl_easy_setopt(easy, CURLOPT_ACCEPT_ENCODING, "");
  curl_easy_setopt(easy, CURLOPT_CONNECTTIMEOUT_MS, std::lround(request_.connectTimeout_s * 1000.0));
  curl_easy_setopt(easy, CURLOPT_LOW_SPEED_LIMIT, kStalled_bytesPerSecond);
  curl_easy_setopt(easy, CURLOPT_LOW_SPEED_TIME, std::lround(std::ceil(request_.stallTimeout_s)));
  curl_easy_setopt(easy, CURLOPT_MAXFILESIZE_LARGE, static_cast<curl_off_t>(request_.maxBytes));
  curl_easy_setopt(easy, CURLOPT_HEADERFUNCTION, &Transfer::onHeader);
  curl_easy_setopt(easy, CURLOPT_HEADERDATA, this);
  curl_easy_setopt(easy, CURLOPT_WRITEFUNCTION, &Transfer::onBody);
  curl_easy_setopt(easy, CURLOPT_WRITEDATA, this);
  curl_slist* lines = nullptr;
  if (!request_.etag.empty()) lines = curl_slist_append(lines, ("If-None-Match: " + request_.etag).c_str());
  if (!request_.lastModified.empty())
    lines = curl_slist_append(lines, ("If-Modified-Since: " + request_.lastModified).c_str());
  if (!address.credentials.empty()) {
    // What is signed for one host is of no use to another, and nobody else's to see.
    curl_easy_setopt(easy, CURLOPT_FOLLOWLOCATION, 0L);
    curl_easy_setopt(easy, CURLOPT_AWS_SIGV4, address.signature.c_str());
    curl_easy_setopt(easy, CURLOPT_USERPWD, address.credentials.c_str());
    lines = curl_slist_append(lines, kNoBody);
    if (!address.sessionToken.empty())
      lines = curl_slist_append(lines, ("x-amz-security-token: " + address.sessionToken).c_str());
  }
  curl_easy_setopt(easy, CURLOPT_HTTPHEADER, lines);
  lines_ = lines;
}

std::size_t Transfer::onHeader(const char* data, std::size_t size, std::size_t count, void* self) {
  Transfer& transfer = *static_cast<Transfer*>(self);
  transfer.headerBytes_ += size * count;
  transfer.receivedBytes_ += size * count;
  if (transfer.headerBytes_ > kMostHeaderBytes) {
    transfer.tooLarge_ = true;
    return 0;
  }
  transfer.headers_.read({data, size * count});
  return size * count;
}

// Counts what has been unpacked: the length that a server states is that of the packed bytes.
std::size_t Transfer::onBody(const char* data, std::size_t size, std::size_t count, void* self) {
  Transfer& transfer = *static_cast<Transfer*>(self);
  const std::span<const std::byte> bytes = std::as_bytes(std::span(data, size * count));
  BytesInFlight& all = transfer.inFlight_;
  if (all.now + bytes.size() > all.budget && !transfer.mayExceed_) {
    transfer.isPaused_ = true;  // the same bytes come again
    return CURL_WRITEFUNC_PAUSE;
  }
  transfer.receivedBytes_ += bytes.size();
  if (transfer.body_.size() + bytes.size() > transfer.request_.maxBytes) {
    transfer.tooLarge_ = true;
    return 0;
  }
  transfer.body_.insert(transfer.body_.end(), bytes.begin(), bytes.end());
  transfer.counted_ += bytes.size();
  all.now += bytes.size();
  all.most = std::max(all.most, all.now);
  return bytes.size();
}

void Transfer::resume() {
  if (!std::exchange(isPaused_, false)) return;
  curl_easy_pause(handle_, CURLPAUSE_CONT);
}

TransferEnd Transfer::end(int curlCode) {
  const auto code = static_cast<CURLcode>(curlCode);
  if (tooLarge_) return endOfFailure(CURLE_FILESIZE_EXCEEDED, request_, true, false);
  long status = 0;
  long connections = 0;
  curl_off_t connect_us = 0;
  curl_easy_getinfo(handle_, CURLINFO_RESPONSE_CODE, &status);
  curl_easy_getinfo(handle_, CURLINFO_NUM_CONNECTS, &connections);
  curl_easy_getinfo(handle_, CURLINFO_CONNECT_TIME_T, &connect_us);
  // A transfer over a connection that was open already made none.
  const bool connected = connections == 0 || connect_us > 0;
  TransferEnd result =
      code == CURLE_OK ? endOfStatus(status) : endOfFailure(code, request_, connected, status / 100 == 3);
  result.headers = std::move(headers_);
  if (result.kind == TransferEnd::Kind::notModified && request_.etag.empty() && request_.lastModified.empty())
    return ended(TransferEnd::Kind::badAnswer, "the server says 'not modified' of what it was never asked about");
  if (result.kind == TransferEnd::Kind::body)
    result.resource = {.bytes = std::move(body_), .contentType = mimeType(result.headers.contentType)};
  return result;
}

Result<std::string> hostOf(const std::string& url) {
  initialise();
  if (url.size() > kLongestUrl) {
    return fail(Failure::Code::invalidArgument,
                fmt::format("a URL of {} bytes; at most {} are asked for", url.size(), kLongestUrl),
                url.substr(0, url.find('?')).substr(0, 200));
  }
  const auto address = httpAddress(url);
  if (!address) return tl::unexpected(address.error());
  const std::unique_ptr<CURLU, decltype(&curl_url_cleanup)> parsed(curl_url(), &curl_url_cleanup);
  const CURLUcode code = curl_url_set(parsed.get(), CURLUPART_URL, address->url.c_str(), 0);
  if (code != CURLUE_OK)
    return fail(Failure::Code::invalidArgument, fmt::format("not a URL ({})", curl_url_strerror(code)), url);
  const auto part = [&](CURLUPart which) {
    char* text = nullptr;
    curl_url_get(parsed.get(), which, &text, CURLU_DEFAULT_PORT);
    std::string result(text == nullptr ? "" : text);
    curl_free(text);
    return result;
  };
  const std::string scheme = part(CURLUPART_SCHEME);
  if (scheme != "http" && scheme != "https")
    return fail(Failure::Code::invalidArgument, "only http, https, s3 and file addresses can be asked for", url);
  return fmt::format("{}://{}:{}", scheme, part(CURLUPART_HOST), part(CURLUPART_PORT));
}

}  // namespace tellurion::io
