#include "raster/colour_bands.h"

#include <fmt/format.h>
#include <gdal_priv.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string_view>

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;
constexpr std::size_t kSide = PixelStore<Rgba8>::kSide;

int bandMeaning(GDALDataset& dataset, GDALColorInterp meaning) {
  for (int i = 1; i <= dataset.GetRasterCount(); ++i) {
    if (dataset.GetRasterBand(i)->GetColorInterpretation() == meaning) return i;
  }
  return 0;
}

/// Red, green, blue; or one band for a palette or grey. Empty: nothing to make a picture of.
std::vector<int> pictureBands(GDALDataset& dataset) {
  const int red = bandMeaning(dataset, GCI_RedBand);
  const int green = bandMeaning(dataset, GCI_GreenBand);
  const int blue = bandMeaning(dataset, GCI_BlueBand);
  if (red != 0 && green != 0 && blue != 0) return {red, green, blue};
  if (const int palette = bandMeaning(dataset, GCI_PaletteIndex); palette != 0) return {palette};
  std::vector<int> others;
  for (int i = 1; i <= dataset.GetRasterCount(); ++i) {
    if (dataset.GetRasterBand(i)->GetColorInterpretation() != GCI_AlphaBand) others.push_back(i);
  }
  if (others.size() >= 3) return {others[0], others[1], others[2]};
  if (!others.empty()) others.resize(1);
  return others;
}

std::uint8_t byteOf(double v) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(v, 0.0, 255.0)));
}

int statedBits(GDALRasterBand& band) {
  const char* text = band.GetMetadataItem("NBITS", "IMAGE_STRUCTURE");
  const int bits = text != nullptr ? std::atoi(text) : 0;
  return bits >= 1 && bits <= 16 ? bits : 0;
}

std::uint8_t* channel(Rgba8* block, std::size_t band) {
  auto* bytes = reinterpret_cast<std::uint8_t*>(block);
  return bytes + band;
}

template <class Visit>
void forEachPixel(const Window& window, Rgba8* block, const Visit& visit) {
  for (std::size_t row = 0; row < static_cast<std::size_t>(window.height); ++row) {
    for (std::size_t i = row * kSide; i < row * kSide + static_cast<std::size_t>(window.width); ++i)
      visit(block[i], i);
  }
}

}  // namespace

io::Result<ColourBands> ColourBands::open(GDALDataset& dataset, const std::string& path,
                                          const std::optional<double>& nodata, std::vector<std::string>& warnings) {
  const std::vector<int> numbers = pictureBands(dataset);
  if (numbers.empty()) return io::fail(Code::unsupported, "has no band to make a picture of", path);
  GDALRasterBand& first = *dataset.GetRasterBand(numbers.front());
  if (first.GetColorInterpretation() == GCI_CyanBand) {
    return io::fail(Code::unsupported, "its colours are for print (CMYK); convert it to RGB first", path);
  }
  auto levels = bandLevels(dataset, numbers, path);
  if (!levels) return tl::unexpected(std::move(levels.error()));
  ColourBands colours;
  colours.path_ = path;
  colours.levels_ = std::move(*levels);
  if (nodata || colours.levels_.front().mask == nullptr) {
    for (GDALRasterBand* band : colours.levels_.front().bands) {
      const auto value = noDataOf(*band, nodata, path);
      if (!value) return tl::unexpected(value.error());
      if (*value) colours.nodata_.push_back(**value);
    }
    if (colours.nodata_.size() != numbers.size()) colours.nodata_.clear();
  }
  colours.setPalette(first);
  if (auto done = colours.findScale(dataset, warnings); !done) return tl::unexpected(std::move(done.error()));
  if (numbers.size() == 3 && bandMeaning(dataset, GCI_RedBand) == 0) {
    warnings.push_back(fmt::format("has {} bands without a colour: {}, {} and {} are shown as red, green and blue",
                                   dataset.GetRasterCount(), numbers[0], numbers[1], numbers[2]));
  }
  return colours;
}

void ColourBands::setPalette(GDALRasterBand& band) {
  const GDALColorTable* table = band.GetColorTable();
  if (levels_.front().bands.size() != 1 || table == nullptr || table->GetPaletteInterpretation() != GPI_RGB) return;
  if (band.GetColorInterpretation() != GCI_PaletteIndex) return;
  const int count = std::min(table->GetColorEntryCount(), 65536);
  for (int i = 0; i < count; ++i) {
    const GDALColorEntry& e = *table->GetColorEntry(i);
    palette_.push_back({byteOf(e.c1), byteOf(e.c2), byteOf(e.c3), byteOf(e.c4)});
  }
}

io::Result<void> ColourBands::findScale(GDALDataset& dataset, std::vector<std::string>& warnings) {
  const auto& bands = levels_.front().bands;
  const bool bytes = std::ranges::all_of(bands, [](auto* b) { return b->GetRasterDataType() == GDT_Byte; });
  const int bits = statedBits(*bands.front());
  plain_ = bytes && (bits == 0 || bits == 8 || !palette_.empty());
  if (plain_ || !palette_.empty()) return {};
  const bool isPng = std::string_view(dataset.GetDriverName()) == "PNG";
  const bool isUnsigned = bytes || bands.front()->GetRasterDataType() == GDT_UInt16;
  if (isUnsigned && (bits != 0 || isPng)) {
    white_ = bits != 0 ? std::exp2(bits) - 1.0 : 65535.0;
    return {};
  }
  auto sample = sparseSample();
  if (!sample) return tl::unexpected(std::move(sample.error()));
  if (!sample->empty()) {
    std::ranges::sort(*sample);
    const auto last = static_cast<double>(sample->size() - 1);
    black_ = (*sample)[static_cast<std::size_t>(std::floor(0.005 * last))];
    white_ = (*sample)[static_cast<std::size_t>(std::ceil(0.995 * last))];
  }
  if (!(white_ > black_)) white_ = black_ + 1.0;
  warnings.push_back(fmt::format("its values {:.6g} to {:.6g} are shown as black to white", black_, white_));
  return {};
}

/// Values of all bands from up to 8 x 8 small windows spread over the raster.
io::Result<std::vector<double>> ColourBands::sparseSample() {
  constexpr int kAcross = 8;
  constexpr int kWindow = 64;
  const BandLevel& level = levels_.front();
  std::vector<double> sample;
  values_.resize(kSide * kSide);
  const int width = std::min(kWindow, level.width);
  const int height = std::min(kWindow, level.height);
  const int across = std::min(kAcross, (level.width + width - 1) / width);
  const int down = std::min(kAcross, (level.height + height - 1) / height);
  for (int i = 0; i < across * down; ++i) {
    const auto col = static_cast<int>(std::int64_t{level.width - width} * (i % across) / std::max(1, across - 1));
    const auto row = static_cast<int>(std::int64_t{level.height - height} * (i / across) / std::max(1, down - 1));
    for (std::size_t b = 0; b < level.bands.size(); ++b) {
      const Window window{0, col, row, width, height};
      if (auto done = readValues(*level.bands[b], window, values_.data(), path_); !done) {
        return tl::unexpected(std::move(done.error()));
      }
      const auto columns = static_cast<std::size_t>(width);
      for (std::size_t k = 0; k < columns * static_cast<std::size_t>(height); ++k) {
        const double v = values_[k / columns * kSide + k % columns];
        if (std::isfinite(v) && (nodata_.empty() || !nodata_[b].matches(v))) sample.push_back(v);
      }
    }
  }
  return sample;
}

io::Result<void> ColourBands::read(const Window& window, Rgba8* block) {
  const BandLevel& level = levels_[static_cast<std::size_t>(window.level)];
  auto done = plain_ ? readPlain(level, window, block) : readScaled(level, window, block);
  if (!done || level.mask == nullptr) return done;
  return applyMask(level, window, block);
}

io::Result<void> ColourBands::readPlain(const BandLevel& level, const Window& window, Rgba8* block) {
  for (std::size_t b = 0; b < level.bands.size(); ++b) {
    if (auto done = readBytes(*level.bands[b], window, channel(block, b), sizeof(Rgba8), path_); !done) return done;
  }
  const bool single = level.bands.size() == 1;
  forEachPixel(window, block, [&](Rgba8& p, std::size_t) {
    p.a = 255;
    if (single) p.g = p.b = p.r;
  });
  if (!nodata_.empty()) applyNoData(window, block);
  if (palette_.empty()) return {};
  forEachPixel(window, block, [&](Rgba8& p, std::size_t) {
    const bool covered = p.a != 0;
    p = covered && p.r < palette_.size() ? palette_[p.r] : Rgba8{};
  });
  return {};
}

void ColourBands::applyNoData(const Window& window, Rgba8* block) const {
  forEachPixel(window, block, [&](Rgba8& p, std::size_t) {
    const std::array<std::uint8_t, 3> stored{p.r, p.g, p.b};
    bool all = true;
    for (std::size_t b = 0; b < nodata_.size(); ++b)
      all = all && nodata_[b].matches(stored[b]);
    if (all) p = {};
  });
}

io::Result<void> ColourBands::readScaled(const BandLevel& level, const Window& window, Rgba8* block) {
  values_.resize(kSide * kSide);
  std::vector<std::uint8_t> empty(kSide * kSide, 1);  // 1 while all bands so far hold no data
  const double perStep = 255.0 / (white_ - black_);
  for (std::size_t b = 0; b < level.bands.size(); ++b) {
    if (auto done = readValues(*level.bands[b], window, values_.data(), path_); !done) return done;
    std::uint8_t* out = channel(block, b);
    forEachPixel(window, block, [&](Rgba8&, std::size_t i) {
      const double v = values_[i];
      const bool none = !std::isfinite(v) || (!nodata_.empty() && nodata_[b].matches(v));
      if (!none) empty[i] = 0;
      out[i * sizeof(Rgba8)] = none ? std::uint8_t{0} : byteOf((v - black_) * perStep);
    });
  }
  const bool single = level.bands.size() == 1;
  forEachPixel(window, block, [&](Rgba8& p, std::size_t i) {
    p.a = empty[i] != 0 ? 0 : 255;
    if (single) p.g = p.b = p.r;
    if (palette_.empty() || p.a == 0) return;
    const double index = values_[i];
    p = index >= 0.0 && index < static_cast<double>(palette_.size()) ? palette_[static_cast<std::size_t>(index)]
                                                                     : Rgba8{};
  });
  return {};
}

io::Result<void> ColourBands::applyMask(const BandLevel& level, const Window& window, Rgba8* block) {
  mask_.resize(kSide * kSide);
  if (auto done = readBytes(*level.mask, window, mask_.data(), 1, path_); !done) return done;
  forEachPixel(window, block, [&](Rgba8& p, std::size_t i) {
    if (mask_[i] == 0) p = {};
    if (mask_[i] < p.a) p.a = mask_[i];
  });
  return {};
}

}  // namespace tellurion::raster
