#include "raster/service_discovery.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <utility>

#include "raster/near_names.h"
#include "raster/service_exception.h"
#include "raster/service_url.h"
#include "raster/xyz_service.h"

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;
using namespace std::string_view_literals;

constexpr double kPatienceWithGuess_s = 8.0;  // some servers fail, with 500, on what they are not
const std::vector<std::string> kTypes = {"wms", "wmts", "tms", "xyz", "worldwind"};

struct Attempt {
  std::string type;
  std::string url;
};

/// What a document is by its root; empty: none of ours.
std::string typeOf(const XmlElement& root) {
  if (root.name == "WMS_Capabilities" || root.name == "WMT_MS_Capabilities") return "wms";
  if (root.name == "Capabilities" && root.child("Contents") != nullptr) return "wmts";
  if (root.name == "TileMap" || root.name == "TileMapService") return "tms";
  return isWorldWindConfiguration(root) ? "worldwind" : "";
}

template <class T>
io::Result<FoundService> described(FoundService found, io::Result<T> description) {
  if (!description) return tl::unexpected(description.error());
  found.description = *std::move(description);
  return found;
}

io::Result<FoundService> readDocument(const XmlElement& root, const std::string& url) {
  const std::string where = withoutSecrets(url);
  FoundService found{typeOf(root), url, {}};
  if (found.type == "wms") return described(std::move(found), parseWmsCapabilities(root, where));
  if (found.type == "wmts") return described(std::move(found), parseWmtsCapabilities(root, where));
  if (found.type == "worldwind") return described(std::move(found), parseWorldWindConfiguration(root, where));
  if (root.name == "TileMap") return described(std::move(found), parseTileMap(root, where));
  if (found.type == "tms") return described(std::move(found), parseTileMapService(root, where));
  if (const auto text = serviceExceptionText(root)) return io::fail(Code::ioError, "the server says: " + *text, where);
  return io::fail(Code::corrupt, fmt::format("no document of a map service is there, but a <{}>", onOneLine(root.name)),
                  where);
}

std::string wmsUrl(const ServiceLayer& entry) {
  QueryItems items = {{"SERVICE", "WMS"}, {"REQUEST", "GetCapabilities"}};
  if (!entry.version.empty()) items.emplace_back("VERSION", entry.version);
  return withQuery(entry.source, items);
}

std::string wmtsUrl(const std::string& source) {
  return withQuery(source, {{"SERVICE", "WMTS"}, {"REQUEST", "GetCapabilities"}, {"VERSION", "1.0.0"}});
}

std::string tmsUrl(const std::string& source) {
  const std::size_t question = std::min(source.find('?'), source.size());
  std::string path = source.substr(0, question);
  if (!path.ends_with('/')) path += '/';
  return path + "tilemapresource.xml" + source.substr(question);
}

bool asksForDocument(const std::string& url) {
  return lowered(withoutQuery(url)).ends_with(".xml") ||
         lowered(queryValue(url, "request").value_or("")) == "getcapabilities";
}

/// Where the document may be, the likeliest first.
std::vector<Attempt> attemptsFor(const ServiceLayer& entry) {
  const std::string& source = entry.source;
  const std::string service = entry.type.empty() ? lowered(queryValue(source, "service").value_or("")) : entry.type;
  if (asksForDocument(source)) {
    const bool otherVersion = service == "wms" && !entry.version.empty() && !lowered(source).ends_with(".xml");
    return {{service, otherVersion ? wmsUrl(entry) : source}};
  }
  if (service == "wms") return {{"wms", wmsUrl(entry)}};
  if (service == "wmts") return {{"wmts", wmtsUrl(source)}};
  if (service == "tms") return {{"tms", tmsUrl(source)}, {"tms", source}};
  return {{"wms", wmsUrl(entry)}, {"wmts", wmtsUrl(source)}, {"tms", tmsUrl(source)}, {"", source}};
}

/// Whatever is asked for there, the answer will be the same: what it is; empty: it is about what was asked for.
std::string troubleOfTheServer(const io::Failure& failure) {
  if (failure.code == Code::invalidArgument) return failure.message;
  for (const char* words : {"no server answers there", "no such host, or no network"})
    if (failure.message.find(words) != failure.message.npos) return words;
  return {};
}

io::Result<FoundService> findOnServer(const ServiceLayer& entry, io::Resources& resources) {
  std::string reasons;
  Code code = Code::notFound;
  const std::vector<Attempt> attempts = attemptsFor(entry);
  for (const Attempt& attempt : attempts) {
    const auto root =
        fetchDocument(attempt.url, resources, attempts.size() == 1 ? kDocumentPatience_s : kPatienceWithGuess_s);
    auto found = root ? readDocument(*root, attempt.url) : tl::unexpected(root.error());
    if (found && (attempt.type.empty() || found->type == attempt.type || entry.type.empty())) return found;
    if (attempts.size() == 1) {
      if (!found) return found;
      return io::fail(Code::invalidArgument,
                      fmt::format("this is a source of type {}, not {}", found->type, entry.type),
                      withoutSecrets(entry.source));
    }
    if (!found)
      if (const std::string trouble = troubleOfTheServer(found.error()); !trouble.empty())
        return io::fail(found.error().code, trouble, withoutSecrets(entry.source));
    code = found ? code : found.error().code;
    if (!found) reasons += fmt::format("\n  {}", io::describe(found.error()));
  }
  return io::fail(
      code, "no map service is found there; a slow one is waited for when its type is given. What was asked:" + reasons,
      withoutSecrets(entry.source));
}

/// What begins like another format's file than XML's; empty: nothing known.
std::string_view pictureFormat(const std::string& path) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 8> kBeginnings = {{{"\xFF\xD8\xFF", "a JPEG"},
                                                                                         {"\x89PNG", "a PNG"},
                                                                                         {"II*\0"sv, "a TIFF"},
                                                                                         {"MM\0*"sv, "a TIFF"},
                                                                                         {"II+\0"sv, "a TIFF"},
                                                                                         {"MM\0+"sv, "a TIFF"},
                                                                                         {"GIF8", "a GIF"},
                                                                                         {"RIFF", "a WebP"}}};
  std::array<char, 4> first{};
  std::ifstream(path, std::ios::binary).read(first.data(), first.size());
  for (const auto& [beginning, format] : kBeginnings)
    if (std::string_view(first.data(), first.size()).starts_with(beginning)) return format;
  return {};
}

io::Result<FoundService> findHere(const std::string& path, io::Resources& resources) {
  std::error_code ignored;
  const std::size_t colon = path.find(":/");
  const bool isThere = std::filesystem::exists(path, ignored);
  if (!isThere && colon != path.npos && colon > 1 && path.find('/') > colon) {
    return io::fail(
        Code::invalidArgument,
        fmt::format("unknown scheme '{}'; there are http://, https:// and file://, and paths", path.substr(0, colon)),
        path);
  }
  if (!isThere) return io::fail(Code::notFound, "no such file", path);
  if (const std::string_view format = pictureFormat(path); !format.empty()) {
    return io::fail(Code::invalidArgument,
                    fmt::format("this is {}, a raster and no service's document; name it where a scene is asked for "
                                "(view, render), as a layer's source in a scene file, or give it to build",
                                format),
                    path);
  }
  const bool isFolder = std::filesystem::is_directory(path, ignored);
  const std::string document = isFolder ? (std::filesystem::path(path) / "tilemapresource.xml").string() : path;
  if (isFolder && !std::filesystem::exists(document, ignored)) {
    return io::fail(Code::notFound,
                    "the folder has no tilemapresource.xml; name its tiles by a template (FOLDER/{z}/{x}/{y}.png), or "
                    "with type = \"worldwind\"",
                    path);
  }
  const auto root = fetchDocument(document, resources);
  if (!root) return tl::unexpected(root.error());
  return readDocument(*root, fileUrl(document));
}

}  // namespace

io::Result<XmlElement> fetchDocument(const std::string& source, io::Resources& resources, double patience_s) {
  const auto path = localPath(source);
  const std::string where = path ? *path : withoutSecrets(source);
  io::ResourceRequest request;
  request.url = path ? fileUrl(*path) : source;
  request.dataset = where;
  request.maxBytes = kMaxXmlBytes;
  const auto resource = resources.wait(request, patience_s);
  if (!resource) return io::fail(resource.error().code, resource.error().message, where);
  if (*resource == nullptr) return io::fail(Code::notFound, "there is nothing", where);
  return parseXml((*resource)->bytes, where);
}

io::Result<FoundService> findService(const ServiceLayer& entry, io::Resources& resources) {
  if (!entry.type.empty() && std::ranges::find(kTypes, entry.type) == kTypes.end()) {
    return io::fail(Code::invalidArgument,
                    fmt::format("there is no type '{}'{}", entry.type, whatElseThereIs(entry.type, kTypes)));
  }
  if (entry.source.empty()) return io::fail(Code::invalidArgument, "the source is empty");
  // Braces are in no other URL: what is wrong with a template is told where it is read.
  if (entry.type == "xyz" || (entry.type.empty() && entry.source.find('{') != std::string::npos)) {
    if (const auto good = checkTileTemplate(entry.source); !good)
      return io::fail(good.error().code, good.error().message, withoutSecrets(entry.source));
    return FoundService{"xyz", entry.source, {}};
  }
  const bool isConfiguration = lowered(withoutQuery(entry.source)).ends_with(".xml");
  if (entry.type == "worldwind" && !isConfiguration) return FoundService{"worldwind", entry.source, {}};
  if (const auto path = localPath(entry.source)) return findHere(*path, resources);
  return findOnServer(entry, resources);
}

}  // namespace tellurion::raster
