// Tile databases as objects: what comes over is what was stored, and nothing that comes is believed unchecked.
#include "pyramid/remote_database.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>

#include "geo/seed_test.h"
#include "io/crc32.h"
#include "pyramid/synthetic_rasters_test.h"
#include "pyramid/tile_objects.h"

namespace tellurion::pyramid::testing {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;
using ::testing::HasSubstr;

using Bytes = std::vector<std::byte>;

Bytes bytesOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

void writeBytes(const fs::path& path, std::span<const std::byte> bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

/// A hilly globe, and something finer on a part of it; or colours of a part.
fs::path built(const TemporaryFolder& folder, tiling::Scheme scheme, raster::Kind kind) {
  const fs::path out = folder / (std::string(tiling::nameOf(scheme)) + std::string(raster::nameOf(kind)) + ".tdb");
  BuildOptions options{.output = out, .inputs = {}, .kind = kind, .scheme = scheme, .body = geo::earth()};
  if (kind == raster::Kind::elevation) {
    options.inputs = {(folder / "globe.tif").string(), (folder / "fine.tif").string()};
  } else {
    options.inputs = {(folder / "colour.tif").string()};
  }
  const auto report = buildPyramid(options);
  EXPECT_TRUE(report) << io::describe(report.error());
  return out;
}

std::string urlOf(const fs::path& folder) {
  return "file://" + folder.string();
}

class RemoteDatabase : public ::testing::TestWithParam<std::tuple<tiling::Scheme, raster::Kind>> {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    writeElevation(*folder_ / "globe.tif", degreesGrid(-180, -90, 180, 90, 360, 180),
                   [](int c, int r) { return std::round(hills(89.5 - r, -179.5 + c)); });
    writeElevation(*folder_ / "fine.tif", degreesGrid(10, 10, 12, 12, 200, 200),
                   [](int c, int r) { return std::round(hills(12 - 0.01 * r, 10 + 0.01 * c)) + (c + r) % 2; });
    writeColour(*folder_ / "colour.tif", degreesGrid(-20, -20, 20, 20, 400, 400), [](int c, int r) {
      return raster::Rgba8{static_cast<std::uint8_t>(c % 256), static_cast<std::uint8_t>(r % 256), 7, 255};
    });
  }
  static void TearDownTestSuite() { delete folder_; }

  static TemporaryFolder* folder_;
  tiling::Scheme scheme_ = std::get<0>(GetParam());
  raster::Kind kind_ = std::get<1>(GetParam());
  std::shared_ptr<io::Resources> resources_ = std::make_shared<io::Resources>(io::ResourceOptions{});
};
TemporaryFolder* RemoteDatabase::folder_ = nullptr;

INSTANTIATE_TEST_SUITE_P(All, RemoteDatabase,
                         ::testing::Combine(::testing::Values(tiling::Scheme::geographic, tiling::Scheme::cube,
                                                              tiling::Scheme::healpix),
                                            ::testing::Values(raster::Kind::elevation, raster::Kind::imagery)),
                         [](const auto& each) {
                           return std::string(tiling::nameOf(std::get<0>(each.param))) + "_" +
                                  std::string(raster::nameOf(std::get<1>(each.param)));
                         });

void expectSame(const raster::SourceTile& a, const raster::SourceTile& b) {
  EXPECT_EQ(a.childMask, b.childMask);
  ASSERT_EQ(a.payload.index(), b.payload.index());
  const auto same = [](float x, float y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  if (const auto* heights = std::get_if<raster::ElevationTile>(&a.payload)) {
    const auto& other = std::get<raster::ElevationTile>(b.payload).samples.samples;
    EXPECT_TRUE(
        std::equal(heights->samples.samples.begin(), heights->samples.samples.end(), other.begin(), other.end(), same));
    EXPECT_TRUE(same(a.statistics.min_m, b.statistics.min_m) && same(a.statistics.max_m, b.statistics.max_m));
    EXPECT_EQ(a.statistics.error_m, b.statistics.error_m);
    for (std::size_t q = 0; q < 4; ++q)
      EXPECT_EQ(a.children[q].error_m, b.children[q].error_m);
  } else {
    const auto& one = std::get<raster::ImageryTile>(a.payload).pixels.samples;
    const auto& other = std::get<raster::ImageryTile>(b.payload).pixels.samples;
    ASSERT_EQ(one.size(), other.size());
    EXPECT_EQ(std::memcmp(one.data(), other.data(), one.size() * sizeof(raster::Rgba8)), 0);
  }
}

TEST_P(RemoteDatabase, isWhatTheFileIs) {
  const fs::path file = built(*folder_, scheme_, kind_);
  const fs::path objects = *folder_ / "objects.tdb";
  fs::remove_all(objects);
  const auto exported = exportObjects(file, objects);
  ASSERT_TRUE(exported) << io::describe(exported.error());
  const auto local = PyramidReader::open(file).value();
  const auto remote = openRemoteDatabase(urlOf(objects), resources_);
  ASSERT_TRUE(remote) << io::describe(remote.error());
  EXPECT_EQ((*remote)->info().maxLevel, local->info().maxLevel);
  EXPECT_EQ((*remote)->info().tileCells, local->info().tileCells);
  EXPECT_EQ((*remote)->info().body.ellipsoid, local->info().body.ellipsoid);
  const tiling::Tiling tiling(scheme_);
  auto random = geo::seededGenerator();
  std::uint64_t stored = 0;
  for (int i = 0; i < 400; ++i) {
    const auto direction =
        i % 2 == 0 ? geo::directionFromDegrees(geo::uniform(random, 10, 12), geo::uniform(random, 10, 12))
                   : geo::directionFromDegrees(geo::uniform(random, -90, 90), geo::uniform(random, -180, 180));
    const auto id = tiling.tileAt(direction, i % (local->info().maxLevel + 2));
    const auto expected = local->load(id);
    ASSERT_TRUE(expected) << io::describe(expected.error());
    const auto presence = (*remote)->presence(id);
    ASSERT_EQ(presence->stored, expected->has_value());
    const auto loaded = (*remote)->load(id);
    ASSERT_TRUE(loaded) << io::describe(loaded.error());
    ASSERT_EQ(loaded->has_value(), expected->has_value());
    if (!*loaded) continue;
    ++stored;
    EXPECT_EQ(presence->childMask, (*expected)->childMask);
    expectSame(**loaded, **expected);
  }
  EXPECT_GT(stored, 30u);
}

TEST_P(RemoteDatabase, anotherRevisionTakesThePlaceOfAllTheOld) {
  const fs::path file = built(*folder_, scheme_, kind_);
  const fs::path objects = *folder_ / "revised.tdb";
  fs::remove_all(objects);
  const auto first = exportObjects(file, objects);
  ASSERT_TRUE(first);
  const auto again = exportObjects(file, objects);
  ASSERT_TRUE(again);
  EXPECT_EQ(first->revision, again->revision);
  const auto old = openRemoteDatabase(urlOf(objects), resources_).value();
  // What somebody else put there stays, whatever its name.
  fs::create_directory(objects / "20240101");
  ASSERT_TRUE(exportObjects(file, objects));
  EXPECT_TRUE(fs::exists(objects / "20240101"));
  const fs::path foreign = *folder_ / "photos";
  fs::create_directories(foreign / "20240101");
  EXPECT_EQ(exportObjects(file, foreign).error().code, Code::invalidArgument);
  fs::remove_all(foreign);
  // Another database under the same name: who has the old contents is told, and nothing of two is mixed.
  const fs::path other = *folder_ / "other.tdb";
  BuildOptions options{.output = other,
                       .inputs = {(*folder_ / "colour.tif").string()},
                       .kind = raster::Kind::imagery,
                       .scheme = scheme_,
                       .body = geo::mars()};
  ASSERT_TRUE(buildPyramid(options));
  ASSERT_TRUE(exportObjects(other, objects));
  EXPECT_FALSE(fs::exists(objects / first->revision));
  EXPECT_FALSE(fs::exists(objects / "exporting"));
  fs::remove(other);
  const auto id = tiling::Tiling(scheme_).tileAt(geo::directionFromDegrees(1.0, 1.0), 0);
  const auto gone = old->load(id);
  ASSERT_FALSE(gone);
  EXPECT_THAT(gone.error().message, HasSubstr("open it again"));
}

TEST_P(RemoteDatabase, damagedObjectsAreRefused) {
  const fs::path file = built(*folder_, scheme_, kind_);
  const fs::path objects = *folder_ / "damaged.tdb";
  fs::remove_all(objects);
  const auto exported = exportObjects(file, objects);
  ASSERT_TRUE(exported);
  const Bytes contents = bytesOf(objects / kContentsObject);
  const auto id = tiling::Tiling(scheme_).tileAt(geo::directionFromDegrees(1.0, 1.0), 0);
  const Bytes object = bytesOf(objects / objectName(exported->revision, id));
  ASSERT_TRUE(decodedObject(object, id, kind_));
  ASSERT_TRUE(decodedContents(contents, ""));
  auto random = geo::seededGenerator();
  const auto spoilt = [&](Bytes bytes) {
    const auto at = static_cast<std::size_t>(geo::uniform(random, 0, static_cast<double>(bytes.size()) - 0.5));
    if (geo::uniform(random, 0, 1) < 0.3) {
      bytes.resize(at);
    } else {
      bytes[at] ^= static_cast<std::byte>(1u << static_cast<unsigned int>(geo::uniform(random, 0, 7.99)));
    }
    return bytes;
  };
  for (int i = 0; i < 300; ++i) {
    EXPECT_FALSE(decodedObject(spoilt(object), id, kind_));
    EXPECT_FALSE(decodedContents(spoilt(contents), ""));
  }
  writeBytes(objects / objectName(exported->revision, id), spoilt(object));
  const auto remote = openRemoteDatabase(urlOf(objects), resources_);
  ASSERT_TRUE(remote);
  const auto loaded = (*remote)->load(id);
  ASSERT_FALSE(loaded);
  EXPECT_THAT(io::describe(loaded.error()), HasSubstr("tile 0/"));
}

/// With a right checksum at the end: what is in it is looked at.
Bytes withChecksum(Bytes bytes) {
  bytes.resize(bytes.size() - 4);
  io::Crc32 crc;
  crc.add(bytes);
  for (unsigned int shift = 0; shift < 32; shift += 8)
    bytes.push_back(static_cast<std::byte>((crc.value() >> shift) & 0xffu));
  return bytes;
}

Bytes withText(const Bytes& contents, const std::string& from, const std::string& to) {
  std::string text(reinterpret_cast<const char*>(contents.data()), contents.size());
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  const auto bytes = std::as_bytes(std::span(text));
  return withChecksum({bytes.begin(), bytes.end()});
}

TEST_P(RemoteDatabase, contentsThatLieAreRefused) {
  const fs::path file = built(*folder_, scheme_, kind_);
  const fs::path objects = *folder_ / "lying.tdb";
  fs::remove_all(objects);
  ASSERT_TRUE(exportObjects(file, objects));
  const Bytes contents = bytesOf(objects / kContentsObject);
  ASSERT_TRUE(decodedContents(withChecksum(contents), ""));
  std::string many = "tile_cells";
  for (int i = 0; i < 20000; ++i)
    many = "aaaa = 1\n" + many;
  const std::string level = "max_level = " + std::to_string(PyramidReader::open(file).value()->info().maxLevel);
  for (const auto& [from, to] : {std::pair<std::string, std::string>("tile_cells", many),
                                 {"tile_cells = ", "tile_cells = 3"},
                                 {level, "max_level = nan"},
                                 {level, "max_level = 1e9"},
                                 {"revision = \"", "revision = \"../"},
                                 {"kind = \"", "kind = \"x"},
                                 {"\n\n", "\n"}})
    EXPECT_FALSE(decodedContents(withText(contents, from, to), "")) << from << " as " << to.substr(0, 40);
  auto random = geo::seededGenerator();
  for (int i = 0; i < 2000; ++i) {
    Bytes bytes = contents;
    const auto at = static_cast<std::size_t>(geo::uniform(random, 0, static_cast<double>(bytes.size()) - 4.5));
    bytes[at] = static_cast<std::byte>(geo::uniform(random, 0, 255.9));
    static_cast<void>(decodedContents(withChecksum(bytes), ""));
  }
}

TEST(TileIndex, survivesWhateverComes) {
  auto random = geo::seededGenerator();
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes(static_cast<std::size_t>(geo::uniform(random, 0, 40)));
    for (std::byte& each : bytes)
      each = static_cast<std::byte>(geo::uniform(random, 0, geo::uniform(random, 0, 1) < 0.5 ? 16 : 255.9));
    if (bytes.size() > 4) bytes[1] = bytes[2] = bytes[3] = std::byte{0};
    const auto index = decodedIndex(bytes, 5, 12);
    if (!index) continue;
    EXPECT_EQ(decodedIndex(encodedIndex(*index), 5, 12)->nextCount(), index->nextCount());
    for (std::uint8_t level = 0; level < 7; ++level)
      static_cast<void>(index->find({.level = level, .root = 1, .x = 0, .y = 0}));
  }
}

TEST(RemoteDatabaseAddress, isOneByItsPath) {
  EXPECT_TRUE(isRemoteDatabase("https://host/a/earth.tdb"));
  EXPECT_TRUE(isRemoteDatabase("https://host/a/earth.tdb/"));
  EXPECT_TRUE(isRemoteDatabase("https://host/earth.tdb?token=secret"));
  EXPECT_TRUE(isRemoteDatabase("s3://bucket/earth.tdb"));
  EXPECT_FALSE(isRemoteDatabase("earth.tdb"));
  EXPECT_FALSE(isRemoteDatabase("https://host/wms?map=earth.tdb"));
}

}  // namespace
}  // namespace tellurion::pyramid::testing
