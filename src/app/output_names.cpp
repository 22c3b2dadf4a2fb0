#include "app/output_names.h"

#include <algorithm>
#include <system_error>

#include "io/output_file.h"

namespace tellurion::app {

namespace fs = std::filesystem;

std::string endingOf(const fs::path& path) {
  std::string ending = path.extension().string();
  std::ranges::transform(ending, ending.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return ending;
}

bool isSameFile(const fs::path& a, const fs::path& b) {
  if (a.empty() || b.empty() || io::isDevice(a) || io::isDevice(b)) return false;
  std::error_code error;
  if (fs::equivalent(a, b, error) && !error) return true;
  const auto whole = [](const fs::path& path) {
    std::error_code failed;
    const fs::path absolute = fs::absolute(path, failed);
    const fs::path canonical = fs::weakly_canonical(absolute, failed);
    return failed ? absolute.lexically_normal() : canonical;
  };
  return whole(a) == whole(b);
}

io::Result<void> checkOutputs(std::initializer_list<fs::path> paths) {
  for (const fs::path& path : paths) {
    if (path.empty()) continue;
    if (auto can = io::checkOutput(path); !can) return can;
  }
  return {};
}

}  // namespace tellurion::app
