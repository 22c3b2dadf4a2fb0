#include <csetjmp>
#include <cstdio>
#include <cstdlib>

#include <jpeglib.h>  // Needs <cstdio> before it.

#include <jerror.h>

#include <array>
#include <string>

#include "raster/image_formats.h"

// libjpeg reports errors through a callback that must not return. Ours jumps back to the one function that called
// setjmp; in such a function, and in those below it, nothing has a destructor.
namespace tellurion::raster {
namespace {

/// A progressive picture may hold any number of scans over the whole of it, each costing a full pass.
constexpr int kMaxScans = 64;

struct ErrorTrap {
  jpeg_error_mgr manager{};
  std::jmp_buf back{};
  std::array<char, JMSG_LENGTH_MAX> message{};
};

ErrorTrap& trapOf(j_common_ptr codec) {
  return *static_cast<ErrorTrap*>(codec->client_data);
}

[[noreturn]] void onError(j_common_ptr codec) {
  ErrorTrap& trap = trapOf(codec);
  trap.manager.format_message(codec, trap.message.data());
  std::longjmp(trap.back, 1);
}

/// libjpeg goes on after damage, with grey; of those warnings the ones that mean missing data are errors here.
void onMessage(j_common_ptr codec, int level) {
  const int code = trapOf(codec).manager.msg_code;
  if (level < 0 && (code == JWRN_JPEG_EOF || code == JWRN_HIT_MARKER || code == JWRN_HUFF_BAD_CODE)) onError(codec);
}

void onScan(j_common_ptr codec) {
  // Only ever hung on decompressors, whose first members these are.
  const auto* decompressor = reinterpret_cast<j_decompress_ptr>(codec);
  if (decompressor->input_scan_number <= kMaxScans) return;
  trapOf(codec).manager.msg_code = JERR_BAD_PROGRESSION;
  onError(codec);
}

void arm(ErrorTrap& trap) {
  jpeg_std_error(&trap.manager);
  trap.manager.error_exit = onError;
  trap.manager.emit_message = onMessage;
}

/// Owns a decompressor. Not movable: libjpeg keeps pointers into it.
struct Decompressor {
  ErrorTrap trap;
  jpeg_decompress_struct codec{};
  jpeg_progress_mgr progress{};

  Decompressor() {
    arm(trap);
    codec.err = &trap.manager;
    codec.client_data = &trap;
  }
  ~Decompressor() { jpeg_destroy_decompress(&codec); }
  Decompressor(const Decompressor&) = delete;
  Decompressor& operator=(const Decompressor&) = delete;

  bool readHeader(const unsigned char* data, unsigned long size) {
    if (setjmp(trap.back) != 0) return false;
    jpeg_create_decompress(&codec);
    progress.progress_monitor = onScan;
    codec.progress = &progress;
    jpeg_mem_src(&codec, data, size);
    jpeg_read_header(&codec, TRUE);
    return true;
  }

  bool readPixels(unsigned char* pixels, std::size_t stride) {
    if (setjmp(trap.back) != 0) return false;
    codec.out_color_space = JCS_EXT_RGBA;
    codec.dct_method = JDCT_ISLOW;
    jpeg_start_decompress(&codec);
    while (codec.output_scanline < codec.output_height) {
      unsigned char* row = pixels + stride * codec.output_scanline;
      jpeg_read_scanlines(&codec, &row, 1);
    }
    jpeg_finish_decompress(&codec);
    return true;
  }
};

/// Owns a compressor and the buffer that it writes to, which is large enough for any picture of the given size.
struct Compressor {
  ErrorTrap trap;
  jpeg_compress_struct codec{};
  std::vector<unsigned char> buffer;
  unsigned char* bytes = nullptr;
  unsigned long size = 0;

  Compressor(int width, int height)
      : buffer((static_cast<std::size_t>(width) + 16) * (static_cast<std::size_t>(height) + 16) * 6 + 4096),
        bytes(buffer.data()),
        size(buffer.size()) {
    arm(trap);
    codec.err = &trap.manager;
    codec.client_data = &trap;
  }
  ~Compressor() {
    jpeg_destroy_compress(&codec);
    if (bytes != buffer.data()) std::free(bytes);
  }
  Compressor(const Compressor&) = delete;
  Compressor& operator=(const Compressor&) = delete;

  bool write(const unsigned char* pixels, int width, int height, int quality) {
    if (setjmp(trap.back) != 0) return false;
    jpeg_create_compress(&codec);
    jpeg_mem_dest(&codec, &bytes, &size);
    codec.image_width = static_cast<JDIMENSION>(width);
    codec.image_height = static_cast<JDIMENSION>(height);
    codec.input_components = 4;
    codec.in_color_space = JCS_EXT_RGBX;
    jpeg_set_defaults(&codec);
    jpeg_set_quality(&codec, quality, TRUE);
    codec.dct_method = JDCT_ISLOW;
    jpeg_start_compress(&codec, TRUE);
    while (codec.next_scanline < codec.image_height) {
      // libjpeg does not write to its input, its type only lacks the const.
      auto* row = const_cast<JSAMPROW>(pixels + std::size_t{codec.next_scanline} * codec.image_width * 4);
      jpeg_write_scanlines(&codec, &row, 1);
    }
    jpeg_finish_compress(&codec);
    return true;
  }
};

auto failed(const ErrorTrap& trap, io::Failure::Code code = io::Failure::Code::corrupt) {
  return io::fail(code, std::string("JPEG: ") + trap.message.data());
}

io::Result<ImageSize> openedSize(Decompressor& jpeg, std::span<const std::byte> bytes) {
  if (!jpeg.readHeader(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size())) return failed(jpeg.trap);
  return ImageSize{static_cast<int>(jpeg.codec.image_width), static_cast<int>(jpeg.codec.image_height)};
}

}  // namespace

io::Result<ImageSize> jpegSize(std::span<const std::byte> bytes) {
  Decompressor jpeg;
  return openedSize(jpeg, bytes);
}

io::Result<void> decodeJpeg(std::span<const std::byte> bytes, Raster<Rgba8>& image) {
  Decompressor jpeg;
  const auto size = openedSize(jpeg, bytes);
  if (!size) return tl::unexpected(size.error());
  if (*size != ImageSize{image.width, image.height}) return tl::unexpected(wrongSize(*size, image));
  if (jpeg.codec.jpeg_color_space == JCS_CMYK || jpeg.codec.jpeg_color_space == JCS_YCCK) {
    return io::fail(io::Failure::Code::unsupported, "JPEG: its colours are for print (CMYK), convert it to RGB");
  }
  static_assert(sizeof(Rgba8) == 4);
  auto* pixels = reinterpret_cast<unsigned char*>(image.samples.data());
  if (!jpeg.readPixels(pixels, static_cast<std::size_t>(image.width) * sizeof(Rgba8))) return failed(jpeg.trap);
  return {};
}

io::Result<std::vector<std::byte>> encodeJpeg(const Raster<Rgba8>& image, int quality) {
  Compressor jpeg(image.width, image.height);
  const auto* pixels = reinterpret_cast<const unsigned char*>(image.samples.data());
  if (!jpeg.write(pixels, image.width, image.height, quality)) return failed(jpeg.trap, io::Failure::Code::ioError);
  const auto* bytes = reinterpret_cast<const std::byte*>(jpeg.bytes);
  return std::vector<std::byte>(bytes, bytes + jpeg.size);
}

}  // namespace tellurion::raster
