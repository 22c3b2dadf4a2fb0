#include "raster/tiff_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;

/// A picture, its mask and their overviews are fewer; 4096 x 4096 pixels in parts of 16 x 16 are half as many.
constexpr int kMostDirectories = 64;
constexpr std::uint64_t kMostEntries = 4096;
constexpr std::uint64_t kMostParts = 1 << 17;

enum Tag : std::uint64_t {
  kWidth = 256,
  kHeight = 257,
  kStripOffsets = 273,
  kStripBytes = 279,
  kTileOffsets = 324,
  kTileBytes = 325,
};

auto endsEarly() {
  return io::fail(Code::corrupt, "the image ends before it is complete");
}

/// Numbers of the file's byte order, by place; what lies beyond the end is nothing.
class Numbers {
 public:
  explicit Numbers(std::span<const std::byte> bytes)
      : bytes_(bytes), isBigEndian_(!bytes.empty() && bytes[0] == std::byte{'M'}) {}

  std::uint64_t size() const { return bytes_.size(); }
  bool has(std::uint64_t place, std::uint64_t count) const { return place <= size() && count <= size() - place; }
  std::optional<std::uint64_t> at(std::uint64_t place, std::uint64_t count) const {
    if (!has(place, count)) return std::nullopt;
    std::uint64_t number = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::uint64_t next = place + (isBigEndian_ ? i : count - 1 - i);
      number = number << 8u | std::to_integer<std::uint64_t>(bytes_[next]);
    }
    return number;
  }

 private:
  std::span<const std::byte> bytes_;
  bool isBigEndian_;
};

/// The numbers of one entry of a directory.
struct Values {
  std::uint64_t place = 0;
  std::uint64_t count = 0;
  std::uint64_t bytesEach = 0;
  std::uint64_t of(const Numbers& file, std::uint64_t i) const {
    return file.at(place + i * bytesEach, bytesEach).value_or(0);
  }
};

/// SHORT, LONG, LONG8; others hold no places or sizes.
std::uint64_t bytesOfType(std::uint64_t type) {
  return type == 3 ? 2 : type == 4 ? 4 : type == 16 ? 8 : 0;
}

struct Directory {
  Values width, height, places, lengths;
  std::uint64_t next = 0;
};

/// Widths of a TIFF's and a BigTIFF's own numbers.
struct Layout {
  std::uint64_t place, entryCount, entry;
};
constexpr Layout kClassic{.place = 4, .entryCount = 2, .entry = 12};
constexpr Layout kBig{.place = 8, .entryCount = 8, .entry = 20};

io::Result<Values> valuesOf(const Numbers& file, const Layout& layout, std::uint64_t entry) {
  Values values{.place = entry + 4 + layout.place,
                .count = file.at(entry + 4, layout.place).value_or(0),
                .bytesEach = bytesOfType(file.at(entry + 2, 2).value_or(0))};
  if (values.bytesEach == 0) return io::fail(Code::corrupt, "a place of the TIFF is no whole number");
  if (values.count > file.size() / values.bytesEach) return endsEarly();
  const std::uint64_t bytes = values.count * values.bytesEach;
  if (bytes > layout.place) values.place = file.at(values.place, layout.place).value_or(file.size());
  if (!file.has(values.place, bytes)) return endsEarly();
  return values;
}

io::Result<Directory> directoryAt(const Numbers& file, const Layout& layout, std::uint64_t place) {
  const auto count = file.at(place, layout.entryCount);
  if (!count) return endsEarly();
  if (*count > kMostEntries) return io::fail(Code::corrupt, "a directory of the TIFF has too many entries");
  const std::uint64_t first = place + layout.entryCount;
  const auto next = file.at(first + *count * layout.entry, layout.place);
  if (!next) return endsEarly();
  Directory directory{.next = *next};
  for (std::uint64_t entry = first; entry < first + *count * layout.entry; entry += layout.entry) {
    const std::uint64_t tag = file.at(entry, 2).value_or(0);
    Values* const wanted = tag == kWidth                                 ? &directory.width
                           : tag == kHeight                              ? &directory.height
                           : tag == kStripOffsets || tag == kTileOffsets ? &directory.places
                           : tag == kStripBytes || tag == kTileBytes     ? &directory.lengths
                                                                         : nullptr;
    if (wanted == nullptr) continue;
    const auto values = valuesOf(file, layout, entry);
    if (!values) return tl::unexpected(values.error());
    *wanted = *values;
  }
  return directory;
}

io::Result<void> checkParts(const Numbers& file, const Directory& directory) {
  if (directory.places.count == 0 || directory.places.count != directory.lengths.count)
    return io::fail(Code::corrupt, "the TIFF does not say where its pixels are");
  if (directory.places.count > kMostParts) return io::fail(Code::corrupt, "the TIFF is in too many parts");
  for (std::uint64_t i = 0; i < directory.places.count; ++i) {
    if (!file.has(directory.places.of(file, i), directory.lengths.of(file, i))) return endsEarly();
  }
  return {};
}

int sideOf(const Numbers& file, const Values& values) {
  constexpr std::uint64_t kMost = std::numeric_limits<int>::max();
  return values.count == 0 ? 0 : static_cast<int>(std::min(values.of(file, 0), kMost));
}

}  // namespace

io::Result<ImageSize> sizeOfWholeTiff(std::span<const std::byte> bytes) {
  const Numbers file(bytes);
  const bool isBig = file.at(2, 2) == 43U;
  const Layout& layout = isBig ? kBig : kClassic;
  std::uint64_t place = file.at(isBig ? 8 : 4, layout.place).value_or(0);
  std::optional<ImageSize> size;
  for (int i = 0; place != 0 && i < kMostDirectories; ++i) {
    const auto directory = directoryAt(file, layout, place);
    if (!directory) return tl::unexpected(directory.error());
    if (auto sound = checkParts(file, *directory); !sound) return tl::unexpected(std::move(sound.error()));
    if (!size) size = ImageSize{.width = sideOf(file, directory->width), .height = sideOf(file, directory->height)};
    place = directory->next;
  }
  if (!size) return endsEarly();
  return *size;
}

}  // namespace tellurion::raster
