#include "io/output_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <system_error>

namespace tellurion::io {
namespace {

namespace fs = std::filesystem;
using Code = Failure::Code;

Failure toldOf(const fs::path& path, Failure failure, const fs::path& part) {
  const std::string name = part.string();
  for (std::string* text : {&failure.where, &failure.message}) {
    for (auto at = text->find(name); at != std::string::npos; at = text->find(name, at))
      text->replace(at, name.size(), path.string());
  }
  return failure;
}

}  // namespace

bool isDevice(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

Result<void> checkOutput(const fs::path& path) {
  std::error_code error;
  if (isDevice(path)) return {};
  if (fs::is_directory(path, error))
    return fail(Code::invalidArgument, "is a folder; give the name of a file in it", path.string());
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, error)) {
    return fail(Code::notFound, "its folder does not exist; make it first: mkdir -p '" + folder.string() + "'",
                path.string());
  }
  fs::path part = path;
  part += ".part";
  const bool wasThere = fs::exists(part, error);
  errno = 0;
  const bool opens = std::ofstream(part, std::ios::binary | std::ios::app).is_open();
  const std::string why = std::strerror(errno);
  if (opens && !wasThere) fs::remove(part, error);
  if (!opens) return fail(Code::ioError, "cannot be written: " + why, path.string());
  return {};
}

Result<void> writeWhole(const fs::path& path, const std::function<Result<void>(const fs::path&)>& write) {
  if (isDevice(path)) return write(path);
  fs::path part = path;
  part += ".part";
  std::error_code error;
  if (auto written = write(part); !written) {
    fs::remove(part, error);
    return tl::unexpected(toldOf(path, std::move(written.error()), part));
  }
  fs::rename(part, path, error);
  if (!error) return {};
  const std::string why = error.message();
  fs::remove(part, error);
  return fail(Code::ioError, "cannot be put in place: " + why, path.string());
}

Result<void> writeWhole(const fs::path& path, std::string_view bytes) {
  return writeWhole(path, [bytes](const fs::path& part) -> Result<void> {
    errno = 0;
    std::ofstream file(part, std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (file) return {};
    return fail(Code::ioError, std::string("cannot be written: ") + std::strerror(errno), part.string());
  });
}

}  // namespace tellurion::io
