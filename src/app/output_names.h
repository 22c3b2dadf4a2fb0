#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>

#include "io/failure.h"

namespace tellurion::app {

/// The name's extension with its dot, in lower case.
std::string endingOf(const std::filesystem::path& path);

/// Whether both names lead to the same file, however they are written, also where it is not there yet. A device or a
/// pipe (/dev/null) is never the same: all may write to it.
bool isSameFile(const std::filesystem::path& a, const std::filesystem::path& b);

/// io::checkOutput of each that is given (not empty), before the work that they take the results of.
io::Result<void> checkOutputs(std::initializer_list<std::filesystem::path> paths);

}  // namespace tellurion::app
