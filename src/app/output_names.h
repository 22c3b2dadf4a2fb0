#pragma once

#include <filesystem>
#include <string>

namespace tellurion::app {

/// The name's extension with its dot, in lower case.
std::string endingOf(const std::filesystem::path& path);

/// Whether both names lead to the same file, however they are written, also where it is not there yet. A device or a
/// pipe (/dev/null) is never the same: all may write to it.
bool isSameFile(const std::filesystem::path& a, const std::filesystem::path& b);

/// A device or a pipe, which may have any name.
bool isDevice(const std::filesystem::path& path);

}  // namespace tellurion::app
