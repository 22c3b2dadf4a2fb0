#include "scene/layer_entry.h"

#include <filesystem>
#include <system_error>

namespace tellurion::scene {

namespace fs = std::filesystem;

bool isServiceUrl(std::string_view text) {
  return text.starts_with("http://") || text.starts_with("https://") || text.starts_with("s3://") ||
         text.starts_with("file://");
}

SourceKind sourceKindOf(const std::string& source) {
  if (isServiceUrl(source) || source.find("{x}") != std::string::npos) return SourceKind::service;
  const fs::path path(source);
  std::error_code error;
  if (path.filename() == "tilemapresource.xml") return SourceKind::service;
  if (!fs::is_directory(path, error)) return SourceKind::file;
  return fs::exists(path / "tilemapresource.xml", error) ? SourceKind::service : SourceKind::catalogue;
}

raster::ServiceLayer serviceFromUrl(std::string_view text) {
  const auto hash = text.rfind('#');
  raster::ServiceLayer out;
  out.source = text.substr(0, hash);
  if (hash != std::string_view::npos) out.layer = text.substr(hash + 1);
  return out;
}

}  // namespace tellurion::scene
