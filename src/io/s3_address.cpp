#include "io/s3_address.h"

#include <fmt/format.h>

#include <cstdlib>
#include <string_view>

namespace tellurion::io {
namespace {

constexpr std::string_view kScheme = "s3://";

std::string variable(const char* name) {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing in this program changes the environment.
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

std::string firstOf(std::string first, std::string second) {
  return first.empty() ? std::move(second) : std::move(first);
}

/// What a key may be asked for with: letters, digits, and what paths have; the rest is percent-encoded.
std::string encodedPath(std::string_view path) {
  std::string out;
  for (const char c : path) {
    const bool isPlain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                         std::string_view("-_.~/").find(c) != std::string_view::npos;
    out += isPlain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return out;
}

}  // namespace

Result<HttpAddress> httpAddress(const std::string& url) {
  if (!url.starts_with(kScheme)) return HttpAddress{.url = url, .credentials = {}, .signature = {}, .sessionToken = {}};
  const std::string_view place = std::string_view(url).substr(kScheme.size());
  const auto slash = place.find('/');
  const std::string_view bucket = place.substr(0, slash);
  if (bucket.empty() || slash == std::string_view::npos || slash + 1 == place.size())
    return fail(Failure::Code::invalidArgument, "an address of a bucket is s3://BUCKET/KEY", url);
  if (bucket.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.-_") !=
      std::string_view::npos)
    return fail(Failure::Code::invalidArgument, "a bucket's name has letters, digits, dots and dashes", url);
  const std::string key = encodedPath(place.substr(slash + 1));
  const std::string region = firstOf(firstOf(variable("AWS_REGION"), variable("AWS_DEFAULT_REGION")), "us-east-1");
  std::string endpoint = firstOf(variable("AWS_ENDPOINT_URL_S3"), variable("AWS_ENDPOINT_URL"));
  while (endpoint.ends_with('/'))
    endpoint.pop_back();
  HttpAddress out;
  out.url = endpoint.empty() ? fmt::format("https://{}.s3.{}.amazonaws.com/{}", bucket, region, key)
                             : fmt::format("{}/{}/{}", endpoint, bucket, key);
  const std::string id = variable("AWS_ACCESS_KEY_ID");
  const std::string secret = variable("AWS_SECRET_ACCESS_KEY");
  if (id.empty() != secret.empty())
    return fail(Failure::Code::invalidArgument,
                "AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY belong together: set both, or neither for a bucket that "
                "anyone may read",
                url);
  if (id.empty()) return out;
  out.credentials = fmt::format("{}:{}", id, secret);
  out.signature = fmt::format("aws:amz:{}:s3", region);
  out.sessionToken = variable("AWS_SESSION_TOKEN");
  return out;
}

}  // namespace tellurion::io
