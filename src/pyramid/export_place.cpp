#include "pyramid/export_place.h"

#include <fstream>
#include <utility>

namespace tellurion::pyramid {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;

/// In OUT.part, so that no folder is thrown away that somebody else made.
constexpr const char* kMark = "made-by-tellurion-export";
/// In it, what is replaced, until the new is in its place.
constexpr const char* kBefore = "before";

/// The first lines say who made it.
bool isOurs(const fs::path& json) {
  std::string text(256, '\0');
  std::ifstream file(json, std::ios::binary);
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  return text.find(kGenerator) != std::string::npos;
}

/// A kill between the two renames of publish() left the old folder aside.
void putBack(const fs::path& output, const fs::path& part) {
  std::error_code error;
  if (!fs::exists(output, error) && fs::exists(part / kMark, error) && fs::exists(part / kBefore, error))
    fs::rename(part / kBefore, output, error);
}

io::Result<void> checkOutput(const fs::path& output, ExportPlace::Shape shape, bool replace) {
  std::error_code error;
  const fs::path folder = output.has_parent_path() ? output.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, error)) return io::fail(Code::notFound, "there is no such folder", folder.string());
  const fs::file_status status = fs::status(output, error);
  if (!fs::exists(status)) return {};
  if (!replace) {
    return io::fail(Code::invalidArgument, "is there already; choose another name, or have it replaced with --force",
                    output.string());
  }
  if (shape == ExportPlace::Shape::file) {
    if (fs::is_regular_file(status)) return {};
    return io::fail(Code::invalidArgument, "is no file, so none can take its place; choose another name",
                    output.string());
  }
  if (!fs::is_directory(status)) {
    return io::fail(Code::invalidArgument, "is a file, and this format is a folder of files; choose another name",
                    output.string());
  }
  if (fs::is_empty(output, error) || isOurs(output / kTileJsonName) || isOurs(output / kLayerJsonName)) return {};
  return io::fail(Code::invalidArgument,
                  "is a folder that no export made, and is not replaced; choose another name, or remove it",
                  output.string());
}

}  // namespace

ExportPlace::ExportPlace(fs::path output, fs::path part) : output_(std::move(output)), part_(std::move(part)) {}
ExportPlace::ExportPlace(ExportPlace&& other) noexcept
    : output_(std::move(other.output_)), part_(std::exchange(other.part_, {})) {}

ExportPlace::~ExportPlace() {
  if (part_.empty()) return;
  std::error_code error;
  fs::remove_all(part_, error);
}

io::Result<ExportPlace> ExportPlace::prepare(const fs::path& output, Shape shape, bool replace) {
  // "tiles/" is the folder "tiles".
  const fs::path name = output.has_filename() ? output : output.parent_path();
  fs::path part = name;
  part += ".part";
  putBack(name, part);
  if (auto ok = checkOutput(name, shape, replace); !ok) return tl::unexpected(ok.error());
  std::error_code error;
  if (fs::exists(part, error)) {
    if (!fs::exists(part / kMark, error)) {
      return io::fail(Code::invalidArgument, "is in the way of the export; remove it or choose another name",
                      part.string());
    }
    fs::remove_all(part, error);
  }
  if (!fs::create_directory(part, error)) {
    return io::fail(Code::ioError, "cannot be made: " + error.message(), part.string());
  }
  ExportPlace place(name, part);
  if (!std::ofstream(place.inside(kMark)).flush()) {
    return io::fail(Code::ioError, "cannot be written; is there room?", place.inside(kMark).string());
  }
  return place;
}

io::Result<void> ExportPlace::publish(const fs::path& made) {
  std::error_code error;
  // A folder takes no other's name, so the old one steps aside first.
  if (fs::is_directory(output_, error)) {
    fs::rename(output_, inside(kBefore), error);
    if (error) return io::fail(Code::ioError, "cannot be replaced: " + error.message(), output_.string());
  }
  fs::rename(made, output_, error);
  if (!error) return {};
  const std::string why = error.message();
  if (fs::exists(inside(kBefore), error)) fs::rename(inside(kBefore), output_, error);
  if (error) part_.clear();  // what was there is in it
  return io::fail(Code::ioError, "cannot be renamed: " + why, made.string());
}

}  // namespace tellurion::pyramid
