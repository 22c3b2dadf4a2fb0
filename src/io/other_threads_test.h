#pragma once
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace tellurion::io {

/// Whether all other threads of this process have nothing to do. A thread that only waits for a busy machine's
/// processor has.
inline bool othersSleep() {
  const std::string own = std::filesystem::read_symlink("/proc/thread-self").filename();
  for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task")) {
    if (thread.path().filename() == own) continue;
    std::ifstream file(thread.path() / "stat");
    const std::string stat((std::istreambuf_iterator<char>(file)), {});
    const std::size_t name = stat.rfind(')');
    if (name != std::string::npos && stat.compare(name, 3, ") S") != 0) return false;
  }
  return true;
}

}  // namespace tellurion::io
