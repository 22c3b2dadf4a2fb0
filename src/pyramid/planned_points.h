#pragma once

#include <memory>
#include <string>

#include "pyramid/build_plan.h"
#include "raster/point_layer.h"

/// Layers of points as inputs of a build. The ground of each spacing that a layer has is an input of its own, as deep
/// as that spacing asks for: so tiles are deep where points are dense, and coarse elsewhere.
namespace tellurion::pyramid {

struct PointInput {
  std::string path;
  raster::PointLayerInfo layer;
  std::shared_ptr<const raster::PointGround> ground;
  raster::RasterInfo infoOf(int spacingLevel) const;
};

/// Reads all points into memory: a quarter of BuildOptions::memoryBytes at most, with those of the plan's inputs, else
/// invalidArgument. Where BuildOptions::maxLevel asks for less than they are dense, those of a sample are averaged,
/// when all are read.
io::Result<PointInput> openPointGround(const std::string& path, const BuildOptions& options, const BuildPlan& plan);

/// What points and their triangles take while the ground lives, but for kBytesToMakeABlock of each thread.
std::uint64_t bytesOfPoints(const raster::PointGround& ground);

}  // namespace tellurion::pyramid
