#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/url_secrets.h"

/// URLs of map servers: pure text.
namespace tellurion::raster {

using QueryItems = std::vector<std::pair<std::string, std::string>>;

/// `base` with the items as its query. What the base's own query already says stays (map=..., a token), but for keys of
/// `items`, which are replaced whatever their case. Values are percent-encoded, except for , : / which servers expect.
/// A base longer than io::kLongestUrl stays as it is: nothing is asked for there, and it may be megabytes long.
std::string withQuery(std::string_view base, const QueryItems& items);

/// The value of a key of the query, decoded, the key in any case; nothing: it is not there.
std::optional<std::string> queryValue(std::string_view url, std::string_view key);

/// The URL up to its query.
std::string_view withoutQuery(std::string_view url);

std::string percentEncoded(std::string_view text, std::string_view keep = {});
std::string percentDecoded(std::string_view text);

using io::withoutSecrets;

/// `url`, which a document of `source` names, with what `source` needs to be let in: user and password, keys and tokens
/// of its query. Only to the same host, by the same
/// protocol or by https; another one is told nothing. Likewise for URLs longer than io::kLongestUrl.
std::string withCredentialsOf(std::string_view source, std::string_view url);

/// The path of file://... or of what is no URL at all; nothing: it is somewhere else.
std::optional<std::string> localPath(std::string_view source);

/// The file:// URL of a path, made absolute; braces of templates stay.
std::string fileUrl(const std::string& path);

/// `reference` as it is meant inside the document at `base` (both URLs, http, https or file).
std::string resolvedUrl(std::string_view base, std::string_view reference);

/// ASCII letters only.
std::string lowered(std::string_view text);

}  // namespace tellurion::raster
