#pragma once

#include <functional>
#include <optional>

#include "raster/tile_source.h"

/// What tiles that are made at the moment they are asked for have in common.
namespace tellurion::raster {

int usualCells(Kind kind);

/// The first level whose samples are as fine as `spacing`, within a hundredth: heights everywhere, so that no sample of
/// theirs is lost; pictures as sampleSpacing() tells, which where it matters (HEALPix, whose pixels are longest at the
/// poles) is three quarters of that.
int levelOfSpacing(const tiling::Tiling& tiling, int cells, geo::Angle spacing, Kind kind);

/// What can be told of a tile from where the data lie and how fine they are: roots are stored; others where there may
/// be data in them and in all tiles over them, and the parent is too coarse for it. isCoarse(tile): the data are finer
/// than its samples; then they are for its parent.
TilePresence livePresence(const tiling::TileId& id, const std::function<bool(const tiling::TileId&)>& mayTouch,
                          const std::function<bool(const tiling::TileId&)>& isCoarse);

/// What can be said of a tile of heights while nobody has looked at what lies below it. The range is that of its own
/// samples. The error is an ESTIMATE and no bound: ground is taken to go on as rough as it is at this spacing, so that
/// half of the largest second difference of neighbouring samples (what leaving out every other sample would cost) goes
/// down by half at each level below, summed over these; at least 1/256 of the spacing, for what looks flat may not be,
/// at most half of it. 0 without levels below. A tile without any sample, with levels below, is taken to hold ground of
/// height 0, off by half the spacing.
HeightStatistics estimatedStatistics(const Raster<float>& samples, double spacing_m, int levelsBelow);

/// Of each child: the range of the tile widened by its error, and half of the error.
HeightStatistics estimatedOfChild(const HeightStatistics& tile, int levelsBelow);

/// The largest distance in metres of a child's samples to the surface of the tile over it, bilinear; negative where
/// there is no place where both have data. Gutters included in both.
double departureOfChild(const Raster<float>& tile, int quadrant, const Raster<float>& child);

/// A finished tile out of its samples, gutter included. departure_m: how far the samples of the next level depart from
/// it (departureOfChild), where somebody has looked. With one level below that is the error; with more it is taken to
/// halve at each, and the error to be the sum, at least 1/256 of the
/// spacing, which is still an estimate. Else estimatedStatistics.
SourceTile liveTile(Raster<float> samples, std::uint8_t childMask, const tiling::TileId& id, const TileSourceInfo& info,
                    std::optional<double> departure_m = std::nullopt);
/// The corners of the gutter are filled with the nearest pixel.
SourceTile liveTile(Raster<Rgba8> pixels, std::uint8_t childMask);

}  // namespace tellurion::raster
