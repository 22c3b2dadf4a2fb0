#include "raster/service_discovery.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "raster/near_names.h"
#include "raster/service_exception.h"
#include "raster/service_url.h"

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;

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
    code = found ? code : found.error().code;
    if (!found) reasons += fmt::format("\n  {}", io::describe(found.error()));
  }
  return io::fail(
      code, "no map service is found there; a slow one is waited for when its type is given. What was asked:" + reasons,
      withoutSecrets(entry.source));
}

io::Result<FoundService> findHere(const std::string& path, io::Resources& resources) {
  std::error_code ignored;
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
  if (entry.type == "xyz" || (entry.type.empty() && entry.source.find('{') != std::string::npos))
    return FoundService{"xyz", entry.source, {}};
  const bool isConfiguration = lowered(withoutQuery(entry.source)).ends_with(".xml");
  if (entry.type == "worldwind" && !isConfiguration) return FoundService{"worldwind", entry.source, {}};
  if (const auto path = localPath(entry.source)) return findHere(*path, resources);
  return findOnServer(entry, resources);
}

}  // namespace tellurion::raster
