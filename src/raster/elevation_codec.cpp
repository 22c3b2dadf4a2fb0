#include <zstd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "raster/codec.h"

// Byte map: see codec.h.
namespace tellurion::raster {
namespace {

enum class Mode : std::uint8_t { fixedPoint = 1, float32 = 2 };

constexpr std::int64_t kLargestStep = std::int64_t{1} << 28;
constexpr double kCoarsestStep_m = 1e9;
constexpr int kCompressionLevel = 3;  // 6 takes two and a half times as long for 0.8% less
constexpr std::size_t kPlanes = 4;

bool isStep(double step_m) {
  return step_m > 0.0 && step_m <= kCoarsestStep_m;
}

std::uint32_t zigzag(std::int32_t v) {
  return (static_cast<std::uint32_t>(v) << 1u) ^ static_cast<std::uint32_t>(v >> 31);
}
std::int32_t unzigzag(std::uint32_t v) {
  return static_cast<std::int32_t>((v >> 1u) ^ (~(v & 1u) + 1u));
}

/// Guesses a sample from those before it in row order: the plane through left, above and above left.
class PlanePredictor {
 public:
  explicit PlanePredictor(int width) : above_(static_cast<std::size_t>(width) + 1, 0), here_(above_) {}

  std::int64_t guess(int col, int row) const {
    const auto c = static_cast<std::size_t>(col) + 1;
    if (row == 0) return col == 0 ? 0 : here_[c - 1];
    if (col == 0) return above_[c];
    const std::int64_t plane = here_[c - 1] + above_[c] - above_[c - 1];
    return plane;
  }
  void set(int col, std::int64_t value) { here_[static_cast<std::size_t>(col) + 1] = value; }
  void endRow() { std::swap(above_, here_); }

 private:
  std::vector<std::int64_t> above_;
  std::vector<std::int64_t> here_;
};

/// What a NODATA sample counts as for the guesses after it: the guess for itself, held inside the range of values.
std::int64_t standIn(std::int64_t guess) {
  return std::clamp(guess, -kLargestStep, kLargestStep);
}

/// Multiples of step, one code a sample: 0 is NODATA, else 1 + zigzag(value - guess). Nothing when a height does not
/// fit.
std::optional<std::vector<std::uint32_t>> fixedPointCodes(const Raster<float>& heights, double step_m) {
  std::vector<std::uint32_t> codes;
  codes.reserve(heights.samples.size());
  PlanePredictor predictor(heights.width);
  for (int row = 0; row < heights.height; ++row) {
    for (int col = 0; col < heights.width; ++col) {
      const float height = heights.at(col, row);
      const std::int64_t guess = predictor.guess(col, row);
      if (isNoData(height)) {
        codes.push_back(0);
        predictor.set(col, standIn(guess));
        continue;
      }
      const double exact = static_cast<double>(height) / step_m;
      const double steps = exact + std::copysign(0.5, exact);  // cut off below
      if (!(std::abs(steps) < static_cast<double>(kLargestStep) + 1.0)) return std::nullopt;
      const auto value = static_cast<std::int64_t>(steps);
      // |guess| <= 3 * 2^28, so the difference is within 2^30.
      codes.push_back(1 + zigzag(static_cast<std::int32_t>(value - guess)));
      predictor.set(col, value);
    }
    predictor.endRow();
  }
  return codes;
}

bool fixedPointHeights(const std::vector<std::uint32_t>& codes, double step_m, Raster<float>& heights) {
  PlanePredictor predictor(heights.width);
  std::size_t i = 0;
  for (int row = 0; row < heights.height; ++row) {
    for (int col = 0; col < heights.width; ++col) {
      const std::uint32_t code = codes[i];
      const std::int64_t guess = predictor.guess(col, row);
      if (code == 0) {
        heights.samples[i] = kNoData;
        predictor.set(col, standIn(guess));
      } else {
        const std::int64_t value = guess + unzigzag(code - 1);
        if (value < -kLargestStep || value > kLargestStep) return false;
        heights.samples[i] = static_cast<float>(static_cast<double>(value) * step_m);
        predictor.set(col, value);
      }
      ++i;
    }
    predictor.endRow();
  }
  return true;
}

/// Float bits in an order that follows the numbers, so that near heights have near codes.
std::uint32_t ordered(std::uint32_t bits) {
  return (bits & 0x80000000u) != 0 ? ~bits : bits | 0x80000000u;
}
std::uint32_t unordered(std::uint32_t code) {
  return (code & 0x80000000u) != 0 ? code & 0x7fffffffu : ~code;
}

std::vector<std::uint32_t> floatCodes(const Raster<float>& heights) {
  std::vector<std::uint32_t> codes;
  codes.reserve(heights.samples.size());
  std::uint32_t previous = 0;
  for (const float height : heights.samples) {
    const std::uint32_t value = ordered(std::bit_cast<std::uint32_t>(isNoData(height) ? kNoData : height));
    codes.push_back(zigzag(static_cast<std::int32_t>(value - previous)));
    previous = value;
  }
  return codes;
}

void floatHeights(const std::vector<std::uint32_t>& codes, Raster<float>& heights) {
  std::uint32_t previous = 0;
  for (std::size_t i = 0; i < codes.size(); ++i) {
    previous += static_cast<std::uint32_t>(unzigzag(codes[i]));
    const auto height = std::bit_cast<float>(unordered(previous));
    heights.samples[i] = isNoData(height) ? kNoData : height;
  }
}

/// All lowest bytes, then all second ones, ...: the high planes are nearly empty and compress to nothing.
std::vector<std::uint8_t> planesOf(const std::vector<std::uint32_t>& codes) {
  std::vector<std::uint8_t> planes(codes.size() * kPlanes);
  for (std::size_t plane = 0; plane < kPlanes; ++plane) {
    for (std::size_t i = 0; i < codes.size(); ++i) {
      planes[plane * codes.size() + i] = static_cast<std::uint8_t>(codes[i] >> (8 * plane));
    }
  }
  return planes;
}

std::vector<std::uint32_t> codesOf(const std::vector<std::uint8_t>& planes) {
  std::vector<std::uint32_t> codes(planes.size() / kPlanes, 0);
  for (std::size_t plane = 0; plane < kPlanes; ++plane) {
    for (std::size_t i = 0; i < codes.size(); ++i) {
      codes[i] |= static_cast<std::uint32_t>(planes[plane * codes.size() + i]) << (8 * plane);
    }
  }
  return codes;
}

struct FreeContext {
  void operator()(ZSTD_CCtx* c) const { ZSTD_freeCCtx(c); }
  void operator()(ZSTD_DCtx* d) const { ZSTD_freeDCtx(d); }
};

void appendCompressed(const std::vector<std::uint8_t>& planes, std::vector<std::byte>& out) {
  thread_local const std::unique_ptr<ZSTD_CCtx, FreeContext> context(ZSTD_createCCtx());
  const std::size_t head = out.size();
  out.resize(head + ZSTD_compressBound(planes.size()));
  const std::size_t size = ZSTD_compressCCtx(context.get(), out.data() + head, out.size() - head, planes.data(),
                                             planes.size(), kCompressionLevel);
  assert(ZSTD_isError(size) == 0);  // The bound was asked for, so only want of memory is left.
  out.resize(head + size);
}

bool decompress(std::span<const std::byte> bytes, std::vector<std::uint8_t>& planes) {
  thread_local const std::unique_ptr<ZSTD_DCtx, FreeContext> context(ZSTD_createDCtx());
  const std::size_t size = ZSTD_decompressDCtx(context.get(), planes.data(), planes.size(), bytes.data(), bytes.size());
  return ZSTD_isError(size) == 0 && size == planes.size();
}

std::array<std::byte, 8> littleEndian(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  std::array<std::byte, 8> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = static_cast<std::byte>(bits >> (8 * i));
  return bytes;
}

double doubleAt(std::span<const std::byte> bytes) {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < 8; ++i)
    bits |= std::to_integer<std::uint64_t>(bytes[i]) << (8 * i);
  return std::bit_cast<double>(bits);
}

io::Result<Raster<float>> corrupt(std::string why) {
  return io::fail(io::Failure::Code::corrupt, "elevation payload: " + std::move(why));
}

}  // namespace

std::vector<std::byte> encodeElevation(const Raster<float>& heights, double step_m) {
  std::vector<std::byte> out;
  if (isStep(step_m)) {
    if (const auto codes = fixedPointCodes(heights, step_m)) {
      out.push_back(static_cast<std::byte>(Mode::fixedPoint));
      const auto step = littleEndian(step_m);
      out.insert(out.end(), step.begin(), step.end());
      appendCompressed(planesOf(*codes), out);
      return out;
    }
  }
  out.push_back(static_cast<std::byte>(Mode::float32));
  appendCompressed(planesOf(floatCodes(heights)), out);
  return out;
}

io::Result<Raster<float>> decodeElevation(std::span<const std::byte> bytes, int width, int height) {
  if (width < 1 || height < 1 || width > kMaxCodecSide || height > kMaxCodecSide) {
    return io::fail(io::Failure::Code::invalidArgument, "an elevation raster has 1 to 16384 samples a side");
  }
  if (bytes.empty()) return corrupt("it is empty");
  const auto mode = static_cast<Mode>(bytes.front());
  bytes = bytes.subspan(1);
  double step_m = 0.0;
  if (mode == Mode::fixedPoint) {
    if (bytes.size() < 8) return corrupt("it ends inside the header");
    step_m = doubleAt(bytes);
    bytes = bytes.subspan(8);
    if (!isStep(step_m)) return corrupt("its step is not between 0 and 1e9 m");
  } else if (mode != Mode::float32) {
    return corrupt("its first byte names no known coding");
  }
  Raster<float> heights(width, height);
  std::vector<std::uint8_t> planes(heights.samples.size() * kPlanes);
  if (!decompress(bytes, planes)) return corrupt("its compressed part is damaged or has another size");
  const auto codes = codesOf(planes);
  if (mode == Mode::float32) {
    floatHeights(codes, heights);
  } else if (!fixedPointHeights(codes, step_m, heights)) {
    return corrupt("a height is out of range");
  }
  return heights;
}

}  // namespace tellurion::raster
