#include "pyramid/tile_record.h"
#include "geo/seed_test.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

namespace tellurion::pyramid {
namespace {

using tiling::TileId;

TileId randomTile(std::mt19937_64& random) {
  TileId id;
  id.level = static_cast<std::uint8_t>(random() % (tiling::kMaxLevel + 1));
  id.root = static_cast<std::uint8_t>(random() % 12);
  id.x = static_cast<std::uint32_t>(random() % (std::uint64_t{1} << id.level));
  id.y = static_cast<std::uint32_t>(random() % (std::uint64_t{1} << id.level));
  return id;
}

/// CRC-32 bit by bit, as the polynomial division that it is.
std::uint32_t slowCrc(const std::vector<std::byte>& bytes) {
  std::uint32_t crc = 0xFFFFFFFFu;
  for (const std::byte b : bytes) {
    crc ^= std::to_integer<std::uint32_t>(b);
    for (int bit = 0; bit < 8; ++bit)
      crc = (crc >> 1u) ^ ((crc & 1u) != 0 ? 0xEDB88320u : 0u);
  }
  return ~crc;
}

TEST(RowNumber, ComesBackAsTheTile) {
  const std::uint64_t seed = geo::testSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  for (int i = 0; i < 100000; ++i) {
    const TileId id = randomTile(random);
    const std::int64_t row = rowNumberOf(id);
    ASSERT_GT(row, 0);
    ASSERT_EQ(tileOfRowNumber(row), id);
    ASSERT_GE(row, rowsOfLevel(id.level).first);
    ASSERT_LE(row, rowsOfLevel(id.level).last);
  }
}

TEST(RowNumber, RootsAndDeepestTiles) {
  EXPECT_EQ(rowNumberOf({.level = 0, .root = 0, .x = 0, .y = 0}), 16);
  EXPECT_EQ(rowNumberOf({.level = 0, .root = 11, .x = 0, .y = 0}), 27);
  EXPECT_EQ(rowNumberOf({.level = 1, .root = 1, .x = 1, .y = 0}), 69);
  EXPECT_EQ(rowNumberOf({.level = 1, .root = 1, .x = 0, .y = 1}), 70);
  const std::uint32_t last = (1u << 29u) - 1;
  const TileId deepest{.level = 29, .root = 11, .x = last, .y = last};
  EXPECT_EQ(tileOfRowNumber(rowNumberOf(deepest)), deepest);
}

TEST(RowNumber, ChildrenFollowTheOrderOfTheirParents) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 10000; ++i) {
    TileId a = randomTile(random);
    TileId b = randomTile(random);
    b.level = a.level;
    b.x %= 1u << a.level;
    b.y %= 1u << a.level;
    if (a.level == tiling::kMaxLevel || a == b) continue;
    ASSERT_EQ(rowNumberOf(a) < rowNumberOf(b), rowNumberOf(a.child(3)) < rowNumberOf(b.child(0)));
  }
}

TEST(RowNumber, OthersBelongToNoTile) {
  for (const std::int64_t row : {std::int64_t{-1}, std::int64_t{0}, std::int64_t{15}, std::int64_t{32},
                                 std::int64_t{63}, std::int64_t{128}, INT64_MIN}) {
    EXPECT_FALSE(tileOfRowNumber(row).has_value()) << row;
  }
  EXPECT_TRUE(tileOfRowNumber(INT64_MAX).has_value());  // level 29, root 15: for the tiling to refuse
}

TEST(ChildrenBytes, ComeBack) {
  std::array<raster::HeightStatistics, 4> children{};
  children[1] = {-12.5f, 8848.0f, 3.25f};
  children[3] = {0.0f, -0.0f, 1e-30f};
  const std::vector<std::byte> bytes = childrenBytes(children);
  ASSERT_EQ(bytes.size(), kChildrenBytes);
  const auto back = childrenFromBytes(std::span<const std::byte, kChildrenBytes>(bytes.data(), kChildrenBytes));
  EXPECT_TRUE(raster::isNoData(back[0].min_m));
  EXPECT_EQ(back[1].min_m, -12.5f);
  EXPECT_EQ(back[1].max_m, 8848.0f);
  EXPECT_EQ(back[1].error_m, 3.25f);
  EXPECT_EQ(back[3].error_m, 1e-30f);
  // -12.5f is 0xC1480000, lowest byte first.
  const std::array<int, 4> expected = {0x00, 0x00, 0x48, 0xC1};
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_EQ(std::to_integer<int>(bytes[12 + i]), expected[i]);
}

TEST(Checksum, IsCrc32OfRowMaskAndPayload) {
  TileRecord record;
  record.id = {.level = 1, .root = 1, .x = 1, .y = 0};
  record.childMask = 5;
  for (const char c : std::string("123456789"))
    record.payload.push_back(static_cast<std::byte>(c));
  EXPECT_EQ(slowCrc(record.payload), 0xCBF43926u);  // the published check value
  std::vector<std::byte> bytes(9);
  bytes[0] = std::byte{69};
  bytes[8] = std::byte{5};
  bytes.insert(bytes.end(), record.payload.begin(), record.payload.end());
  EXPECT_EQ(checksumOf(record, raster::Kind::imagery), slowCrc(bytes));
  EXPECT_NE(checksumOf(record, raster::Kind::elevation), slowCrc(bytes));
}

}  // namespace
}  // namespace tellurion::pyramid
