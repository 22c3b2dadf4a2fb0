#include "pyramid/tile_index.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace tellurion::pyramid {
namespace {

constexpr std::uint8_t kAllChildren = 15;

std::uint64_t ones(unsigned int bits) {
  return static_cast<std::uint64_t>(std::popcount(bits));
}

tl::unexpected<io::Failure> damaged() {
  return io::fail(io::Failure::Code::corrupt, "the index of tiles is damaged; export the database again", {});
}

/// What is left to read.
struct Reader {
  std::span<const std::byte> bytes;
  std::size_t at = 0;

  bool isAtEnd() const { return at == bytes.size(); }
  std::uint8_t byte() { return isAtEnd() ? 0 : std::to_integer<std::uint8_t>(bytes[at++]); }
  std::uint64_t number() {
    std::uint64_t out = 0;
    for (unsigned int shift = 0; shift < 56; shift += 7) {
      const std::uint64_t next = byte();
      out |= (next & 127u) << shift;
      if (next < 128) break;
    }
    return out;
  }
};

}  // namespace

void TileIndex::addLevel(std::vector<std::uint8_t> masks) {
  Level level{.masks = std::move(masks), .before = {}};
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < level.masks.size(); ++i) {
    if (i % kBlock == 0) level.before.push_back(count);
    count += ones(level.masks[i]);
  }
  level.before.push_back(count);
  levels_.push_back(std::move(level));
}

std::uint64_t TileIndex::nextCount() const {
  return levels_.empty() ? ones(roots_) : levels_.back().before.back();
}

raster::TilePresence TileIndex::find(const tiling::TileId& id) const {
  if (id.level >= levels_.size() || ((roots_ >> id.root) & 1u) == 0) return {};
  std::uint64_t place = ones(roots_ & ((1u << id.root) - 1u));
  for (int l = 0;; ++l) {
    const Level& level = levels_[static_cast<std::size_t>(l)];
    const std::uint8_t mask = level.masks[place];
    if (l == id.level) return {.stored = true, .childMask = mask};
    const auto quadrant = static_cast<unsigned int>(id.ancestor(l + 1).quadrant());
    if (((mask >> quadrant) & 1u) == 0) return {};
    std::uint64_t below = level.before[place / kBlock] + ones(mask & ((1u << quadrant) - 1u));
    for (std::uint64_t i = place / kBlock * kBlock; i < place; ++i)
      below += ones(level.masks[i]);
    place = below;
  }
}

std::vector<std::byte> encodedIndex(const TileIndex& index) {
  std::vector<std::byte> out;
  for (unsigned int shift = 0; shift < 32; shift += 8)
    out.push_back(static_cast<std::byte>((index.roots() >> shift) & 0xffu));
  for (int level = 0; level < index.levels(); ++level) {
    const auto masks = index.masksOf(level);
    for (auto at = masks.begin(); at != masks.end();) {
      const auto end = std::find_if(at, masks.end(), [&](std::uint8_t mask) { return mask != *at; });
      out.push_back(static_cast<std::byte>(*at));
      auto count = static_cast<std::uint64_t>(end - at);
      for (; count > 127; count >>= 7u)
        out.push_back(static_cast<std::byte>((count & 127u) | 128u));
      out.push_back(static_cast<std::byte>(count));
      at = end;
    }
  }
  return out;
}

io::Result<TileIndex> decodedIndex(std::span<const std::byte> bytes, int levels, int rootCount) {
  Reader reader{bytes};
  std::uint32_t roots = 0;
  for (unsigned int shift = 0; shift < 32; shift += 8)
    roots |= static_cast<std::uint32_t>(reader.byte()) << shift;
  if ((roots >> static_cast<unsigned int>(rootCount)) != 0) return damaged();
  TileIndex index(roots);
  std::uint64_t all = 0;
  for (int level = 0; level < levels; ++level) {
    const std::uint64_t count = index.nextCount();
    all += count;
    if (all > TileIndex::kMostTiles)
      return io::fail(io::Failure::Code::unsupported, "more tiles than this program keeps an index of", {});
    std::vector<std::uint8_t> masks;
    masks.reserve(count);
    while (masks.size() < count) {
      const std::uint8_t mask = reader.byte();
      const std::uint64_t run = reader.number();
      const bool leadsNowhere = level + 1 == levels && mask != 0;
      if (mask > kAllChildren || leadsNowhere || run == 0 || run > count - masks.size()) return damaged();
      masks.insert(masks.end(), run, mask);
    }
    index.addLevel(std::move(masks));
  }
  return reader.isAtEnd() ? io::Result<TileIndex>(std::move(index)) : damaged();
}

}  // namespace tellurion::pyramid
