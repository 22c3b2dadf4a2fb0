#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <string>
#include <string_view>

#include "app/subcommands.h"
#include "raster/near_names.h"

namespace {
constexpr int kSuccess = 0;
constexpr int kFailed = 1;
constexpr int kWrongUse = 2;

/// CLI11 would only say that a subcommand is required.
std::string subcommandProblem(const CLI::App& program, std::string_view word) {
  constexpr std::size_t kFarthest = 2;
  std::string names;
  std::string nearest;
  std::size_t least = kFarthest + 1;
  for (const CLI::App* command : program.get_subcommands({})) {
    const std::string& name = command->get_name();
    if (name == word) return {};
    names += (names.empty() ? "" : ", ") + name;
    if (const std::size_t d = tellurion::raster::editDistance(word, name); d < least && d < name.size()) {
      least = d;
      nearest = name;
    }
  }
  const std::string hint = nearest.empty() ? "" : fmt::format("; did you mean '{}'?", nearest);
  return fmt::format("there is no subcommand '{}'{}\nThere are {}: tellurion SUBCOMMAND --help", word, hint, names);
}

}  // namespace

int main(int argc, char** argv) {
#ifdef SIGXFSZ
  std::signal(SIGXFSZ, SIG_IGN);  // a file larger than a limit allows is a failure of write(), not our end
#endif
  CLI::App program{"Tellurion draws whole planets, from orbit down to a centimetre on the ground."};
  program.require_subcommand(1);
  program.set_version_flag("--version", TELLURION_VERSION);
  program.get_formatter()->column_width(34);
  program.footer("Start with 'tellurion build --help' and 'tellurion render --help'.");
  tellurion::app::addBuild(program);
  tellurion::app::addMerge(program);
  tellurion::app::addInfo(program);
  tellurion::app::addVerify(program);
  tellurion::app::addExport(program);
  tellurion::app::addImport(program);
  tellurion::app::addQuery(program);
  tellurion::app::addRender(program);
  tellurion::app::addFly(program);
  tellurion::app::addBench(program);
  tellurion::app::addView(program);
  tellurion::app::addSources(program);
  try {
    const std::string_view first = argc > 1 ? argv[1] : "";
    if (const std::string problem = subcommandProblem(program, first);
        first.find_first_not_of('-') == 0 && !problem.empty()) {
      fmt::print(stderr, "tellurion: {}\n", problem);
      return kWrongUse;
    }
    program.parse(argc, argv);
    return kSuccess;
  } catch (const CLI::RuntimeError& e) {
    return e.get_exit_code();
  } catch (const CLI::ParseError& e) {
    const int code = program.exit(e);
    return code == kSuccess ? kSuccess : kWrongUse;
  } catch (const std::exception& e) {  // memory that is not there, a library that throws: the last line before an abort
    fmt::print(stderr, "tellurion: {}\n", e.what());
    return kFailed;
  }
}
