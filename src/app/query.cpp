#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <string_view>
#include <vector>

#include "app/query_answers.h"
#include "app/standard_output.h"
#include "app/subcommands.h"
#include "pyramid/pyramid_reader.h"

namespace tellurion::app {
namespace {

constexpr int kFailed = 1;
constexpr std::size_t kBufferSize = 1 << 16;
/// A longer line is no place; the rest of it is skipped.
constexpr std::size_t kLongestLine = 4096;
/// Lines that are answered together: a tile is read once for all places of them.
constexpr std::size_t kBatch = 1 << 17;

struct Arguments {
  std::string path;
  std::vector<std::string> places;
  std::string input;
  std::optional<int> level;
  bool isNearest = false;
  bool normals = false;
  bool asJson = false;
  bool asCsv = false;
  std::uint64_t cache_MiB = pyramid::kQueryCacheBytes >> 20u;
};

/// Answers lines of places, one line each, on standard output. `Query` is HeightQuery or ColourQuery.
template <class Query, class Question, class Answer, class Printer>
class Session {
 public:
  Session(Query query, Question question, Printer printer, const geo::GeoRect& bounds, bool isCsv)
      : query_(std::move(query)), question_(question), printer_(printer), bounds_(bounds), reader_(isCsv) {
    printer_.header(out_);
  }

  /// False when any line could not be answered, or answers could not be written.
  bool run(std::FILE* input, const std::string& name) {
    std::string pending;
    std::string chunk(kBufferSize, '\0');
    while (const std::size_t got = canWrite_ ? std::fread(chunk.data(), 1, chunk.size(), input) : 0) {
      pending.append(chunk, 0, got);
      pending.erase(0, takeWholeLines(pending));
      // One character more than allowed is enough to know that the line is too long.
      if (pending.size() > kLongestLine) pending.resize(kLongestLine + 1);
    }
    if (std::ferror(input) != 0) complainOfStream(fmt::format("{} cannot be read to its end", name));
    if (!pending.empty()) take(pending);
    return end();
  }
  bool run(const std::vector<std::string>& places) {
    for (const std::string& place : places)
      take(place);
    return end();
  }

 private:
  struct Line {
    std::uint64_t number = 0;
    LatLon place;
    std::string complaint;
  };

  bool end() {
    answerLines();
    flush(0);
    if (outside_ > 0) {
      fmt::print(stderr,
                 "tellurion query: {} of {} places lie outside of the data ({:.6g} to {:.6g} N, {:.6g} to {:.6g} E)\n",
                 outside_, asked_, bounds_.south.degrees(), bounds_.north.degrees(), bounds_.west.degrees(),
                 (bounds_.west + bounds_.width).degrees());
    }
    return isSound_;
  }

  std::size_t takeWholeLines(std::string_view text) {
    std::size_t start = 0;
    for (std::size_t end = text.find('\n'); end != std::string_view::npos; end = text.find('\n', start)) {
      take(text.substr(start, end - start));
      start = end + 1;
    }
    return start;
  }

  void take(std::string_view text) {
    ++lineNumber_;
    Line line{.number = lineNumber_};
    if (text.size() > kLongestLine) {
      line.complaint = fmt::format("is longer than {} characters", kLongestLine);
    } else {
      PlaceLine read = reader_.read(text);
      if (!read.place && read.complaint.empty()) return;
      line.place = read.place.value_or(LatLon{});
      line.complaint = std::move(read.complaint);
    }
    lines_.push_back(std::move(line));
    if (lines_.size() == kBatch) answerLines();
  }

  void answerLines() {
    std::vector<geo::Direction> places;
    for (const Line& line : lines_)
      if (line.complaint.empty()) places.push_back(geo::directionFromDegrees(line.place.lat, line.place.lon));
    std::vector<std::optional<Answer>> answers(places.size());
    // One by one where the batch fails, so that each line is told what is wrong with it.
    const bool isBatch = query_.at(places, answers, question_).has_value();
    std::size_t i = 0;
    for (const Line& line : lines_) {
      if (!line.complaint.empty()) {
        complain(line, line.complaint);
        continue;
      }
      if (isBatch) {
        print(line, answers[i]);
      } else if (const auto answer = query_.at(places[i], question_)) {
        print(line, *answer);
      } else {
        complain(line, io::describe(answer.error()));
      }
      ++i;
    }
    lines_.clear();
  }

  void print(const Line& line, const std::optional<Answer>& answer) {
    ++asked_;
    if (!answer && !bounds_.contains(geo::Angle::degrees(line.place.lat), geo::Angle::degrees(line.place.lon)))
      ++outside_;
    printer_.answer(out_, line.place, answer);
    flush(kBufferSize);
  }

  void complain(const Line& line, const std::string& what) {
    flush(0);
    fmt::print(stderr, "tellurion query: line {}: {}\n", line.number, what);
    printer_.error(out_);
    isSound_ = false;
  }

  void flush(std::size_t keepBelow) {
    if (out_.size() < keepBelow || !canWrite_) return;
    const bool isWritten = wroteAnswer(out_);
    out_.clear();
    if (isWritten) return;
    canWrite_ = false;
    complainOfStream(kCannotAnswer);
  }

  void complainOfStream(const std::string& what) {
    fmt::print(stderr, "tellurion query: {}\n", what);
    isSound_ = false;
  }

  Query query_;
  Question question_;
  Printer printer_;
  geo::GeoRect bounds_;
  PlaceReader reader_;
  std::vector<Line> lines_;
  std::string out_;
  std::uint64_t lineNumber_ = 0;
  std::uint64_t asked_ = 0;
  std::uint64_t outside_ = 0;
  bool isSound_ = true;
  bool canWrite_ = true;
};

[[noreturn]] void fail(const std::string& what) {
  fmt::print(stderr, "tellurion query: {}\n", what);
  throw CLI::RuntimeError(kFailed);
}

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

template <class AnySession>
void runSession(AnySession session, const Arguments& arguments) {
  bool isSound = false;
  if (!arguments.places.empty()) {
    isSound = session.run(arguments.places);
  } else if (arguments.input.empty() || arguments.input == "-") {
    isSound = session.run(stdin, "standard input");
  } else {
    const std::unique_ptr<std::FILE, FileCloser> file(std::fopen(arguments.input.c_str(), "rb"));
    if (file == nullptr) fail(fmt::format("{}: cannot be opened for reading", arguments.input));
    isSound = session.run(file.get(), arguments.input);
  }
  if (!isSound) throw CLI::RuntimeError(kFailed);
}

void run(const Arguments& arguments) {
  const auto reader = pyramid::PyramidReader::open(arguments.path);
  if (!reader) fail(io::describe(reader.error()));
  const raster::TileSourceInfo& info = (*reader)->info();
  if (arguments.level && *arguments.level > info.maxLevel) {
    fmt::print(stderr, "tellurion query: {} has no level {}: its finest, {} or above, answers\n", arguments.path,
               *arguments.level, info.maxLevel);
  }
  const auto format = arguments.asJson ? AnswerFormat::json : arguments.asCsv ? AnswerFormat::csv : AnswerFormat::text;
  const auto sampling = arguments.isNearest ? pyramid::Sampling::nearest : pyramid::Sampling::bilinear;
  const std::uint64_t cacheBytes = arguments.cache_MiB << 20u;
  if (info.kind == raster::Kind::imagery) {
    if (arguments.normals)
      fail(fmt::format("{}: holds imagery, which has no normals; leave --normals out", arguments.path));
    auto query = pyramid::ColourQuery::create(*reader, cacheBytes);
    if (!query) fail(io::describe(query.error()));
    using ColourSession = Session<pyramid::ColourQuery, pyramid::ColourQuestion, pyramid::ColourAnswer, ColourPrinter>;
    return runSession(ColourSession(std::move(*query), {.level = arguments.level, .sampling = sampling},
                                    {.format = format}, info.bounds, arguments.asCsv),
                      arguments);
  }
  auto query = pyramid::HeightQuery::create(*reader, cacheBytes);
  if (!query) fail(io::describe(query.error()));
  using HeightSession = Session<pyramid::HeightQuery, pyramid::HeightQuestion, pyramid::HeightAnswer, HeightPrinter>;
  runSession(HeightSession(std::move(*query),
                           {.level = arguments.level, .sampling = sampling, .withNormals = arguments.normals},
                           {.format = format, .withNormals = arguments.normals}, info.bounds, arguments.asCsv),
             arguments);
}

}  // namespace

void addQuery(CLI::App& program) {
  auto* command = program.add_subcommand("query", "Print the height or the colour of places");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("X.tdb", arguments->path, "A tile database")->required();
  auto* at = command->add_option("--at", arguments->places, "A place, LAT,LON in degrees; may be given again")
                 ->allow_extra_args(false);
  command->add_option("--input", arguments->input, "Read places from this file; left out: from standard input")
      ->excludes(at);
  command->add_option("--level", arguments->level, "No deeper than this level; left out: the finest that is there")
      ->check(CLI::Range(0, tiling::kMaxLevel));
  command->add_flag("--nearest", arguments->isNearest, "The sample or pixel that is nearest, nothing in between");
  command->add_flag("--normals", arguments->normals, "Also the surface's unit normal: east, north, up");
  auto* json = command->add_flag("--json", arguments->asJson, "A JSON object a line");
  command->add_flag("--csv", arguments->asCsv, "CSV in (a line that names columns lat and lon first, or not) and out")
      ->excludes(json);
  command->add_option("--cache-mib", arguments->cache_MiB, "Memory for tiles that are kept, MiB (64)")
      ->check(CLI::Range(1, 1 << 20));
  command->footer(
      "Reads 'LAT LON' or 'LAT,LON' lines (degrees) and prints a line for each: of elevation the height in metres, of\n"
      "imagery red, green, blue and coverage (0 to 255), 'nan' where there is no data. JSON and CSV also tell the "
      "tile's\n"
      "level, its spacing in metres, the bound of the error against the finest data (error_m) and whether finer data\n"
      "was kept out by --level (finer). Blank lines are skipped. A line that is not a place prints 'error', is named "
      "on\n"
      "standard error, and makes the exit status 1. Many places in one run are much faster than one a run.\n\n"
      "Examples: Mount Everest, and the ground's slope there; places of a table; the colour of a place\n"
      "  echo '27.9881 86.9250' | tellurion query earth.tdb --normals\n"
      "  tellurion query earth.tdb --csv --input places.csv > heights.csv\n"
      "  tellurion query earth_imagery.tdb --at 48.2,16.4 --json");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace tellurion::app
