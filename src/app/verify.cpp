#include "pyramid/verify.h"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "app/progress.h"
#include "app/standard_output.h"
#include "app/subcommands.h"

namespace tellurion::app {
namespace {

constexpr int kFailed = 1;

std::string jsonOf(const std::string& path, const pyramid::VerifyReport& report) {
  nlohmann::ordered_json json;
  json["file"] = path;
  json["sound"] = report.sound();
  json["tiles"] = report.tiles;
  json["payload_bytes"] = report.payloadBytes;
  json["fault_count"] = report.faultCount;
  json["faults"] = report.faults;
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::string textOf(const std::string& path, const pyramid::VerifyReport& report) {
  std::string text;
  for (const std::string& fault : report.faults)
    text += fault + "\n";
  if (report.faultCount > report.faults.size())
    text += fmt::format("... and {} more\n", report.faultCount - report.faults.size());
  return text + fmt::format("{}: {} tiles, {} payload bytes, {}\n", path, report.tiles, report.payloadBytes,
                            report.sound() ? "all sound" : fmt::format("{} faults", report.faultCount));
}

void run(const std::string& path, int jobs, bool asJson) {
  const InterruptStop interrupt;
  ProgressLine line("checking " + path);
  const auto sink = [&](std::uint64_t done, std::uint64_t total) { line.show(done, total, "tiles"); };
  const auto report = pyramid::verifyPyramid(path, {.jobs = jobs}, sink, interrupt.token());
  line.clear();
  if (!report) {
    fmt::print(stderr, "tellurion verify: {}\n", io::describe(report.error()));
    throw CLI::RuntimeError(kFailed);
  }
  printAnswer("verify", asJson ? jsonOf(path, *report) : textOf(path, *report));
  if (!report->sound()) throw CLI::RuntimeError(kFailed);
}

}  // namespace

void addVerify(CLI::App& program) {
  auto* command = program.add_subcommand("verify", "Check every tile of a tile database");
  auto path = std::make_shared<std::string>();
  auto jobs = std::make_shared<int>(0);
  auto asJson = std::make_shared<bool>(false);
  command->add_option("X.tdb", *path, "The tile database")->required();
  command->add_option("--jobs", *jobs, "Threads; left out: one for each core")->check(CLI::Range(1, 1024));
  command->add_flag("--json", *asJson, "As JSON");
  command->footer(
      "Reads every page of the file, checks and decodes every payload, and compares each tile's statistics with its "
      "samples,\n"
      "its children and its parent. Prints what is wrong, a line each; the exit status is 1 when anything is,\n"
      "or when Ctrl-C or SIGTERM ends the check before all is read.\n\n"
      "Example:\n"
      "  tellurion verify earth.tdb && cp earth.tdb /mnt/planetarium/");
  command->callback([path, jobs, asJson] { run(*path, *jobs, *asJson); });
}

}  // namespace tellurion::app
