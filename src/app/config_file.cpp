#include "app/config_file.h"

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

namespace tellurion::app {
namespace {

constexpr std::uintmax_t kMost_bytes = 1 << 20;
constexpr int kMostDamaged = 1000;

std::filesystem::path folder() {
  const auto fromEnvironment = [](const char* name) {
    const char* value = std::getenv(name);
    return std::filesystem::path(value ? value : "");
  };
  // By the XDG Base Directory Specification a path that is not absolute counts as none.
  const auto config = fromEnvironment("XDG_CONFIG_HOME");
  if (config.is_absolute()) return config / "tellurion";
  return fromEnvironment("HOME") / ".config" / "tellurion";
}

io::Failure problem(std::string message, const std::filesystem::path& path) {
  return {io::Failure::Code::ioError, std::move(message), path.string()};
}

}  // namespace

std::string configPath(std::string_view name) {
  return (folder() / name).string();
}

io::Result<std::optional<std::string>> readConfig(std::string_view name) {
  const std::filesystem::path path = configPath(name);
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return std::nullopt;
  const auto size = std::filesystem::file_size(path, error);
  if (error) return tl::unexpected(problem("cannot be read: " + error.message(), path));
  if (size > kMost_bytes) return tl::unexpected(problem("is larger than a mebibyte and not read", path));
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) return tl::unexpected(problem("cannot be read", path));
  return text.str();
}

io::Result<void> writeConfig(std::string_view name, std::string_view text) {
  const std::filesystem::path path = configPath(name);
  // A name of its own: two programs that write at once would put half of the other's in place.
  const std::filesystem::path part = fmt::format("{}.{:08x}.part", path.string(), std::random_device()());
  std::error_code error;
  std::filesystem::create_directories(path.parent_path(), error);
  {
    std::ofstream file(part, std::ios::binary | std::ios::trunc);
    file << text << std::flush;
    if (!file) {
      file.close();
      std::filesystem::remove(part, error);
      return tl::unexpected(problem("cannot be written", path));
    }
  }
  std::filesystem::rename(part, path, error);
  if (!error) return {};
  const std::string why = error.message();
  std::filesystem::remove(part, error);
  return tl::unexpected(problem("cannot be written: " + why, path));
}

std::string setAsideConfig(std::string_view name) {
  const std::filesystem::path path = configPath(name);
  std::error_code error;
  for (int i = 1; i < kMostDamaged; ++i) {
    const std::filesystem::path other = path.string() + (i == 1 ? ".damaged" : fmt::format(".damaged-{}", i));
    if (std::filesystem::exists(other, error)) continue;
    std::filesystem::rename(path, other, error);
    return other.string();
  }
  return path.string();
}

}  // namespace tellurion::app
