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
constexpr const char* kExample = "27.988, 86.925 or 27\u00b059'17\"N 86\u00b055'30\"E";

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
  bool hasLetterS = false;       ///< after its seconds
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
  Reading(std::string_view text, bool hasDecimalCommas) : rest_(text), hasDecimalCommas_(hasDecimalCommas) {}

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
      afterBlank_ = true;
      return;
    }
    if (rest_.starts_with("\u00a0")) {
      rest_.remove_prefix(2);
      afterBlank_ = true;
      return;
    }
    if (c == ',' || c == ';' || c == '/') {
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
    afterBlank_ = false;
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
    const char* const written = hasDecimalCommas_ ? "0123456789," : "0123456789.";
    std::size_t end = std::min(rest_.find_first_not_of(written), rest_.size());
    if (hasDecimalCommas_ && rest_.substr(0, end).ends_with(',')) --end;
    std::string digits(rest_.substr(0, end));
    if (hasDecimalCommas_) std::ranges::replace(digits, ',', '.');
    const auto value = raster::parseNumber<double>(digits);
    if (!value || digits.empty() || !((digits.front() >= '0' && digits.front() <= '9') || digits.front() == '.'))
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
        if (text == "s" && isOfSeconds()) return now_.hasLetterS = true, mark(2);
        hemisphere(static_cast<int>(word.value));
        return true;
      case Word::Means::axis:
        begin();
        setAxis(word.value == 0 ? Axis::latitude : Axis::longitude);
        return true;
      case Word::Means::height:
        begin();
        now_.metres = 1.0;
        return true;
      case Word::Means::unit:
        if (!hasNumber()) return false;
        // 12d34m
        if (text == "m" && now_.numbers.size() == 2 && now_.numbers[0].mark == 0) {
          minutes_ = MinutesLetter{.isUpper = rest_.front() == 'M', .isApart = afterBlank_};
          return mark(1);
        }
        if (now_.numbers.size() > 1) splitHeight();
        now_.metres = word.value;
        isClosed_ = true;
        return true;
    }
    return false;
  }

  /// 12d34m56s, and not 33d51m10 S nor 33d51m10S, where S does not look like the m.
  bool isOfSeconds() const {
    return hasNumber() && now_.numbers.size() == 3 && now_.numbers[1].mark == 1 && minutes_ &&
           now_.numbers[2].mark == kUnmarked && (!afterBlank_ || minutes_->isApart) &&
           (rest_.front() == 's' || minutes_->isUpper);
  }

  void setAxis(Axis axis) {
    if (now_.axis != Axis::unknown && now_.axis != axis)
      throw Wrong{"one coordinate is said to be a latitude and a longitude"};
    now_.axis = axis;
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
    setAxis(which < 2 ? Axis::latitude : Axis::longitude);
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

  /// How the m of minutes was written.
  struct MinutesLetter {
    bool isUpper = false;
    bool isApart = false;  ///< a blank stands before it
  };

  std::string_view rest_;
  bool hasDecimalCommas_;
  bool afterBlank_ = false;
  std::vector<Part> parts_;
  Part now_;
  bool isClosed_ = false;  ///< the part is whole; what comes next is another's
  std::optional<bool> prefixed_;
  std::optional<MinutesLetter> minutes_;
};

Part partOf(const Part& whole, std::size_t from, std::size_t count) {
  Part part;
  const auto begin = whole.numbers.begin() + static_cast<std::ptrdiff_t>(from);
  part.numbers.assign(begin, begin + static_cast<std::ptrdiff_t>(count));
  return part;
}

/// A row of numbers with nothing between: two, four or six are two coordinates, three are two and a height.
std::vector<Part> parted(std::vector<Part> parts) {
  if (parts.empty() || parts.size() > 2 || (parts.size() == 2 && !parts[1].metres)) return parts;
  const Part row = parts.front();
  const bool isPlain = !row.hasHemisphere && row.axis == Axis::unknown && !row.metres &&
                       std::ranges::all_of(row.numbers, [](const Number& n) { return n.mark == kUnmarked; });
  const std::size_t count = row.numbers.size();
  if (!isPlain) return parts;
  std::vector<Part> out;
  if (count == 2 || count == 4 || count == 6) {
    out = {partOf(row, 0, count / 2), partOf(row, count / 2, count / 2)};
  } else if (count == 3 && parts.size() == 1) {
    out = {partOf(row, 0, 1), partOf(row, 1, 1), partOf(row, 2, 1)};
  } else {
    return parts;
  }
  if (parts.size() == 2) out.push_back(parts.back());
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
  for (std::size_t i = 0; i < 2; ++i)
    if (parts[i].hasLetterS && !parts[i].hasHemisphere && parts[1 - i].hasHemisphere)
      throw Wrong{"the S after the seconds may mean south: write 'S' apart, or the seconds with \""};
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

bool isDigit(char c) {
  return c >= '0' && c <= '9';
}

/// Whether commas may be those of decimals, as 48,25; 2,35: some stand between two digits, there is no decimal point,
/// and nowhere does a list go on without blanks (48,25,2,35).
bool mayHaveDecimalCommas(std::string_view text) {
  if (text.find('.') != text.npos) return false;
  bool any = false, inList = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool isOfList = isDigit(c) || c == '+' || c == '-' || c == ',';
    if (!isOfList) inList = false;
    if (c != ',' || i == 0 || i + 1 == text.size() || !isDigit(text[i - 1])) continue;
    const char after = text[i + 1];
    if (!isDigit(after) && after != '+' && after != '-') continue;
    if (inList || !isDigit(after)) return false;
    any = inList = true;
  }
  return any;
}

io::Result<WrittenPlace> readPlace(std::string_view text, bool hasDecimalCommas) {
  if (auto camera = hasDecimalCommas ? std::nullopt : asCamera(text)) return *camera;
  try {
    return placeFrom(Reading(text, hasDecimalCommas).parts());
  } catch (const Wrong& e) {
    return io::fail(io::Failure::Code::invalidArgument, e.message + "; a place reads like " + kExample);
  }
}

}  // namespace

io::Result<WrittenPlace> parsePlace(std::string_view text) {
  const auto wrong = [](std::string message) {
    return io::fail(io::Failure::Code::invalidArgument, std::move(message) + "; a place reads like " + kExample);
  };
  text = raster::trimmed(text);
  if (text.size() > kLongest) return wrong("the text is too long for a place");
  if (text.find('\0') != text.npos) return wrong("the text has a zero byte");
  auto place = readPlace(text, false);
  if (!mayHaveDecimalCommas(text)) return place;
  auto decimal = readPlace(text, true);
  if (place && decimal)
    return wrong("a comma may part two numbers here or begin decimals: write decimals with a point");
  return decimal ? decimal : place;
}

}  // namespace tellurion::scene
