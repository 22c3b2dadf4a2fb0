#pragma once

#include <string>

#include "io/failure.h"

namespace tellurion::io {

/// How something is asked for over HTTP.
struct HttpAddress {
  std::string url;
  std::string credentials;   ///< "KEY:SECRET" to sign requests with; empty: they are not signed
  std::string signature;     ///< libcurl's CURLOPT_AWS_SIGV4: provider, region and service
  std::string sessionToken;  ///< of temporary credentials
};

/// Of "s3://BUCKET/KEY", as the environment says: AWS_ENDPOINT_URL_S3 or AWS_ENDPOINT_URL (a server of one's own, the
/// bucket is the first part of its path), AWS_REGION or AWS_DEFAULT_REGION (us-east-1), AWS_ACCESS_KEY_ID,
/// AWS_SECRET_ACCESS_KEY and AWS_SESSION_TOKEN (without keys requests are not signed, for buckets that anyone may
/// read). Any other URL stays as it is. Fails on an address without a bucket and on a key without its secret.
Result<HttpAddress> httpAddress(const std::string& url);

}  // namespace tellurion::io
