#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "raster/tile_source.h"

namespace tellurion::raster {

/// Several preparations as one.
class JointPreparation final : public Preparation {
 public:
  /// As TileSource::prepare of one part.
  using Part = std::function<std::unique_ptr<Preparation>(double priority, std::function<void()> ready)>;

  /// Begins all; `ready` is called when all of them are, as TileSource::prepare says. Null: none has to wait.
  static std::unique_ptr<Preparation> begin(std::span<const Part> parts, double priority, std::function<void()> ready);
  void setPriority(double priority) override;

 private:
  explicit JointPreparation(std::vector<std::unique_ptr<Preparation>> parts) : parts_(std::move(parts)) {}
  std::vector<std::unique_ptr<Preparation>> parts_;
};

}  // namespace tellurion::raster
