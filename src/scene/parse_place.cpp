#include "scene/parse_place.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "raster/parse_number.h"

namespace tellurion::scene {
namespace {

constexpr std::size_t kLongest = 200;
constexpr double kFarthest_m = 1e13;
constexpr double kFoot_m = 0.3048;

struct Wrong {
  std::string message;
};

/// Of one number: degrees 0, minutes 1, seconds 2, or nothing said.
constexpr int kUnmarked = -1;
struct Number {
  double value = 0.0;  ///< without its sign
  bool isNegative = false;
  bool isSigned = false;
  bool isWhole = true;
  int mark = kUnmarked;
};

enum class Axis { unknown, latitude, longitude };

/// The numbers of one coordinate, or of the height.
struct Part {
  std::vector<Number> numbers;
  Axis axis = Axis::unknown;
  bool isSouthOrWest = false;
  bool hasHemisphere = false;
  std::optional<double> metres;  ///< of a unit of length: of a height
};

struct Word {
  const char* text;
  enum class Means { mark, hemisphere, axis, height, unit } means;
  double value;  ///< the mark; 'N', 'S', 'E', 'W' as 0..3; the axis 0 or 1; metres of the unit
};

/// Longer ones first where one begins like another.
constexpr std::array kWords{
    Word{"\u00b0", Word::Means::mark, 0},      Word{"\u00ba", Word::Means::mark, 0},
    Word{"\u02da", Word::Means::mark, 0},      Word{"degrees", Word::Means::mark, 0},
    Word{"degree", Word::Means::mark, 0},      Word{"deg", Word::Means::mark, 0},
    Word{"d", Word::Means::mark, 0},           Word{"\u2032", Word::Means::mark, 1},
    Word{"\u2019", Word::Means::mark, 1},      Word{"\u02b9", Word::Means::mark, 1},
    Word{"\u00b4", Word::Means::mark, 1},      Word{"''", Word::Means::mark, 2},
    Word{"'", Word::Means::mark, 1},           Word{"minutes", Word::Means::mark, 1},
    Word{"min", Word::Means::mark, 1},         Word{"\u2033", Word::Means::mark, 2},
    Word{"\u201d", Word::Means::mark, 2},      Word{"\u02ba", Word::Means::mark, 2},
    Word{"\"", Word::Means::mark, 2},          Word{"seconds", Word::Means::mark, 2},
    Word{"sec", Word::Means::mark, 2},         Word{"north", Word::Means::hemisphere, 0},
    Word{"south", Word::Means::hemisphere, 1}, Word{"east", Word::Means::hemisphere, 2},
    Word{"west", Word::Means::hemisphere, 3},  Word{"n", Word::Means::hemisphere, 0},
    Word{"s", Word::Means::hemisphere, 1},     Word{"e", Word::Means::hemisphere, 2},
    Word{"w", Word::Means::hemisphere, 3},     Word{"latitude", Word::Means::axis, 0},
    Word{"lat", Word::Means::axis, 0},         Word{"longitude", Word::Means::axis, 1},
    Word{"long", Word::Means::axis, 1},        Word{"lng", Word::Means::axis, 1},
    Word{"lon", Word::Means::axis, 1},         Word{"altitude", Word::Means::height, 0},
    Word{"alt", Word::Means::height, 0},       Word{"height", Word::Means::height, 0},
    Word{"h", Word::Means::height, 0},         Word{"metres", Word::Means::unit, 1.0},
    Word{"meters", Word::Means::unit, 1.0},    Word{"km", Word::Means::unit, 1000.0},
    Word{"feet", Word::Means::unit, kFoot_m},  Word{"ft", Word::Means::unit, kFoot_m},
    Word{"m", Word::Means::unit, 1.0},
};

bool isLetter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

bool beginsWith(std::string_view text, std::string_view word) {
  return text.size() >= word.size() &&
         std::equal(word.begin(), word.end(), text.begin(), [](char a, char b) { return a == lower(b); });
}

class Reading {
 public:
  explicit Reading(std::string_view text) : rest_(text) {}

  std::vector<Part> parts() {
    while (!rest_.empty())
      step();
    close();
    return std::move(parts_);
  }

 private:
  void step() {
    const char c = rest_.front();
    if (c == ' ' || c == '\t' || c == '\r' || c == '\n') {
      rest_.remove_prefix(1);
    } else if (rest_.starts_with("\u00a0")) {
      rest_.remove_prefix(2);
    } else if (c == ',' || c == ';' || c == '/') {
      rest_.remove_prefix(1);
      close();
    } else if (c == ':' || c == '=') {
      rest_.remove_prefix(1);
      colon();
    } else if ((c >= '0' && c <= '9') || c == '.' || c == '+' || c == '-' || rest_.starts_with("\u2212")) {
      number();
    } else {
      word();
    }
  }

  /// 27:59:17, or lat: 27.
  void colon() {
    if (now_.numbers.empty()) return;
    Number& last = now_.numbers.back();
    if (last.mark == kUnmarked) last.mark = static_cast<int>(now_.numbers.size()) - 1;
  }

  void number() {
    Number number;
    const bool longMinus = rest_.starts_with("\u2212");
    number.isSigned = longMinus || rest_.front() == '-' || rest_.front() == '+';
    number.isNegative = longMinus || rest_.front() == '-';
    if (number.isSigned) rest_.remove_prefix(longMinus ? 3 : 1);
    const std::size_t end = std::min(rest_.find_first_not_of("0123456789."), rest_.size());
    const std::string_view digits = rest_.substr(0, end);
    const auto value = raster::parseNumber<double>(digits);
    if (!value || !((digits.front() >= '0' && digits.front() <= '9') || digits.front() == '.'))
      throw Wrong{fmt::format("'{}' is not a number", rest_.substr(0, std::max<std::size_t>(end, 1)))};
    rest_.remove_prefix(end);
    number.value = *value;
    number.isWhole = digits.find('.') == digits.npos;
    const bool beginsAnother = number.isSigned || isClosed_ || now_.metres ||
                               (now_.numbers.size() >= 3 && now_.numbers.front().mark != kUnmarked);
    if (beginsAnother && !now_.numbers.empty()) close();
    isClosed_ = false;
    now_.numbers.push_back(number);
  }

  void word() {
    for (const Word& word : kWords) {
      if (!beginsWith(rest_, word.text)) continue;
      const std::string_view text(word.text);
      // North before a digit, but not the beginning of Nepal. Seconds may stand close to a hemisphere: 17sN.
      const std::string_view after = rest_.substr(text.size());
      const bool goesOn = isLetter(text.back()) && !after.empty() && isLetter(after.front());
      if (goesOn && !(isMarkLetter(text) && (after.size() == 1 || !isLetter(after[1])))) continue;
      if (!take(word)) continue;
      rest_.remove_prefix(text.size());
      return;
    }
    std::size_t end = 1;
    while (end < rest_.size() && rest_[end] != ' ' && rest_[end] != ',')
      ++end;
    throw Wrong{fmt::format("'{}' was not understood", rest_.substr(0, end))};
  }

  static bool isMarkLetter(std::string_view text) { return text == "d" || text == "m" || text == "s"; }

  bool hasNumber() const { return !now_.numbers.empty() && !isClosed_; }

  /// False: not what this word can mean here.
  bool take(const Word& word) {
    const std::string_view text(word.text);
    switch (word.means) {
      case Word::Means::mark:
        return hasNumber() && mark(static_cast<int>(word.value));
      case Word::Means::hemisphere:
        // 12d34m56s
        if (text == "s" && hasNumber() && now_.numbers.size() == 3 && now_.numbers[1].mark == 1 && usesLetters_ &&
            now_.numbers[2].mark == kUnmarked)
          return mark(2);
        hemisphere(static_cast<int>(word.value));
        return true;
      case Word::Means::axis:
        begin();
        now_.axis = word.value == 0 ? Axis::latitude : Axis::longitude;
        return true;
      case Word::Means::height:
        begin();
        now_.metres = 1.0;
        return true;
      case Word::Means::unit:
        if (!hasNumber()) return false;
        // 12d34m
        if (text == "m" && now_.numbers.size() == 2 && now_.numbers[0].mark == 0) return usesLetters_ = true, mark(1);
        if (now_.numbers.size() > 1) splitHeight();
        now_.metres = word.value;
        isClosed_ = true;
        return true;
    }
    return false;
  }

  /// "27.9 86.9 8848 m": the last of a row of numbers.
  void splitHeight() {
    const Number height = now_.numbers.back();
    now_.numbers.pop_back();
    close();
    now_.numbers.push_back(height);
  }

  bool mark(int mark) {
    Number& last = now_.numbers.back();
    if (last.mark != kUnmarked) throw Wrong{"a number has two marks"};
    if (mark == 0 && now_.numbers.size() > 1) {  // another coordinate has begun without being parted from the first
      const Number first = last;
      now_.numbers.pop_back();
      close();
      now_.numbers.push_back(first);
    }
    now_.numbers.back().mark = mark;
    return true;
  }

  void hemisphere(int which) {
    if (prefixed_ == std::nullopt) prefixed_ = parts_.empty() && now_.numbers.empty();
    if (*prefixed_ || !hasNumber()) begin();
    if (now_.hasHemisphere) throw Wrong{"two hemispheres for one coordinate"};
    now_.hasHemisphere = true;
    now_.isSouthOrWest = which == 1 || which == 3;
    now_.axis = which < 2 ? Axis::latitude : Axis::longitude;
    if (!*prefixed_) isClosed_ = true;
  }

  void begin() {
    if (!now_.numbers.empty()) close();
  }

  void close() {
    if (!now_.numbers.empty()) {
      parts_.push_back(std::move(now_));
      now_ = {};
    } else if (now_.hasHemisphere || now_.axis != Axis::unknown) {
      if (rest_.empty()) throw Wrong{"a number is missing"};
    }
    isClosed_ = false;
  }

  std::string_view rest_;
  std::vector<Part> parts_;
  Part now_;
  bool isClosed_ = false;  ///< the part is whole; what comes next is another's
  std::optional<bool> prefixed_;
  bool usesLetters_ = false;
};

Part partOf(const Part& whole, std::size_t from, std::size_t count) {
  Part part;
  const auto begin = whole.numbers.begin() + static_cast<std::ptrdiff_t>(from);
  part.numbers.assign(begin, begin + static_cast<std::ptrdiff_t>(count));
  return part;
}

/// A row of numbers with nothing between: two, four or six are two coordinates, three are two and a height.
std::vector<Part> parted(std::vector<Part> parts) {
  std::vector<Number> row;
  for (const Part& part : parts) {
    const bool isPlain = !part.hasHemisphere && part.axis == Axis::unknown && !part.metres &&
                         std::ranges::all_of(part.numbers, [](const Number& n) { return n.mark == kUnmarked; });
    if (!isPlain && !part.metres) return parts;
    if (part.metres) continue;
    row.insert(row.end(), part.numbers.begin(), part.numbers.end());
  }
  Part all;
  all.numbers = row;
  std::vector<Part> out;
  if (row.size() == 2 || row.size() == 4 || row.size() == 6) {
    out = {partOf(all, 0, row.size() / 2), partOf(all, row.size() / 2, row.size() / 2)};
  } else if (row.size() == 3 && parts.size() == 1) {
    out = {partOf(all, 0, 1), partOf(all, 1, 1), partOf(all, 2, 1)};
  } else {
    return parts;
  }
  for (const Part& part : parts)
    if (part.metres) out.push_back(part);
  return out;
}

double degreesOf(const Part& part) {
  double degrees = 0.0;
  int last = -1;
  for (std::size_t i = 0; i < part.numbers.size(); ++i) {
    const Number& number = part.numbers[i];
    const int mark = number.mark == kUnmarked ? last + 1 : number.mark;
    if (mark <= last || mark > 2) throw Wrong{"degrees, minutes and seconds do not follow each other"};
    if (i == 0 && mark != 0) throw Wrong{"a coordinate begins with degrees"};
    if (i > 0 && number.isSigned) throw Wrong{"a sign stands before minutes or seconds"};
    if (i + 1 < part.numbers.size() && !number.isWhole)
      throw Wrong{"only the last of degrees, minutes and seconds has decimals"};
    if (mark > 0 && !(number.value < 60.0))
      throw Wrong{fmt::format("{} minutes or seconds are 60 or more", number.value)};
    degrees += number.value / (mark == 0 ? 1.0 : mark == 1 ? 60.0 : 3600.0);
    last = mark;
  }
  if (part.hasHemisphere && part.numbers.front().isSigned) throw Wrong{"a coordinate has a sign and a hemisphere"};
  return part.isSouthOrWest || part.numbers.front().isNegative ? -degrees : degrees;
}

double heightOf_m(const Part& part) {
  if (part.numbers.size() != 1 || part.hasHemisphere || part.axis != Axis::unknown || part.numbers[0].mark != kUnmarked)
    throw Wrong{"after latitude and longitude comes a height, one number"};
  const double height_m = part.numbers[0].value * part.metres.value_or(1.0);
  if (height_m > kFarthest_m) throw Wrong{"the height is beyond 1e13 m"};
  return part.numbers[0].isNegative ? -height_m : height_m;
}

WrittenPlace placeFrom(std::vector<Part> parts) {
  parts = parted(std::move(parts));
  if (parts.size() < 2) throw Wrong{"latitude and longitude are needed"};
  if (parts.size() > 3) throw Wrong{"more than latitude, longitude and height"};
  if (parts[0].metres || parts[1].metres) throw Wrong{"latitude and longitude come before the height"};
  if (parts[0].axis != Axis::unknown && parts[0].axis == parts[1].axis)
    throw Wrong{parts[0].axis == Axis::latitude ? "two latitudes and no longitude" : "two longitudes and no latitude"};
  const bool swapped = parts[0].axis == Axis::longitude || parts[1].axis == Axis::latitude;
  const double lat = degreesOf(parts[swapped ? 1 : 0]);
  const double lon = degreesOf(parts[swapped ? 0 : 1]);
  if (std::abs(lat) > 90.0) throw Wrong{fmt::format("the latitude {} is beyond -90..90 degrees", lat)};
  if (std::abs(lon) > 360.0) throw Wrong{fmt::format("the longitude {} is beyond -360..360 degrees", lon)};
  WrittenPlace place;
  place.camera.position = {.lat = geo::Angle::degrees(lat), .lon = geo::Angle::degrees(lon)};
  place.camera.pitch = geo::Angle::degrees(-90.0);
  place.hasHeight = parts.size() == 3;
  if (place.hasHeight) place.camera.position.height_m = heightOf_m(parts[2]);
  return place;
}

/// What --camera takes: three to six numbers and nothing but commas.
std::optional<io::Result<WrittenPlace>> asCamera(std::string_view text) {
  const auto commas = std::count(text.begin(), text.end(), ',');
  if (commas < 2 || text.find_first_not_of("0123456789+-.eE, \t") != text.npos) return std::nullopt;
  const auto camera = parseCamera(text);
  if (!camera) return tl::unexpected(camera.error());
  if (std::abs(camera->position.lon.degrees()) > 360.0)
    return io::fail(io::Failure::Code::invalidArgument, "the longitude is beyond -360..360 degrees");
  return WrittenPlace{.camera = *camera, .hasHeight = true, .hasAttitude = commas > 2};
}

}  // namespace

io::Result<WrittenPlace> parsePlace(std::string_view text) {
  const auto wrong = [](std::string message) {
    return io::fail(io::Failure::Code::invalidArgument,
                    std::move(message) + "; a place reads like 27.988, 86.925 or 27\u00b059'17\"N 86\u00b055'30\"E");
  };
  text = raster::trimmed(text);
  if (text.size() > kLongest) return wrong("the text is too long for a place");
  if (text.find('\0') != text.npos) return wrong("the text has a zero byte");
  if (auto camera = asCamera(text)) return *camera;
  try {
    return placeFrom(Reading(text).parts());
  } catch (const Wrong& e) {
    return wrong(e.message);
  }
}

}  // namespace tellurion::scene
