#include "render/draw_plan.h"

#include <algorithm>
#include <tuple>

namespace tellurion::render {
namespace {

using Kind = TileColours::Kind;

std::uint32_t blockOf(const TexturePlace* place) {
  return place != nullptr ? place->block : 0;
}

}  // namespace

auto DrawPlan::Turn::group() const {
  return std::tie(chunk, kind, colourBlock, secondBlock, thirdBlock, reliefBlock);
}

bool DrawPlan::Turn::operator<(const Turn& o) const {
  return std::tuple_cat(group(), std::tie(distance, tile)) < std::tuple_cat(o.group(), std::tie(o.distance, o.tile));
}

void DrawPlan::make(const scene::Frame& frame, std::span<ResidentTile> tiles, std::span<const ResidentPicture> pictures,
                    const SnappedEye& eye) {
  colourTiles(frame, tiles, pictures);
  orderTiles(tiles, eye);
  findParts();
  if (parts_.size() > kMostDrawCalls) {
    mergeParts(tiles);
    orderTiles(tiles, eye);
  }
  const geo::Vec3f ground = bareGround(frame);
  records_.clear();
  for (const ResidentTile& tile : tiles)
    records_.push_back(recordOf(tile, eye, ground));
  writeCommands(tiles);
}

std::int64_t DrawPlan::triangles() const {
  std::int64_t indices = 0;
  for (const DrawCommand& command : commands_)
    indices += command.count;
  return indices / 3;
}

void DrawPlan::colourTiles(const scene::Frame& frame, std::span<ResidentTile> tiles,
                           std::span<const ResidentPicture> pictures) {
  pictureRecords_.clear();
  adjusts_ = std::ranges::any_of(frame.looks, [](const scene::LayerLook& look) {
    return look.visible && look.role == scene::LayerRole::colour && look.adjusts();
  });
  for (ResidentTile& tile : tiles) {
    const auto ofTile = pictures.subspan(tile.tile->firstPicture, tile.tile->pictureCount);
    tile.colours = coloursOf(ofTile, frame.looks, effectsOn(*tile.tile->mesh, frame.light), pictureRecords_);
  }
}

void DrawPlan::orderTiles(std::span<const ResidentTile> tiles, const SnappedEye& eye) {
  turns_.clear();
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const TileColours& colours = tiles[i].colours;
    const bool readsAll = colours.kind == Kind::layered;
    const geo::Vec3f origin_rte(tiles[i].tile->mesh->origin.m - eye.eye_body);
    turns_.push_back({.chunk = tiles[i].mesh->chunk,
                      .kind = colours.kind,
                      .colourBlock = readsAll ? 0 : blockOf(colours.one.place),
                      .secondBlock = readsAll ? 0 : blockOf(colours.second.place),
                      .thirdBlock = readsAll ? 0 : blockOf(colours.third.place),
                      .reliefBlock = readsAll ? 0 : blockOf(tiles[i].relief),
                      .distance = geo::dot(origin_rte, origin_rte),
                      .tile = static_cast<std::uint32_t>(i)});
  }
  std::sort(turns_.begin(), turns_.end());
}

void DrawPlan::findParts() {
  parts_.clear();
  for (std::size_t i = 0; i < turns_.size(); ++i) {
    if (i == 0 || turns_[i].group() != turns_[i - 1].group())
      parts_.push_back({.chunk = turns_[i].chunk, .kind = turns_[i].kind, .first = i, .count = 0});
    ++parts_.back().count;
  }
}

/// Tiles of several pictures read all blocks, so those of a chunk go out together, and any tile may be drawn like them.
/// That costs more a pixel, so the parts of fewest tiles are, and no more of them than must.
void DrawPlan::mergeParts(std::span<ResidentTile> tiles) {
  std::ranges::sort(parts_, {}, [](const Part& part) { return part.count; });
  std::size_t calls = parts_.size();
  for (Part& part : parts_) {
    if (calls <= kMostDrawCalls) return;
    const auto isBeside = [&](const Part& other) { return &other != &part && other.chunk == part.chunk; };
    if (part.kind == Kind::layered || std::ranges::none_of(parts_, isBeside)) continue;
    const auto takesIt = [&](const Part& other) { return isBeside(other) && other.kind == Kind::layered; };
    if (std::ranges::any_of(parts_, takesIt)) --calls;
    part.kind = Kind::layered;
    for (std::size_t i = part.first; i < part.first + part.count; ++i)
      tiles[turns_[i].tile].colours.kind = Kind::layered;
  }
}

void DrawPlan::writeCommands(std::span<const ResidentTile> tiles) {
  commands_.clear();
  groups_.clear();
  chunkRuns_.clear();
  const Turn* before = nullptr;
  for (const Turn& turn : turns_) {
    const CommandRun empty{.chunk = turn.chunk, .first = commands_.size(), .count = 0};
    if (before == nullptr || before->group() != turn.group())
      groups_.push_back({.kind = turn.kind,
                         .colourBlock = turn.colourBlock,
                         .secondBlock = turn.secondBlock,
                         .thirdBlock = turn.thirdBlock,
                         .reliefBlock = turn.reliefBlock,
                         .nearest = turn.distance,
                         .run = empty});
    if (chunkRuns_.empty() || chunkRuns_.back().chunk != turn.chunk) chunkRuns_.push_back(empty);
    appendCommands(tiles[turn.tile], turn.tile, commands_);
    groups_.back().run.count = commands_.size() - groups_.back().run.first;
    chunkRuns_.back().count = commands_.size() - chunkRuns_.back().first;
    before = &turn;
  }
  std::ranges::sort(groups_, {}, [](const DrawGroup& group) { return group.nearest; });
}

}  // namespace tellurion::render
