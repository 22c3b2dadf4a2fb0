#include "io/keyed_hash.h"

#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <openssl/rand.h>

#include <cassert>

namespace tellurion::io {
namespace {

unsigned char* bytesOf(Digest& digest) {
  return reinterpret_cast<unsigned char*>(digest.data());
}

}  // namespace

Digest keyedHash(std::string_view key, std::string_view text) {
  Digest digest{};
  unsigned int length = 0;
  [[maybe_unused]] const unsigned char* done =
      HMAC(EVP_sha256(), key.data(), static_cast<int>(key.size()), reinterpret_cast<const unsigned char*>(text.data()),
           text.size(), bytesOf(digest), &length);
  assert(done != nullptr && length == digest.size());
  return digest;
}

bool isSameDigest(std::string_view a, std::string_view b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

Result<Digest> unguessableBytes() {
  Digest bytes{};
  if (RAND_bytes(bytesOf(bytes), static_cast<int>(bytes.size())) != 1)
    return fail(Failure::Code::ioError, "the system's generator of random bytes does not answer");
  return bytes;
}

}  // namespace tellurion::io
