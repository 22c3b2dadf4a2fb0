#include <fmt/format.h>

#include <cstdio>
#include <exception>

#include "app/subcommands.h"

namespace {
constexpr int kSuccess = 0;
constexpr int kFailed = 1;
constexpr int kWrongUse = 2;
}  // namespace

int main(int argc, char** argv) {
  CLI::App program{"Tellurion draws whole planets, from orbit down to a centimetre on the ground."};
  program.require_subcommand(1);
  program.set_version_flag("--version", TELLURION_VERSION);
  program.get_formatter()->column_width(34);
  program.footer("Start with 'tellurion build --help' and 'tellurion render --help'.");
  tellurion::app::addBuild(program);
  tellurion::app::addInfo(program);
  tellurion::app::addVerify(program);
  tellurion::app::addQuery(program);
  tellurion::app::addRender(program);
  tellurion::app::addFly(program);
  tellurion::app::addBench(program);
  tellurion::app::addView(program);
  try {
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
