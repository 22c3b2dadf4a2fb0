#include "io/local_file.h"

#include <curl/curl.h>
#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

namespace tellurion::io {
namespace {

constexpr std::string_view kScheme = "file://";

// "file:///a%20b" and "file://localhost/a%20b" -> "/a b".
Result<std::string> pathOf(const std::string& url) {
  std::string_view rest = std::string_view(url).substr(kScheme.size());
  if (rest.starts_with("localhost/")) rest.remove_prefix(std::string_view("localhost").size());
  if (!rest.starts_with('/'))
    return fail(Failure::Code::invalidArgument, "a file address names a path from the root: file:///folder/file", url);
  rest = rest.substr(0, rest.find_first_of("?#"));
  int size = 0;
  char* const text = curl_easy_unescape(nullptr, rest.data(), static_cast<int>(rest.size()), &size);
  std::string path(text == nullptr ? "" : text, text == nullptr ? 0 : static_cast<std::size_t>(size));
  curl_free(text);
  if (path.empty() || path.find('\0') != std::string::npos)
    return fail(Failure::Code::invalidArgument, "not a path", url);
  return path;
}

}  // namespace

bool isFileUrl(const std::string& url) {
  return url.starts_with(kScheme);
}

Result<std::shared_ptr<const Resource>> readLocalFile(const ResourceRequest& request) {
  const Result<std::string> path = pathOf(request.url);
  if (!path) return tl::unexpected(path.error());
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(*path, error);
  if (status.type() == std::filesystem::file_type::not_found) return nullptr;
  if (!std::filesystem::is_regular_file(status))
    return fail(Failure::Code::ioError, error ? "cannot be read (" + error.message() + ")" : "not a file", request.url);
  std::ifstream file(*path, std::ios::binary);
  if (!file) return fail(Failure::Code::ioError, "cannot be opened", request.url);
  auto resource = std::make_shared<Resource>();
  // The size is that of what can be read, not what the file system says: the file may be written right now.
  const std::uintmax_t size = std::filesystem::file_size(*path, error);
  if (!error && size > request.maxBytes)
    return fail(Failure::Code::corrupt,
                fmt::format("{} bytes are more than the {} that are allowed", size, request.maxBytes), request.url);
  resource->bytes.resize(error ? 0 : static_cast<std::size_t>(size));
  file.read(reinterpret_cast<char*>(resource->bytes.data()), static_cast<std::streamsize>(resource->bytes.size()));
  if (file.bad()) return fail(Failure::Code::ioError, "reading failed", request.url);
  resource->bytes.resize(static_cast<std::size_t>(file.gcount()));
  if (request.check) {
    const Result<bool> good = request.check(*resource);
    if (!good) return tl::unexpected(Failure{good.error().code, good.error().message, request.url});
    if (!*good) return nullptr;
  }
  return std::shared_ptr<const Resource>(std::move(resource));
}

}  // namespace tellurion::io
