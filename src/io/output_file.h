#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

#include "io/failure.h"

namespace tellurion::io {

/// A device or a pipe (/dev/null, /dev/stdout): takes bytes, and no file may be moved over it.
bool isDevice(const std::filesystem::path& path);

/// Whether a file can be made at `path`, as far as that can be told before the work whose result it takes: its folder
/// is there and can be written to, and it is no folder itself. The failure's `where` is the path.
Result<void> checkOutput(const std::filesystem::path& path);

/// Lets `write` make PATH.part and moves it to `path` then: there is a whole file or what was there before. Failures
/// are told of `path`. A device is written to itself.
Result<void> writeWhole(const std::filesystem::path& path,
                        const std::function<Result<void>(const std::filesystem::path&)>& write);

/// The same with these bytes.
Result<void> writeWhole(const std::filesystem::path& path, std::string_view bytes);

}  // namespace tellurion::io
