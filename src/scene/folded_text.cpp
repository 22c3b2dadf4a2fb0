#include "scene/folded_text.h"

#include <array>
#include <cstdint>

namespace tellurion::scene {
namespace {

/// What stands for each letter of U+00C0..U+024F and of U+1E00..U+1EFF, a word each, by Unicode's own decomposition;
/// -: itself. Only letters that have none there (sharp s, o with a stroke and the like) are by hand.
constexpr std::uint32_t kLatinFrom = 0xc0;
constexpr std::string_view kLatin =
    "a a a a a a ae c e e e e i i i i d n o o o o o - o u u u u y th ss a a a a a a ae c e e e e i i i i "
    "d n o o o o o - o u u u u y th y a a a a a a c c c c c c c c d d d d e e e e e e e e e e g g g g g "
    "g g g h h h h i i i i i i i i i i ij ij j j k k k l l l l l l l l l l n n n n n n n n n o o o o o o "
    "oe oe r r r r r r s s s s s s s s t t t t t t u u u u u u u u u u u u w w y y y z z z z z z s - - - "
    "- - - - - - - - - - - - e - - f - - - - - - - - - - - - - o o - - - - - - - - - - - - - u u - - - - "
    "- - - - - - - - - - - - - - - dz dz dz lj lj lj nj nj nj a a i i o o u u u u u u u u u u - a a a a "
    "- - - - g g k k o o o o - - j dz dz dz g g - - n n a a - - - - a a a a e e e e i i i i o o o o r r "
    "r r u u u u s s t t - - h h - - - - - - a a e e o o o o o o o o y y - - - - - - - - - - - - - - - - "
    "- - - - - - - - - - - - ";
constexpr std::uint32_t kLatinMoreFrom = 0x1e00;
constexpr std::string_view kLatinMore =
    "a a b b b b b b c c d d d d d d d d d d e e e e e e e e e e f f g g h h h h h h h h h h i i i i k k "
    "k k k k l l l l l l l l m m m m m m n n n n n n n n o o o o o o o o p p p p r r r r r r r r s s s s "
    "s s s s s s t t t t t t t t u u u u u u u u u u v v v v w w w w w w w w w w x x x x y y z z z z z z "
    "h t w y - s - - ss - a a a a a a a a a a a a a a a a a a a a a a a a e e e e e e e e e e e e e e e "
    "e i i i i o o o o o o o o o o o o o o o o o o o o o o o o u u u u u u u u u u u u u u y y y y y y y "
    "y - - - - - - ";

template <std::size_t N>
constexpr std::array<std::string_view, N> wordsOf(std::string_view text) {
  std::array<std::string_view, N> words;
  for (std::string_view& word : words) {
    const std::size_t end = text.find(' ');
    word = text.substr(0, end);
    text.remove_prefix(end + 1);
  }
  return words;
}

constexpr auto kLatinWords = wordsOf<400>(kLatin);
constexpr auto kLatinMoreWords = wordsOf<256>(kLatinMore);

struct Letter {
  std::uint32_t code = 0;
  std::size_t bytes = 1;  ///< 0 code: no UTF-8
};

Letter firstOf(std::string_view text) {
  const auto byte = [&text](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  if (byte(0) < 0x80) return {byte(0), 1};
  const std::size_t bytes = byte(0) >= 0xf0 ? 4 : byte(0) >= 0xe0 ? 3 : byte(0) >= 0xc2 ? 2 : 0;
  if (bytes == 0 || byte(0) > 0xf4 || text.size() < bytes) return {};
  std::uint32_t code = byte(0) & (0xffU >> (bytes + 1));
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return {};
    code = code << 6 | (byte(i) & 0x3f);
  }
  return {code, bytes};
}

template <std::size_t N>
std::string_view wordFor(std::uint32_t code, std::uint32_t from, const std::array<std::string_view, N>& words) {
  if (code < from || code >= from + N || words[code - from] == "-") return {};
  return words[code - from];
}

}  // namespace

std::string foldedText(std::string_view text) {
  std::string folded;
  while (!text.empty()) {
    const Letter letter = firstOf(text);
    const std::string_view itself = text.substr(0, letter.bytes);
    text.remove_prefix(letter.bytes);
    const std::uint32_t c = letter.code;
    const bool isMark =
        (c >= 0x300 && c < 0x370) || c == '\'' || c == 0x2019 || c == 0x2bc || c == 0x2bb || c == 0x2018;
    if (c == 0 || isMark) continue;
    std::string_view word = wordFor(c, kLatinFrom, kLatinWords);
    if (word.empty()) word = wordFor(c, kLatinMoreFrom, kLatinMoreWords);
    if (!word.empty()) {
      folded += word;
    } else if (c >= 'A' && c <= 'Z') {
      folded += static_cast<char>(c - 'A' + 'a');
    } else if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c >= 0xc0) {
      folded += itself;
    } else if (!folded.empty() && folded.back() != ' ') {
      folded += ' ';
    }
  }
  while (folded.ends_with(' '))
    folded.pop_back();
  return folded;
}

}  // namespace tellurion::scene
