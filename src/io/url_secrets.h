#pragma once

#include <string>
#include <string_view>

/// What of a URL lets somebody in. Pure text; what stands in a path is not known as such.
namespace tellurion::io {

/// Of a query's key: token, key, password, signature and their like.
bool isSecret(std::string_view key);

/// For messages and names: user and password are left out, values of secret keys are '***', and there is no fragment.
std::string withoutSecrets(std::string_view url);

/// The URL as it may be kept on disk: itself where it holds no secret, else withoutSecrets() and a hash of 32 bits of
/// the whole, which tells accounts apart and is too short to tell a password by.
std::string keptUrl(std::string_view url);

}  // namespace tellurion::io
