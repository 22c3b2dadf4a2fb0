#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "raster/xml_document.h"

namespace tellurion::raster {
namespace {

enum class Encoding : std::uint8_t { utf8, utf16Little, utf16Big, latin1, latin9, windows1252 };

// What differs from Latin-1; 0 is not assigned.
constexpr std::array<char16_t, 32> kWindows1252 = {0x20AC, 0,      0x201A, 0x0192, 0x201E, 0x2026, 0x2020, 0x2021,
                                                   0x02C6, 0x2030, 0x0160, 0x2039, 0x0152, 0,      0x017D, 0,
                                                   0,      0x2018, 0x2019, 0x201C, 0x201D, 0x2022, 0x2013, 0x2014,
                                                   0x02DC, 0x2122, 0x0161, 0x203A, 0x0153, 0,      0x017E, 0x0178};
constexpr std::array<std::pair<unsigned char, char16_t>, 8> kLatin9 = {{{0xA4, 0x20AC},
                                                                        {0xA6, 0x0160},
                                                                        {0xA8, 0x0161},
                                                                        {0xB4, 0x017D},
                                                                        {0xB8, 0x017E},
                                                                        {0xBC, 0x0152},
                                                                        {0xBD, 0x0153},
                                                                        {0xBE, 0x0178}}};

void appendUtf8(std::string& text, char32_t c) {
  const auto put = [&text](char32_t byte) { text.push_back(static_cast<char>(byte)); };
  if (c < 0x80) {
    put(c);
  } else if (c < 0x800) {
    put(0xC0 | (c >> 6));
    put(0x80 | (c & 0x3F));
  } else if (c < 0x10000) {
    put(0xE0 | (c >> 12));
    put(0x80 | ((c >> 6) & 0x3F));
    put(0x80 | (c & 0x3F));
  } else {
    put(0xF0 | (c >> 18));
    put(0x80 | ((c >> 12) & 0x3F));
    put(0x80 | ((c >> 6) & 0x3F));
    put(0x80 | (c & 0x3F));
  }
}

char32_t fromEightBits(unsigned char byte, Encoding encoding) {
  if (encoding == Encoding::windows1252 && byte >= 0x80 && byte < 0xA0) {
    const char16_t c = kWindows1252[byte - 0x80];
    return c != 0 ? c : byte;
  }
  if (encoding == Encoding::latin9) {
    const auto* const found = std::find_if(kLatin9.begin(), kLatin9.end(), [=](auto& p) { return p.first == byte; });
    if (found != kLatin9.end()) return found->second;
  }
  return byte;
}

/// The place of the first byte that is no UTF-8; nothing: all is.
std::optional<std::size_t> firstWrongUtf8(std::string_view text) {
  const auto at = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  for (std::size_t i = 0; i < text.size();) {
    const unsigned char lead = at(i);
    const std::size_t more = lead < 0x80   ? 0u
                             : lead < 0xC2 ? 9u
                             : lead < 0xE0 ? 1u
                             : lead < 0xF0 ? 2u
                             : lead < 0xF5 ? 3u
                                           : 9u;
    if (more == 9u || i + more >= text.size()) return i;
    for (std::size_t k = 1; k <= more; ++k)
      if ((at(i + k) & 0xC0) != 0x80) return i;
    i += more + 1;
  }
  return std::nullopt;
}

std::size_t lineAt(std::string_view text, std::size_t place) {
  return 1 +
         static_cast<std::size_t>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(place), '\n'));
}

std::string fromUtf16(std::string_view bytes, bool big) {
  const auto unit = [&](std::size_t i) {
    const auto low = static_cast<unsigned char>(bytes[big ? i + 1 : i]);
    const auto high = static_cast<unsigned char>(bytes[big ? i : i + 1]);
    return static_cast<char32_t>(high << 8 | low);
  };
  std::string text;
  text.reserve(bytes.size() / 2);
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
    char32_t c = unit(i);
    const bool isHigh = c >= 0xD800 && c < 0xDC00;
    if (isHigh && i + 3 < bytes.size() && unit(i + 2) >= 0xDC00 && unit(i + 2) < 0xE000) {
      c = 0x10000 + ((c - 0xD800) << 10) + (unit(i + 2) - 0xDC00);
      i += 2;
    } else if (c >= 0xD800 && c < 0xE000) {
      c = 0xFFFD;  // half of a pair
    }
    appendUtf8(text, c);
  }
  return text;
}

/// Of the XML declaration, in lower case; empty: it has none.
std::string declaredEncoding(std::string_view text) {
  constexpr std::size_t kLongestDeclaration = 200;
  text = text.substr(0, kLongestDeclaration);
  if (!text.starts_with("<?xml")) return {};
  text = text.substr(0, text.find("?>"));
  std::size_t at = text.find("encoding");
  if (at == text.npos) return {};
  at = text.find_first_of("'\"", at);
  if (at == text.npos) return {};
  const std::size_t end = text.find(text[at], at + 1);
  if (end == text.npos) return {};
  std::string name(text.substr(at + 1, end - at - 1));
  for (char& c : name)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return name;
}

std::optional<Encoding> eightBitEncoding(const std::string& name) {
  // Who can read "utf-16" one byte a letter is not reading UTF-16: some servers declare what they do not send.
  for (const char* known : {"", "utf-8", "utf8", "us-ascii", "ascii", "utf-16", "utf-16le", "utf-16be", "ucs-2"})
    if (name == known) return Encoding::utf8;
  for (const char* known : {"iso-8859-1", "iso8859-1", "iso_8859-1", "latin1", "latin-1"})
    if (name == known) return Encoding::latin1;
  for (const char* known : {"iso-8859-15", "iso8859-15", "iso_8859-15", "latin9", "latin-9"})
    if (name == known) return Encoding::latin9;
  for (const char* known : {"windows-1252", "cp1252", "cp-1252"})
    if (name == known) return Encoding::windows1252;
  return std::nullopt;
}

/// Two bytes a letter, told from where the zeros of the first letter stand: "<" is 3C.
std::optional<Encoding> utf16Of(std::string_view bytes) {
  if (bytes.size() < 2) return std::nullopt;
  if (bytes[0] != 0 && bytes[1] == 0) return Encoding::utf16Little;
  if (bytes[0] == 0 && bytes[1] != 0) return Encoding::utf16Big;
  return std::nullopt;
}

std::string_view withoutMark(std::string_view bytes) {
  for (const std::string_view mark : {"\xEF\xBB\xBF", "\xFF\xFE", "\xFE\xFF"})
    if (bytes.starts_with(mark)) return bytes.substr(mark.size());
  return bytes;
}

}  // namespace

io::Result<std::string> xmlTextInUtf8(std::span<const std::byte> bytes, const std::string& where) {
  const std::string_view all = withoutMark({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  if (const auto wide = utf16Of(all)) return fromUtf16(all, *wide == Encoding::utf16Big);

  const std::string name = declaredEncoding(all);
  const auto encoding = eightBitEncoding(name);
  if (!encoding) {
    return io::fail(io::Failure::Code::unsupported,
                    fmt::format("line 1: the encoding '{}' is not one of UTF-8, UTF-16, ISO-8859-1, ISO-8859-15 and "
                                "windows-1252",
                                name),
                    where);
  }
  if (*encoding == Encoding::utf8) {
    if (const auto wrong = firstWrongUtf8(all)) {
      return io::fail(io::Failure::Code::corrupt,
                      fmt::format("line {}: the bytes are not UTF-8; an encoding that is not declared, or damage",
                                  lineAt(all, *wrong)),
                      where);
    }
    return std::string(all);
  }
  std::string text;
  text.reserve(all.size() + all.size() / 8);
  for (const char c : all)
    appendUtf8(text, fromEightBits(static_cast<unsigned char>(c), *encoding));
  return text;
}

}  // namespace tellurion::raster
