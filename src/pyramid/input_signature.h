#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/failure.h"

namespace tellurion::pyramid {

/// What tells one content of a file from another without reading it.
struct FileStamp {
  std::string path;
  bool exists = false;  ///< false also of what is no file of this machine: that is taken as it comes
  std::uintmax_t size = 0;
  std::int64_t time_ns = 0;  ///< of its last change, since the file system's epoch
  /// Name, size and time; of GDAL's side files (.aux.xml) what they say instead, but for the statistics that programs
  /// leave there when they merely look at a raster; empty where they say nothing else.
  std::string text;
};

FileStamp stampOf(const std::string& path);

/// Whether the files are still what they were. notFound: one is away, and may come back, while none of the others is
/// another; invalidArgument: one is another now. `where` names it. Costs a question to the file system for each file.
io::Result<void> checkUnchanged(const std::vector<FileStamp>& stamps);

}  // namespace tellurion::pyramid
