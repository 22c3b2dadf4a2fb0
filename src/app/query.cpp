#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string_view>

#include "app/standard_output.h"
#include "app/subcommands.h"
#include "pyramid/height_query.h"
#include "pyramid/pyramid_reader.h"
#include "raster/parse_number.h"

namespace tellurion::app {
namespace {

constexpr int kFailed = 1;
constexpr std::size_t kBufferSize = 1 << 16;
/// A longer line is no place; the rest of it is skipped.
constexpr std::size_t kLongestLine = 4096;

struct Arguments {
  std::string path;
  std::optional<int> level;
  bool normals = false;
  bool asJson = false;
};

struct LatLon {
  double lat = 0.0;
  double lon = 0.0;
};

bool isBlank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

/// A number that a blank, a comma or the end follows; these stay.
std::optional<double> takeNumber(std::string_view& text) {
  text = raster::trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{}) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  if (!text.empty() && !isBlank(text.front()) && text.front() != ',') return std::nullopt;
  return value;
}

/// Exactly two numbers, blanks or one comma between them: a latitude within 90 degrees and a longitude within 720.
std::optional<LatLon> parseLine(std::string_view line) {
  const auto lat = takeNumber(line);
  line = raster::trimmed(line);
  if (line.starts_with(',')) line.remove_prefix(1);
  const auto lon = lat ? takeNumber(line) : std::nullopt;
  if (!lon || !raster::trimmed(line).empty()) return std::nullopt;
  if (!(std::abs(*lat) <= 90.0) || !(std::abs(*lon) <= 720.0)) return std::nullopt;
  return LatLon{*lat, *lon};
}

/// Answers lines of standard input, one line each, on standard output.
class Session {
 public:
  Session(pyramid::HeightQuery query, const Arguments& arguments) : query_(std::move(query)), arguments_(arguments) {}

  /// False when any line could not be answered, or answers could not be written.
  bool run() {
    std::string pending;
    std::string chunk(kBufferSize, '\0');
    while (const std::size_t got = canWrite_ ? std::fread(chunk.data(), 1, chunk.size(), stdin) : 0) {
      pending.append(chunk, 0, got);
      pending.erase(0, answerWholeLines(pending));
      // One character more than allowed is enough to know that the line is too long.
      if (pending.size() > kLongestLine) pending.resize(kLongestLine + 1);
      flush(kBufferSize);
    }
    if (std::ferror(stdin) != 0) complainOfStream("standard input cannot be read to its end");
    if (!pending.empty()) answer(pending);
    flush(0);
    return isSound_;
  }

 private:
  std::size_t answerWholeLines(std::string_view text) {
    std::size_t start = 0;
    for (std::size_t end = text.find('\n'); end != std::string_view::npos; end = text.find('\n', start)) {
      answer(text.substr(start, end - start));
      start = end + 1;
    }
    return start;
  }

  void answer(std::string_view line) {
    ++lineNumber_;
    if (line.size() > kLongestLine) return complain(fmt::format("is longer than {} characters", kLongestLine));
    if (raster::trimmed(line).empty()) return;
    const auto place = parseLine(line);
    if (!place)
      return complain(
          fmt::format("'{}' is not 'LAT LON' or 'LAT,LON' in degrees", raster::trimmed(line).substr(0, 60)));
    const auto answer = query_.at(geo::directionFromDegrees(place->lat, place->lon), arguments_.level);
    if (!answer) return complain(io::describe(answer.error()));
    arguments_.asJson ? printJson(*place, *answer) : printText(*answer);
  }

  void complain(const std::string& what) {
    flush(0);
    fmt::print(stderr, "tellurion query: line {}: {}\n", lineNumber_, what);
    fmt::format_to(std::back_inserter(out_), "{}\n", arguments_.asJson ? R"({"error":true})" : "error");
    isSound_ = false;
  }

  void printText(const std::optional<pyramid::HeightAnswer>& answer) {
    auto out = std::back_inserter(out_);
    if (!answer) {
      fmt::format_to(out, "{}\n", arguments_.normals ? "nan nan nan nan" : "nan");
    } else if (!arguments_.normals) {
      fmt::format_to(out, "{:.4f}\n", answer->height_m);
    } else {
      const geo::Vec3& n = answer->normal_enu;
      fmt::format_to(out, "{:.4f} {:.7f} {:.7f} {:.7f}\n", answer->height_m, n.x, n.y, n.z);
    }
  }

  void printJson(const LatLon& place, const std::optional<pyramid::HeightAnswer>& answer) {
    auto out = std::back_inserter(out_);
    fmt::format_to(out, R"({{"lat":{},"lon":{},)", place.lat, place.lon);
    if (!answer) {
      fmt::format_to(out, "\"height_m\":null}}\n");
      return;
    }
    fmt::format_to(out, R"("height_m":{:.4f},"level":{})", answer->height_m, answer->level);
    const geo::Vec3& n = answer->normal_enu;
    if (arguments_.normals) fmt::format_to(out, R"(,"normal":[{:.7f},{:.7f},{:.7f}])", n.x, n.y, n.z);
    fmt::format_to(out, "}}\n");
  }

  void flush(std::size_t keepBelow) {
    if (out_.size() < keepBelow || !canWrite_) return;
    const bool isWritten = wroteAnswer(out_);
    out_.clear();
    if (isWritten) return;
    canWrite_ = false;
    complainOfStream(kCannotAnswer);
  }

  void complainOfStream(const char* what) {
    fmt::print(stderr, "tellurion query: {}\n", what);
    isSound_ = false;
  }

  pyramid::HeightQuery query_;
  const Arguments& arguments_;
  std::string out_;
  std::uint64_t lineNumber_ = 0;
  bool isSound_ = true;
  bool canWrite_ = true;
};

io::Result<pyramid::HeightQuery> openQuery(const std::string& path) {
  auto reader = pyramid::PyramidReader::open(path);
  if (!reader) return tl::unexpected(reader.error());
  return pyramid::HeightQuery::create(std::move(*reader));
}

void run(const Arguments& arguments) {
  auto query = openQuery(arguments.path);
  if (!query) {
    fmt::print(stderr, "tellurion query: {}\n", io::describe(query.error()));
    throw CLI::RuntimeError(kFailed);
  }
  if (!Session(std::move(*query), arguments).run()) throw CLI::RuntimeError(kFailed);
}

}  // namespace

void addQuery(CLI::App& program) {
  auto* command = program.add_subcommand("query", "Print the height of places");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("X.tdb", arguments->path, "A tile database of elevation")->required();
  command->add_option("--level", arguments->level, "No deeper than this level; left out: the finest that is there")
      ->check(CLI::Range(0, tiling::kMaxLevel));
  command->add_flag("--normals", arguments->normals, "Also the surface's unit normal: east, north, up");
  command->add_flag("--json", arguments->asJson, "A JSON object a line");
  command->footer(
      "Reads 'LAT LON' or 'LAT,LON' lines (degrees) on standard input and prints the height in metres of each on a "
      "line, 'nan' "
      "where there\n"
      "is no data. Blank lines are skipped. A line that is not a place prints 'error', is named on standard error, and "
      "makes\n"
      "the exit status 1.\n\n"
      "Example: Mount Everest, and the ground's slope there\n"
      "  echo '27.9881 86.9250' | tellurion query earth.tdb --normals");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace tellurion::app
