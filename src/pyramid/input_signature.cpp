#include "pyramid/input_signature.h"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <istream>
#include <optional>

#include "pyramid/text_digest.h"

namespace tellurion::pyramid {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;

constexpr std::string_view kSideFile = ".aux.xml";
constexpr std::uintmax_t kLargestSideFile = 4u << 20u;

FileStamp sizeAndTimeOf(const std::string& path) {
  std::error_code error;
  FileStamp stamp{.path = path};
  stamp.size = fs::file_size(path, error);
  if (error) return FileStamp{.path = path};
  const auto time = fs::last_write_time(path, error).time_since_epoch();
  if (error) return FileStamp{.path = path};
  stamp.time_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(time).count();
  stamp.exists = true;
  return stamp;
}

/// Without the statistics and histograms, which change nothing that is read, and what holds nothing else; empty where
/// nothing is left.
std::string withoutStatistics(std::istream& file) {
  std::vector<std::string> kept;
  bool isHistogram = false;
  for (std::string line; std::getline(file, line);) {
    const auto has = [](const std::string& text, std::string_view word) {
      return text.find(word) != std::string::npos;
    };
    if (has(line, "<Histograms>")) isHistogram = true;
    const bool isDropped = isHistogram || has(line, "\"STATISTICS_") || has(line, "Metadata>");
    if (has(line, "</Histograms>")) isHistogram = false;
    if (isDropped) continue;
    const bool closes = has(line, "</PAMRasterBand>") || has(line, "</PAMDataset>");
    const bool opens = has(line, "<PAMRasterBand") || has(line, "<PAMDataset>");
    if (closes && opens && !has(line, "><PAM") && has(line, "></")) continue;
    if (closes && !opens && !kept.empty() && (has(kept.back(), "<PAMRasterBand") || has(kept.back(), "<PAMDataset>"))) {
      kept.pop_back();
    } else {
      kept.push_back(line);
    }
  }
  std::string text;
  for (const std::string& line : kept)
    text += line + "\n";
  return text;
}

bool isSideFile(const FileStamp& stamp) {
  return stamp.path.ends_with(kSideFile) && stamp.size <= kLargestSideFile;
}

std::string textOf(const FileStamp& stamp) {
  if (!stamp.exists) return stamp.path;
  std::error_code error;
  const std::string name = fs::weakly_canonical(stamp.path, error).string();
  if (isSideFile(stamp)) {
    std::ifstream file(stamp.path);
    const std::string says = withoutStatistics(file);
    return says.empty() ? says : name + "|" + digestOf(says);
  }
  return fmt::format("{}|{}|{}", name, stamp.size, stamp.time_ns);
}

}  // namespace

FileStamp stampOf(const std::string& path) {
  FileStamp stamp = sizeAndTimeOf(path);
  stamp.text = textOf(stamp);
  return stamp;
}

io::Result<void> checkUnchanged(const std::vector<FileStamp>& stamps) {
  std::optional<std::string> away;
  for (const FileStamp& stamp : stamps) {
    if (!stamp.exists) continue;
    FileStamp now = sizeAndTimeOf(stamp.path);
    if (!now.exists) {
      if (!stamp.text.empty()) away = stamp.path;
      continue;
    }
    const bool isSame = now.size == stamp.size && now.time_ns == stamp.time_ns;
    if (isSame || (isSideFile(now) && textOf(now) == stamp.text)) continue;
    return io::fail(Code::invalidArgument, "changed while it was built from", stamp.path);
  }
  if (away) return io::fail(Code::notFound, "went away while it was built from", *away);
  return {};
}

}  // namespace tellurion::pyramid
