#pragma once

#include <filesystem>
#include <string>

#include "io/failure.h"

namespace tellurion::pyramid {

/// Where an export is made until it is whole: a folder OUT.part beside the output, so that nothing half-made is ever
/// seen under the output's name. What a killed export left there the next one of that name throws away. Move-only.
class ExportPlace {
 public:
  enum class Shape { file, folder };

  /// Fails, before any work, where the output could not be put in its place: it is there already and `replace` is
  /// false, it is something else than what would replace it (of folders only those that an export made are replaced),
  /// or its folder is not there.
  static io::Result<ExportPlace> prepare(const std::filesystem::path& output, Shape shape, bool replace);
  ExportPlace(ExportPlace&& other) noexcept;
  ExportPlace& operator=(ExportPlace&&) = delete;
  ~ExportPlace();  ///< removes OUT.part

  /// A name in OUT.part that nothing has yet.
  std::filesystem::path inside(const std::string& name) const { return part_ / name; }
  /// Puts what was made in its place, and removes what was there.
  io::Result<void> publish(const std::filesystem::path& made);

 private:
  ExportPlace(std::filesystem::path output, std::filesystem::path part);
  std::filesystem::path output_;
  std::filesystem::path part_;
};

/// A file in every folder that an export makes: what it holds, for programs that show it.
inline constexpr const char* kTileJsonName = "tiles.json";
inline constexpr const char* kLayerJsonName = "layer.json";
/// In both of them: by it a folder is known as an export's.
inline constexpr const char* kGenerator = "tellurion export";

}  // namespace tellurion::pyramid
