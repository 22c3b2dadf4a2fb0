// Each kind of damage to a tile database is found, and no file, however hostile, does more than fail.
#include "pyramid/verify.h"
#include "geo/seed_test.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <random>

#include "pyramid/database.h"
#include "pyramid/height_query.h"
#include "pyramid/synthetic_rasters_test.h"

namespace tellurion::pyramid::testing {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;

void execute(const fs::path& path, const std::string& sql) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
  char* message = nullptr;
  EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, &message), SQLITE_OK)
      << sql << ": " << (message == nullptr ? "" : message);
  sqlite3_free(message);
  sqlite3_close(database);
}

void writeBytes(const fs::path& path, const std::string& bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// Whatever a reader may do with a file.
void useAll(const fs::path& path) {
  const auto reader = PyramidReader::open(path);
  if (!reader) return;
  static_cast<void>((*reader)->summary());
  for (std::uint8_t root = 0; root < 12; ++root) {
    for (std::uint8_t level = 0; level <= 2; ++level) {
      static_cast<void>((*reader)->load({.level = level, .root = root, .x = 0, .y = 0}));
    }
  }
  auto query = HeightQuery::create(*reader);
  if (query) static_cast<void>(query->at(geo::directionFromDegrees(10.0, 20.0)));
}

class VerifyPyramid : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    writeElevation(*folder_ / "globe.tif", degreesGrid(-180, -90, 180, 90, 360, 180),
                   [](int c, int r) { return std::round(hills(89.5 - r, -179.5 + c)); });
    writeColour(*folder_ / "colour.tif", degreesGrid(-20, -20, 20, 20, 400, 400), [](int c, int r) {
      return raster::Rgba8{200, static_cast<std::uint8_t>(c / 2), 9, c > r ? std::uint8_t{255} : std::uint8_t{0}};
    });
    BuildOptions options;
    options.output = *folder_ / "globe.tdb";
    options.inputs = {(*folder_ / "globe.tif").string()};
    ASSERT_NE(builtPyramid(options), nullptr);
    options.output = *folder_ / "colour.tdb";
    options.inputs = {(*folder_ / "colour.tif").string()};
    options.kind = raster::Kind::imagery;
    ASSERT_NE(builtPyramid(options), nullptr);
  }
  static void TearDownTestSuite() { delete folder_; }

  fs::path copyOf(const std::string& name) const {
    fs::copy_file(*folder_ / name, *folder_ / "damaged.tdb", fs::copy_options::overwrite_existing);
    return *folder_ / "damaged.tdb";
  }
  /// Runs SQL on a copy and expects a fault that says `words`.
  void expectFault(const std::string& name, const std::string& sql, const std::string& words) const {
    const fs::path path = copyOf(name);
    execute(path, sql);
    const auto report = verifyPyramid(path);
    ASSERT_TRUE(report.has_value()) << io::describe(report.error());
    ASSERT_FALSE(report->sound()) << sql;
    const bool said = std::ranges::any_of(
        report->faults, [&](const std::string& fault) { return fault.find(words) != std::string::npos; });
    EXPECT_TRUE(said) << sql << "\nsays: " << report->faults.front();
    useAll(path);
  }
  static TemporaryFolder* folder_;
};
TemporaryFolder* VerifyPyramid::folder_ = nullptr;

TEST_F(VerifyPyramid, SoundFilesAreSound) {
  for (const char* name : {"globe.tdb", "colour.tdb"}) {
    const auto report = verifyPyramid(*folder_ / name);
    ASSERT_TRUE(report.has_value());
    EXPECT_TRUE(report->sound());
    EXPECT_GT(report->tiles, 0U);
    EXPECT_GT(report->payloadBytes, 0U);
  }
}

TEST_F(VerifyPyramid, FindsWhatIsWrongWithRows) {
  expectFault("globe.tdb", "UPDATE tiles SET payload = zeroblob(100) WHERE id = 16", "wrong checksum");
  expectFault("globe.tdb", "UPDATE tiles SET checksum = checksum + 1 WHERE level = 1 AND root = 2", "wrong checksum");
  expectFault("globe.tdb", "UPDATE tiles SET min_m = min_m - 1 WHERE id = 17", "wrong checksum");
  expectFault("globe.tdb", "UPDATE tiles SET error_m = 0 WHERE id = 17", "wrong checksum");
  expectFault("globe.tdb", "UPDATE tiles SET child_mask = 7 WHERE id = 17", "wrong checksum");
  expectFault("globe.tdb", "UPDATE tiles SET x = x + 1 WHERE id = 64", "place disagree");
  expectFault("globe.tdb", "UPDATE tiles SET child_mask = 99 WHERE id = 17", "impossible mask");
  expectFault("globe.tdb", "UPDATE tiles SET children = zeroblob(47) WHERE id = 17", "wrong length");
  expectFault("globe.tdb", "DELETE FROM tiles WHERE id = 66", "is missing");
  expectFault("globe.tdb", "DELETE FROM tiles WHERE id = 18", "parent is missing");
  expectFault("globe.tdb", "UPDATE tiles SET id = 40 WHERE id = 18", "belongs to no tile");
  expectFault("globe.tdb", "UPDATE tiles SET id = 30, root = 14 WHERE id = 18", "wrong checksum");
  expectFault("globe.tdb", "UPDATE tiles SET payload = 'text', checksum = 'text' WHERE id = 18", "wrong checksum");
  expectFault("colour.tdb", "UPDATE tiles SET payload = payload || x'00' WHERE id = 16", "wrong checksum");
}

/// Rows whose checksum is right but whose content lies: written with the program's own code.
TEST_F(VerifyPyramid, FindsLiesUnderARightChecksum) {
  struct Lie {
    const char* words;
    std::function<void(TileRecord&)> tell;
  };
  const std::vector<Lie> lies = {
      {"does not decode", [](TileRecord& r) { r.payload.resize(r.payload.size() / 2); }},
      {"does not decode", [](TileRecord& r) { r.payload.clear(); }},
      {"does not decode", [](TileRecord& r) { r.payload[0] = std::byte{77}; }},
      {"outside its minimum", [](TileRecord& r) { r.statistics.max_m = r.statistics.min_m; }},
      {"negative or not a number", [](TileRecord& r) { r.statistics.error_m = -1.0f; }},
      {"smaller than a child's", [](TileRecord& r) { r.children[1].error_m = 9e9f; }},
      {"a child is outside", [](TileRecord& r) { r.children[2].min_m = -9e9f; }},
      {"those that its parent has", [](TileRecord& r) { r.children[3].max_m -= 0.5f; }},
      {"its parent does not know it", [](TileRecord& r) { r.childMask = 14; }},
  };
  for (const Lie& lie : lies) {
    const fs::path path = copyOf("globe.tdb");
    {
      auto database = TileDatabase::open(path, io::SqliteConnection::Mode::write);
      ASSERT_TRUE(database.has_value());
      auto record = database->read({.level = 0, .root = 3, .x = 0, .y = 0});
      ASSERT_TRUE(record.has_value() && record->has_value());
      lie.tell(**record);
      ASSERT_TRUE(database->write(**record).has_value());
    }
    const auto report = verifyPyramid(path);
    ASSERT_TRUE(report.has_value());
    const bool said = std::ranges::any_of(
        report->faults, [&](const std::string& fault) { return fault.find(lie.words) != std::string::npos; });
    EXPECT_TRUE(said) << lie.words << ": " << (report->sound() ? "nothing was said" : report->faults.front());
    useAll(path);
  }
}

TEST_F(VerifyPyramid, FlippedBytesAreFoundOrHarmless) {
  const std::string original = bytesOf(*folder_ / "globe.tdb");
  const unsigned seed = geo::testSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  std::uniform_int_distribution<std::size_t> where(0, original.size() - 1);
  const auto sound = PyramidReader::open(*folder_ / "globe.tdb");
  ASSERT_TRUE(sound.has_value());
  const std::vector<tiling::TileId> tiles = storedTiles(**sound);
  const fs::path path = *folder_ / "damaged.tdb";
  for (int i = 0; i < 100; ++i) {
    std::string bytes = original;
    const std::size_t at = where(random);
    bytes[at] = static_cast<char>(bytes[at] ^ static_cast<char>(1u << (random() % 8)));
    writeBytes(path, bytes);
    useAll(path);
    const auto report = verifyPyramid(path);
    if (!report || !report->sound()) continue;
    // Nothing was found: then no tile may have changed (the byte is one that SQLite does not use).
    const auto reader = PyramidReader::open(path);
    ASSERT_TRUE(reader.has_value()) << "byte " << at;
    for (const tiling::TileId& id : tiles) {
      const auto a = (*sound)->load(id);
      const auto b = (*reader)->load(id);
      ASSERT_TRUE(b.has_value() && b->has_value()) << "byte " << at;
      ASSERT_EQ(0, std::memcmp(heightsOf(**a).samples.data(), heightsOf(**b).samples.data(),
                               heightsOf(**a).samples.size() * sizeof(float)))
          << "byte " << at;
    }
  }
}

TEST_F(VerifyPyramid, TruncatedFilesFailCleanly) {
  const std::string original = bytesOf(*folder_ / "globe.tdb");
  const fs::path path = *folder_ / "damaged.tdb";
  for (const std::size_t size : {0UL, 1UL, 15UL, 16UL, 99UL, 100UL, 101UL, 4095UL, 4096UL, 4097UL, 20000UL,
                                 original.size() / 2, original.size() - 4096, original.size() - 1}) {
    writeBytes(path, original.substr(0, size));
    useAll(path);
    const auto report = verifyPyramid(path);
    EXPECT_FALSE(report.has_value() && report->sound()) << size << " bytes";
    EXPECT_TRUE(report.has_value() || !io::describe(report.error()).empty());
  }
}

TEST_F(VerifyPyramid, StrangeFilesAreRefused) {
  const fs::path path = *folder_ / "damaged.tdb";
  const auto refusal = [&] {
    const auto reader = PyramidReader::open(path);
    EXPECT_FALSE(reader.has_value());
    return reader ? std::string() : io::describe(reader.error());
  };
  const auto expectRefused = [&](const std::string& sql, const std::string& words) {
    copyOf("globe.tdb");
    execute(path, sql);
    EXPECT_NE(refusal().find(words), std::string::npos) << sql << ": " << refusal();
  };
  expectRefused("PRAGMA application_id = 1", "not a tile database");
  expectRefused("PRAGMA user_version = 3", "format version 3");
  // Of two roots, as it was before version 2.
  expectRefused("UPDATE meta SET value = 'geographic' WHERE key = 'tiling'",
                "tile database of the geographic tiling in format version 1; this program reads version 2 of it: build "
                "it again");
  expectRefused("PRAGMA user_version = 2", "cube tiling in format version 2");
  expectRefused("DROP TABLE tiles", "tables are not those");
  expectRefused("ALTER TABLE tiles ADD COLUMN more", "tables are not those");
  expectRefused("ALTER TABLE tiles RENAME TO other; CREATE VIEW tiles AS SELECT * FROM other", "tables are not those");
  expectRefused("DELETE FROM meta WHERE key = 'kind'", "lacks a text 'kind'");
  expectRefused("UPDATE meta SET value = 'smell' WHERE key = 'kind'", "unknown kind");
  expectRefused("UPDATE meta SET value = 'icosahedron' WHERE key = 'tiling'", "unknown tiling");
  expectRefused("UPDATE meta SET value = 1e300 WHERE key = 'tile_cells'", "out of its range");
  expectRefused("UPDATE meta SET value = 65 WHERE key = 'tile_cells'", "power of two");
  expectRefused("UPDATE meta SET value = 256 WHERE key = 'tile_cells'", "takes 4 to 128");
  expectRefused("UPDATE meta SET value = 30 WHERE key = 'max_level'", "out of its range");
  expectRefused("UPDATE meta SET value = NULL WHERE key = 'max_level'", "out of its range");
  expectRefused("UPDATE meta SET value = -5 WHERE key = 'body_semi_major_axis_m'", "out of its range");
  expectRefused("UPDATE meta SET value = 1e999 WHERE key = 'height_step_m'", "out of its range");
  expectRefused("UPDATE meta SET value = 0 WHERE key = 'complete'", "not finished");
  writeBytes(path,
             "This is no database, but a letter of some length, more than a hundred bytes, so that there is a header "
             "to be read and found wanting.");
  EXPECT_NE(refusal().find("no SQLite file"), std::string::npos);
  fs::remove(path);
  EXPECT_NE(refusal().find("no such file"), std::string::npos);
  EXPECT_FALSE(verifyPyramid(path).has_value());
  EXPECT_FALSE(PyramidReader::open(fs::temp_directory_path()).has_value());
}

/// A tile size that is not the payloads': every tile fails, nothing else.
TEST_F(VerifyPyramid, AbsurdSizesFailTileByTile) {
  const auto set = [](int cells) { return fmt::format("UPDATE meta SET value = {} WHERE key = 'tile_cells'", cells); };
  for (const int cells : {4, 32, 128})
    expectFault("globe.tdb", set(cells), "does not decode");
  for (const int cells : {4, 32, 1024})
    expectFault("colour.tdb", set(cells), "does not decode");
}

TEST_F(VerifyPyramid, StopsWhenAsked) {
  std::stop_source before;
  before.request_stop();
  const auto none = verifyPyramid(*folder_ / "globe.tdb", {}, {}, before.get_token());
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, Code::cancelled);
  EXPECT_NE(none.error().message.find("0 tiles"), std::string::npos) << none.error().message;
  // In the middle of the walk: what SQLite then says of its interrupted statement is no fault of the file.
  writeElevation(*folder_ / "fine.tif", degreesGrid(-180, -90, 180, 90, 1440, 720),
                 [](int c, int r) { return std::round(hills(89.875 - r * 0.25, -179.875 + c * 0.25)); });
  BuildOptions fine;
  fine.output = *folder_ / "fine.tdb";
  fine.inputs = {(*folder_ / "fine.tif").string()};
  const auto reader = builtPyramid(fine);
  ASSERT_NE(reader, nullptr);
  ASSERT_GT(storedTiles(*reader).size(), 64u);  // progress is told of every 64 tiles
  std::stop_source during;
  const auto some = verifyPyramid(
      *folder_ / "fine.tdb", {}, [&](std::uint64_t, std::uint64_t) { during.request_stop(); }, during.get_token());
  ASSERT_FALSE(some);
  EXPECT_EQ(some.error().code, Code::cancelled);
  EXPECT_NE(some.error().message.find("64 tiles"), std::string::npos) << some.error().message;
  EXPECT_NE(some.error().message.find("0 faults"), std::string::npos) << some.error().message;
}

TEST_F(VerifyPyramid, AMissingRootIsAFailureToReadersToo) {
  for (const char* const name : {"globe.tdb", "colour.tdb"}) {
    const fs::path path = copyOf(name);
    execute(path, "DELETE FROM tiles WHERE level = 0");
    const auto reader = PyramidReader::open(path);
    ASSERT_TRUE(reader) << io::describe(reader.error());
    int failed = 0;
    for (std::uint8_t root = 0; root < 6; ++root) {
      const auto tile = (*reader)->load({.level = 0, .root = root, .x = 0, .y = 0});
      if (tile) {
        EXPECT_FALSE(*tile);
        continue;
      }
      ++failed;
      EXPECT_EQ(tile.error().code, Code::corrupt);
      EXPECT_NE(tile.error().message.find("missing"), std::string::npos) << tile.error().message;
      EXPECT_EQ(tile.error().where, path.string());
    }
    // The Earth is on all roots; the picture, 20 degrees around the middle of the first, leaves others bare.
    EXPECT_EQ(failed, name == std::string("globe.tdb") ? 6 : 1);
  }
  auto query = HeightQuery::create(*PyramidReader::open(copyOf("globe.tdb")));
  ASSERT_TRUE(query);
  EXPECT_TRUE(query->at(geo::directionFromDegrees(10.0, 20.0)));
  const fs::path path = copyOf("globe.tdb");
  execute(path, "DELETE FROM tiles WHERE level = 0");
  query = HeightQuery::create(*PyramidReader::open(path));
  ASSERT_TRUE(query);
  const auto height = query->at(geo::directionFromDegrees(10.0, 20.0));
  ASSERT_FALSE(height);
  EXPECT_EQ(height.error().code, Code::corrupt);
}

TEST_F(VerifyPyramid, ValuesTooLargeFail) {
  const fs::path path = copyOf("globe.tdb");
  execute(path, "UPDATE tiles SET payload = zeroblob(100000000) WHERE id = 17");
  const auto reader = PyramidReader::open(path);
  ASSERT_TRUE(reader.has_value());
  EXPECT_FALSE((*reader)->load({.level = 0, .root = 1, .x = 0, .y = 0}).has_value());
  const auto report = verifyPyramid(path);
  EXPECT_FALSE(report.has_value() && report->sound());
}

}  // namespace
}  // namespace tellurion::pyramid::testing
