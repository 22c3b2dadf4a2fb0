#include "pyramid/tile_objects.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <iterator>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "io/crc32.h"
#include "pyramid/database.h"
#include "pyramid/database_file.h"
#include "pyramid/tile_set.h"

namespace tellurion::pyramid {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;

constexpr std::string_view kFirstLine = "tellurion tile objects 1\n";
constexpr std::array<std::byte, 4> kObjectMark{std::byte{'T'}, std::byte{'L'}, std::byte{'R'}, std::byte{'1'}};
constexpr std::size_t kNumberBytes = 8;
constexpr std::size_t kStatisticsBytes = 12;
constexpr std::size_t kCrcBytes = 4;
constexpr std::size_t kMostText = 1 << 16;           ///< bytes of what stands before the index
constexpr std::string_view kUnderWay = "exporting";  ///< the object that names a revision that is not whole
constexpr std::uint64_t kTold = 256;                 ///< tiles between two words on progress

using Bytes = std::vector<std::byte>;
using View = std::span<const std::byte>;

void append(Bytes& out, std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  out.insert(out.end(), bytes.begin(), bytes.end());
}

void appendNumber(Bytes& out, std::uint64_t value, std::size_t bytes) {
  for (std::size_t i = 0; i < bytes; ++i)
    out.push_back(static_cast<std::byte>((value >> (8 * i)) & 0xffu));
}

std::uint64_t numberAt(View bytes, std::size_t at, std::size_t count) {
  std::uint64_t out = 0;
  for (std::size_t i = 0; i < count; ++i)
    out |= std::uint64_t{std::to_integer<std::uint8_t>(bytes[at + i])} << (8 * i);
  return out;
}

void add(io::Crc32& crc, std::string_view text) {
  crc.add(std::as_bytes(std::span(text)));
}

Bytes asBytes(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

std::uint32_t crcOf(View bytes) {
  io::Crc32 crc;
  crc.add(bytes);
  return crc.value();
}

/// A line's end must not come from a name.
std::string inOneLine(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return static_cast<unsigned char>(c) < ' '; }, ' ');
  return text;
}

std::string lineOf(std::string_view key, const MetaValue& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return fmt::format("{} = \"{}\"\n", key, inOneLine(*text));
  return std::visit(
      [&](const auto& number) {
        if constexpr (std::is_arithmetic_v<std::decay_t<decltype(number)>>)
          return fmt::format("{} = {}\n", key, number);
        return std::string();
      },
      value);
}

/// KEY = VALUE; false: it is no such line.
bool readLine(std::string_view line, MetaTable& table) {
  const auto equals = line.find(" = ");
  if (equals == std::string_view::npos) return false;
  const std::string key(line.substr(0, equals));
  const std::string_view value = line.substr(equals + 3);
  if (value.size() >= 2 && value.front() == '"' && value.back() == '"') {
    table.texts[key] = value.substr(1, value.size() - 2);
    return true;
  }
  double number = 0.0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  table.numbers[key] = number;
  return error == std::errc() && end == value.data() + value.size();
}

io::Failure damaged(const std::string& where, std::string message) {
  return {.code = Code::corrupt, .message = std::move(message), .where = where};
}

Bytes readFile(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  return asBytes(text);
}

bool isRevision(std::string_view text) {
  return text.size() == 2 * kCrcBytes && text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

/// The revisions that exports have left in a folder, as their objects tell; fails on a folder of anybody else's.
io::Result<std::vector<std::string>> revisionsIn(const fs::path& folder) {
  std::error_code error;
  const auto textOf = [&](std::string_view name) {
    std::ifstream file(folder / name, std::ios::binary);
    std::string text(kMostText, '\0');
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
    return text;
  };
  std::vector<std::string> out;
  for (const auto& [name, mark] : {std::pair(kContentsObject, std::string_view("\nrevision = \"")),
                                   std::pair(kUnderWay, std::string_view("\n"))}) {
    const std::string text = textOf(name);
    if (!text.starts_with(kFirstLine)) continue;
    const auto at = text.find(mark);
    const std::string revision = at != std::string::npos ? text.substr(at + mark.size(), 2 * kCrcBytes) : "";
    if (isRevision(revision)) out.push_back(revision);
  }
  if (out.empty() && !fs::is_empty(folder, error))
    return io::fail(Code::invalidArgument,
                    "the folder holds something else than an earlier export of tile objects; give the name of a new "
                    "or empty one",
                    folder.string());
  return out;
}

/// Writes the objects of a database's tiles, in the order of their rows.
class Export {
 public:
  Export(const TileDatabase& database, const fs::path& folder, const ObjectSink& progress, const std::stop_token& stop)
      : database_(database), folder_(folder), progress_(progress), stop_(stop) {}

  io::Result<ExportedObjects> run() {
    contents_.meta = database_.meta();
    if (auto ok = makeRevision(); !ok) return tl::unexpected(ok.error());
    const auto others = revisionsIn(folder_);
    if (!others) return tl::unexpected(others.error());
    if (auto ok = writeWholeFile(folder_ / kUnderWay, asBytes(std::string(kFirstLine) + contents_.revision)); !ok)
      return tl::unexpected(ok.error());
    if (auto ok = writeTiles(); !ok) return tl::unexpected(ok.error());
    const Bytes bytes = encodedContents(contents_);
    const fs::path temporary = folder_ / (contents_.revision + ".new");
    if (auto ok = writeWholeFile(temporary, bytes); !ok) return tl::unexpected(ok.error());
    std::error_code error;
    fs::rename(temporary, folder_ / kContentsObject, error);
    if (error) return io::fail(Code::ioError, "cannot be put in its place: " + error.message(), temporary.string());
    done_.bytes += bytes.size();
    done_.revision = contents_.revision;
    for (const std::string& other : *others) {
      if (other != contents_.revision) fs::remove_all(folder_ / other, error);
    }
    fs::remove(folder_ / kUnderWay, error);
    return done_;
  }

 private:
  /// Of all checksums and of what the contents say besides, so that other tiles have other names.
  io::Result<void> makeRevision() {
    io::Crc32 crc;
    for (const auto& [key, value] : valuesForReading(contents_.meta))
      add(crc, lineOf(key, value));
    auto rows = database_.connection().prepare("SELECT id, child_mask, checksum FROM tiles ORDER BY id");
    if (!rows) return tl::unexpected(rows.error());
    std::vector<std::vector<std::uint8_t>> masks(static_cast<std::size_t>(contents_.meta.maxLevel) + 1);
    std::uint32_t roots = 0;
    Bytes row;
    while (true) {
      const auto found = rows->step();
      if (!found) return tl::unexpected(found.error());
      if (!*found) break;
      const auto id = tileOfRowNumber(rows->integer(0));
      if (!id || id->level > contents_.meta.maxLevel) return tl::unexpected(unlike());
      if (id->level == 0) roots |= 1u << id->root;
      masks[id->level].push_back(static_cast<std::uint8_t>(rows->integer(1) & 15));
      row.clear();
      appendNumber(row, static_cast<std::uint64_t>(rows->integer(0)), kNumberBytes);
      appendNumber(row, static_cast<std::uint64_t>(rows->integer(2)), kCrcBytes);
      crc.add(row);
      if (++total_ > TileIndex::kMostTiles)
        return io::fail(Code::unsupported,
                        fmt::format("has more than {} tiles, which is what an index may hold; export parts of it "
                                    "that are built with --region",
                                    TileIndex::kMostTiles),
                        database_.connection().path());
    }
    contents_.index = TileIndex(roots);
    for (auto& level : masks) {
      if (level.size() != contents_.index.nextCount()) return tl::unexpected(unlike());
      contents_.index.addLevel(std::move(level));
    }
    contents_.revision = fmt::format("{:08x}", crc.value());
    return {};
  }

  io::Failure unlike() const {
    return damaged(database_.connection().path(), "its tiles and their masks of children disagree; build it again");
  }

  io::Result<void> writeTiles() {
    auto rows = database_.connection().prepare(fmt::format("SELECT {} FROM tiles ORDER BY id", kTileColumns));
    if (!rows) return tl::unexpected(rows.error());
    while (true) {
      if (stop_.stop_requested())
        return io::fail(Code::cancelled, "stopped; what was there is as it was, and the next export goes on",
                        folder_.string());
      const auto found = rows->step();
      if (!found) return tl::unexpected(found.error());
      if (!*found) return {};
      const auto record = recordFrom(*rows, contents_.meta.kind, database_.connection().path());
      if (!record) return tl::unexpected(record.error());
      if (auto ok = writeTile(*record); !ok) return ok;
    }
  }

  io::Result<void> writeTile(const TileRecord& record) {
    const fs::path path = folder_ / objectName(contents_.revision, record.id);
    std::error_code error;
    const Bytes bytes = encodedObject(record, contents_.meta.kind);
    // What may be read meanwhile is never half there.
    if (!fs::exists(path, error)) {
      if (auto ok = writeWholeFile(path, bytes); !ok) return ok;
    } else if (readFile(path) != bytes) {
      fs::path temporary = path;
      temporary += ".new";
      if (auto ok = writeWholeFile(temporary, bytes); !ok) return ok;
      fs::rename(temporary, path, error);
      if (error) return io::fail(Code::ioError, "cannot be replaced: " + error.message(), path.string());
    }
    done_.bytes += bytes.size();
    if (++done_.tiles % kTold == 0 && progress_) progress_(done_.tiles, total_);
    return {};
  }

  const TileDatabase& database_;
  const fs::path& folder_;
  const ObjectSink& progress_;
  const std::stop_token& stop_;
  ObjectContents contents_;
  std::uint64_t total_ = 0;
  ExportedObjects done_;
};

}  // namespace

Bytes encodedContents(const ObjectContents& contents) {
  Bytes out;
  append(out, kFirstLine);
  for (const auto& [key, value] : valuesForReading(contents.meta))
    append(out, lineOf(key, value));
  append(out, lineOf("revision", contents.revision));
  append(out, "\n");
  const Bytes index = encodedIndex(contents.index);
  out.insert(out.end(), index.begin(), index.end());
  appendNumber(out, crcOf(out), kCrcBytes);
  return out;
}

io::Result<ObjectContents> decodedContents(View bytes, const std::string& where) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (!text.starts_with(kFirstLine))
    return io::fail(Code::unsupported, "these are no contents of a tile database that this version knows", where);
  if (bytes.size() < kFirstLine.size() + kCrcBytes ||
      crcOf(bytes.first(bytes.size() - kCrcBytes)) != numberAt(bytes, bytes.size() - kCrcBytes, kCrcBytes))
    return tl::unexpected(damaged(where, "the contents are damaged: wrong checksum"));
  MetaTable table{.where = where, .texts = {}, .numbers = {}};
  std::size_t at = kFirstLine.size();
  for (;;) {
    const auto end = text.find('\n', at);
    if (end == std::string_view::npos || end > kMostText)
      return tl::unexpected(damaged(where, "the contents have no end where they should"));
    const std::string_view line = text.substr(at, end - at);
    at = end + 1;
    if (line.empty()) break;
    if (!readLine(line, table)) return tl::unexpected(damaged(where, "the contents have a line that is no value"));
  }
  auto meta = metaForReading(table);
  if (!meta) return tl::unexpected(meta.error());
  ObjectContents contents{.meta = std::move(*meta), .revision = table.texts["revision"], .index = TileIndex()};
  if (!isRevision(contents.revision) || at + kCrcBytes > bytes.size())
    return tl::unexpected(damaged(where, "the contents lack a revision or an index"));
  auto index = decodedIndex(bytes.subspan(at, bytes.size() - kCrcBytes - at), contents.meta.maxLevel + 1,
                            tiling::Tiling(contents.meta.scheme).rootCount());
  if (!index) return io::fail(index.error().code, index.error().message, where);
  contents.index = std::move(*index);
  return contents;
}

std::string objectName(const std::string& revision, const tiling::TileId& id) {
  return fmt::format("{}/{}/{}/{}/{}", revision, id.level, id.root, id.x, id.y);
}

Bytes encodedObject(const TileRecord& record, raster::Kind kind) {
  Bytes out(kObjectMark.begin(), kObjectMark.end());
  appendNumber(out, static_cast<std::uint64_t>(rowNumberOf(record.id)), kNumberBytes);
  appendNumber(out, record.childMask, 1);
  appendNumber(out, checksumOf(record, kind), kCrcBytes);
  if (kind == raster::Kind::elevation) {
    const Bytes own = childrenBytes({record.statistics, {}, {}, {}});
    const Bytes children = childrenBytes(record.children);
    out.insert(out.end(), own.begin(), own.begin() + kStatisticsBytes);
    out.insert(out.end(), children.begin(), children.end());
  }
  out.insert(out.end(), record.payload.begin(), record.payload.end());
  return out;
}

io::Result<TileRecord> decodedObject(View bytes, const tiling::TileId& id, raster::Kind kind) {
  const auto wrong = [&](std::string_view what) {
    return io::fail(Code::corrupt, fmt::format("{}: {}", nameOf(id), what), {});
  };
  const bool isElevation = kind == raster::Kind::elevation;
  constexpr std::size_t kFixed = kObjectMark.size() + kNumberBytes + 1 + kCrcBytes;
  const std::size_t header = kFixed + (isElevation ? kStatisticsBytes + kChildrenBytes : 0);
  if (bytes.size() < header || !std::ranges::equal(bytes.first(kObjectMark.size()), kObjectMark))
    return wrong("something else than a tile came");
  std::size_t at = kObjectMark.size();
  if (numberAt(bytes, at, kNumberBytes) != static_cast<std::uint64_t>(rowNumberOf(id)))
    return wrong("another tile came");
  at += kNumberBytes;
  TileRecord record{.id = id, .childMask = static_cast<std::uint8_t>(numberAt(bytes, at, 1))};
  if (record.childMask > 15) return wrong("impossible mask of children");
  const auto checksum = numberAt(bytes, at + 1, kCrcBytes);
  at = kFixed;
  if (isElevation) {
    std::array<std::byte, kChildrenBytes> own{};
    std::ranges::copy(bytes.subspan(at, kStatisticsBytes), own.begin());
    record.statistics = childrenFromBytes(own)[0];
    record.children = childrenFromBytes(bytes.subspan(at + kStatisticsBytes).first<kChildrenBytes>());
  }
  const View payload = bytes.subspan(header);
  record.payload.assign(payload.begin(), payload.end());
  if (checksumOf(record, kind) != checksum) return wrong("wrong checksum: damaged on its way, or on the server");
  return record;
}

io::Result<ExportedObjects> exportObjects(const fs::path& database, const fs::path& folder, const ObjectSink& progress,
                                          const std::stop_token& stop) {
  if (auto ok = checkDatabaseFile(database); !ok) return tl::unexpected(ok.error());
  const auto opened = TileDatabase::open(database, io::SqliteConnection::Mode::read);
  if (!opened) return tl::unexpected(opened.error());
  if (!opened->meta().complete) return tl::unexpected(unfinished(*opened));
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder, error))
    return io::fail(Code::ioError, "no folder can be made there; give the name of a new or empty one", folder.string());
  return Export(*opened, folder, progress, stop).run();
}

}  // namespace tellurion::pyramid
