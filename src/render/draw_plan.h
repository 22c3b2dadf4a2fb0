#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/layer_records.h"
#include "render/terrain_pass.h"
#include "scene/frame.h"

namespace tellurion::render {

/// Tiles that go out in one draw call: what it reads, and its commands.
struct DrawGroup {
  TileColours::Kind kind = TileColours::Kind::one;
  std::uint32_t colourBlock = 0;  ///< of `one` and `night`; tiles of several pictures read all blocks
  std::uint32_t secondBlock = 0;  ///< of `lamps`, `water` and `both`
  std::uint32_t thirdBlock = 0;   ///< of `both`
  std::uint32_t reliefBlock = 0;  ///< of `one` and `night`
  float nearest = 0.0f;           ///< squared distance of its nearest tile
  CommandRun run;
};

/// A frame's ground goes out in at most so many draw calls, or in one for each chunk of meshes where there are more
/// chunks; GeometryArena has no more.
inline constexpr std::size_t kMostDrawCalls = 4;

/// Which draw calls make a frame's ground, in which order, and what the GPU reads for them. Plain data without OpenGL;
/// allocates nothing once frames repeat. One thread only.
class DrawPlan {
 public:
  /// The places of tiles and of pictures (of Frame::pictures) are those of this frame; tells tiles their colours.
  void make(const scene::Frame& frame, std::span<ResidentTile> tiles, std::span<const ResidentPicture> pictures,
            const SnappedEye& eye);

  std::span<const DrawGroup> groups() const { return groups_; }         ///< from near to far
  std::span<const CommandRun> chunkRuns() const { return chunkRuns_; }  ///< all commands, a run a chunk of meshes
  std::span<const TileRecord> records() const { return records_; }      ///< of the tiles
  std::span<const DrawCommand> commands() const { return commands_; }
  std::span<const PictureRecord> pictureRecords() const { return pictureRecords_; }
  bool adjusts() const { return adjusts_; }  ///< some layer's colours
  std::int64_t triangles() const;

 private:
  /// A tile in the order of drawing: by what one draw call may read, then from near to far.
  struct Turn {
    std::uint32_t chunk = 0;
    TileColours::Kind kind = TileColours::Kind::one;
    std::uint32_t colourBlock = 0;
    std::uint32_t secondBlock = 0;
    std::uint32_t thirdBlock = 0;
    std::uint32_t reliefBlock = 0;
    float distance = 0.0f;
    std::uint32_t tile = 0;

    auto group() const;
    bool operator<(const Turn& o) const;
  };
  /// Turns of one group.
  struct Part {
    std::uint32_t chunk = 0;
    TileColours::Kind kind = TileColours::Kind::one;
    std::size_t first = 0;
    std::size_t count = 0;
  };
  void colourTiles(const scene::Frame& frame, std::span<ResidentTile> tiles, std::span<const ResidentPicture> pictures);
  void orderTiles(std::span<const ResidentTile> tiles, const SnappedEye& eye);
  void findParts();
  void mergeParts(std::span<ResidentTile> tiles);
  void writeCommands(std::span<const ResidentTile> tiles);

  std::vector<Turn> turns_;
  std::vector<Part> parts_;
  std::vector<TileRecord> records_;
  std::vector<DrawCommand> commands_;
  std::vector<PictureRecord> pictureRecords_;
  std::vector<DrawGroup> groups_;
  std::vector<CommandRun> chunkRuns_;
  bool adjusts_ = false;
};

}  // namespace tellurion::render
