#pragma once

#include <cstddef>
#include <string>
#include <string_view>

/// What of a URL lets somebody in. Pure text. In a path only these are known as such: the part after one that is called
/// token, key, apikey, secret, password, auth, signature or the like, values of parts like token=..., and parts that
/// look like nothing else: UUIDs, and 24 letters and digits or more without anything between.
namespace tellurion::io {

/// Bytes; longer URLs are never asked for. Servers take 8,000 or so.
inline constexpr std::size_t kLongestUrl = 16384;

/// Of a query's key: token, key, password, signature and their like.
bool isSecret(std::string_view key);

/// For messages and names: user and password are left out, secrets of the path and of the query are '***', and there is
/// no fragment.
std::string withoutSecrets(std::string_view url);

/// Text of a server, which may quote what it was asked: URLs in it, and words that hold a path or a query, are as
/// withoutSecrets() has them.
std::string quotedWithoutSecrets(std::string_view text);

/// The URL as it may be kept on disk: itself where it holds no secret, else withoutSecrets() and a hash of 32 bits of
/// the whole, which tells accounts apart and is too short to tell a password by.
std::string keptUrl(std::string_view url);

}  // namespace tellurion::io
