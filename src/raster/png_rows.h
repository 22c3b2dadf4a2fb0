#pragma once

#include <filesystem>
#include <memory>

#include "io/failure.h"
#include "raster/raster.h"

namespace tellurion::raster {

/// Writes an opaque picture a band of rows after the other, so that it never is in memory as a whole. The file appears
/// under its name when finish() has succeeded, not before; a device or a pipe is written to. Move-only; one thread
/// only.
class PngRows {
 public:
  /// Sides from 1 to 1,000,000, libpng's own bound.
  static io::Result<PngRows> create(const std::filesystem::path& path, int width, int height);
  ~PngRows();
  PngRows(PngRows&&) noexcept;
  PngRows& operator=(PngRows&&) noexcept;

  /// The next rows, as wide as the picture; alpha does not count.
  io::Result<void> write(const Raster<Rgba8>& rows);
  /// All rows were written.
  io::Result<void> finish();

 private:
  struct Parts;
  explicit PngRows(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace tellurion::raster
