#include "render/draw_plan.h"

#include <algorithm>
#include <tuple>

namespace tellurion::render {
namespace {

using Kind = TileColours::Kind;

// With more draw calls than this, tiles with night lights are drawn like others of several pictures, which read all
// blocks at once.
constexpr std::size_t kMostGroups = 4;

std::uint32_t blockOf(const TexturePlace* place) {
  return place != nullptr ? place->block : 0;
}

}  // namespace

auto DrawPlan::Turn::group() const {
  return std::tie(chunk, kind, colourBlock, lampsBlock, reliefBlock);
}

bool DrawPlan::Turn::operator<(const Turn& o) const {
  return std::tuple_cat(group(), std::tie(distance, tile)) < std::tuple_cat(o.group(), std::tie(o.distance, o.tile));
}

void DrawPlan::make(const scene::Frame& frame, std::span<ResidentTile> tiles, std::span<const ResidentPicture> pictures,
                    const SnappedEye& eye) {
  colourTiles(frame, tiles, pictures);
  orderTiles(tiles, eye);
  if (countGroups() > kMostGroups) {
    for (ResidentTile& tile : tiles) {
      if (tile.colours.kind == Kind::night) tile.colours.kind = Kind::layered;
    }
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
  adjusts_ = std::ranges::any_of(
      frame.looks, [](const scene::LayerLook& look) { return look.visible && !look.nightLights && look.adjusts(); });
  for (ResidentTile& tile : tiles) {
    const auto ofTile = pictures.subspan(tile.tile->firstPicture, tile.tile->pictureCount);
    tile.colours = coloursOf(ofTile, frame.looks, lampsMayBurn(*tile.tile->mesh, frame.light), pictureRecords_);
  }
}

void DrawPlan::orderTiles(std::span<const ResidentTile> tiles, const SnappedEye& eye) {
  turns_.clear();
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const TileColours& colours = tiles[i].colours;
    const geo::Vec3f origin_rte(tiles[i].tile->mesh->origin.m - eye.eye_body);
    turns_.push_back({.chunk = tiles[i].mesh->chunk,
                      .kind = colours.kind,
                      .colourBlock = colours.kind == Kind::layered ? 0 : blockOf(colours.one.place),
                      .lampsBlock = colours.kind == Kind::night ? blockOf(colours.lamps.place) : 0,
                      .reliefBlock = blockOf(tiles[i].relief),
                      .distance = geo::dot(origin_rte, origin_rte),
                      .tile = static_cast<std::uint32_t>(i)});
  }
  std::sort(turns_.begin(), turns_.end());
}

std::size_t DrawPlan::countGroups() const {
  std::size_t count = turns_.empty() ? 0 : 1;
  for (std::size_t i = 1; i < turns_.size(); ++i)
    if (turns_[i].group() != turns_[i - 1].group()) ++count;
  return count;
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
                         .lampsBlock = turn.lampsBlock,
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
