#include "io/file_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>
#include <tuple>
#include <utility>

namespace tellurion::io {
namespace {

constexpr std::size_t kLongestHolder = 200;

std::string thisProcess() {
  std::array<char, 100> host{};
  if (::gethostname(host.data(), host.size() - 1) != 0) host.front() = '?';
  return fmt::format("process {} on {}", ::getpid(), host.data());
}

}  // namespace

FileLock::FileLock(int file) : file_(file) {
  std::string text(kLongestHolder, '\0');
  const auto length = ::pread(file_, text.data(), text.size(), 0);
  leftBy_ = text.substr(0, length > 0 ? static_cast<std::size_t>(length) : 0);
  // Who holds it is only told: where it cannot be written, nothing is told.
  const std::string own = thisProcess();
  if (::ftruncate(file_, 0) == 0) std::ignore = ::pwrite(file_, own.data(), own.size(), 0);
}

FileLock::FileLock(FileLock&& other) noexcept
    : file_(std::exchange(other.file_, -1)), leftBy_(std::move(other.leftBy_)) {}

FileLock::~FileLock() {
  if (file_ < 0) return;
  std::ignore = ::ftruncate(file_, 0);
  ::close(file_);
}

Result<std::optional<FileLock>> FileLock::tryTake(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  const auto failed = [&](int why) {
    return fail(Failure::Code::ioError, "cannot be locked: " + std::generic_category().message(why), path.string());
  };
  if (file < 0) return failed(errno);
  if (::flock(file, LOCK_EX | LOCK_NB) == 0) return std::optional(FileLock(file));
  const int why = errno;
  ::close(file);
  if (why == EWOULDBLOCK) return std::optional<FileLock>();
  return failed(why);
}

}  // namespace tellurion::io
