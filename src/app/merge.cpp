#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "app/progress.h"
#include "app/subcommands.h"
#include "pyramid/parted_build.h"

namespace tellurion::app {
namespace {

constexpr int kFailed = 1;

struct Arguments {
  std::string output;
  std::vector<std::string> parts;
  double memory_MiB = 1024.0;
  int jobs = 0;
};

/// A folder stands for all parts in it: there may be more than a command line holds.
std::vector<std::filesystem::path> shardsOf(const Arguments& arguments) {
  std::vector<std::filesystem::path> shards;
  for (const std::string& part : arguments.parts) {
    std::error_code error;
    if (!std::filesystem::is_directory(part, error)) {
      shards.emplace_back(part);
      continue;
    }
    for (const auto& entry : std::filesystem::directory_iterator(part, error)) {
      if (entry.path().extension() == ".tdb") shards.push_back(entry.path());
    }
  }
  return shards;
}

void run(const Arguments& arguments) {
  const auto start = std::chrono::steady_clock::now();
  const InterruptStop interrupt;
  ProgressLine line("joining " + arguments.output);
  const auto sink = [&](const pyramid::BuildProgress& progress) {
    line.show(progress.done, progress.total, "tiles", progress.doneBefore);
  };
  const auto report = pyramid::mergeShards({.output = arguments.output,
                                            .shards = shardsOf(arguments),
                                            .memoryBytes = static_cast<std::uint64_t>(arguments.memory_MiB * (1 << 20)),
                                            .jobs = arguments.jobs},
                                           sink, interrupt.token());
  line.clear();
  if (!report) {
    fmt::print(stderr, "tellurion merge: {}\n", io::describe(report.error()));
    throw CLI::RuntimeError(kFailed);
  }
  for (const std::string& warning : report->warnings)
    fmt::print(stderr, "warning: {}\n", warning);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  fmt::print(stderr, "{}{}: {} tiles, deepest level {}, {:.1f} MiB, {:.1f} s\n", arguments.output,
             report->alreadyComplete ? " is complete already" : "", report->tiles, report->maxLevel,
             static_cast<double>(report->bytes) / (1 << 20), seconds);
}

}  // namespace

void addMerge(CLI::App& program) {
  auto* command = program.add_subcommand("merge", "Join the parts of a build that was cut with build --part");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("OUT.tdb", arguments->output, "The tile database to write")->required();
  command->add_option("PART.tdb", arguments->parts, "All parts of one build, in any order, or the folder they are in")
      ->required();
  command->add_option("--memory", arguments->memory_MiB, "MiB of memory that it may take in all [1024]")
      ->check(CLI::Range(static_cast<double>(pyramid::kLeastMemory >> 20u), 1048576.0));
  command->add_option("--jobs", arguments->jobs, "Threads; left out: one for each core")->check(CLI::Range(1, 1024));
  command->footer(
      "Takes over the tiles of the parts, makes the coarser levels, and ends with the same bytes as one 'build' of the "
      "same inputs.\n"
      "The inputs must be where they were, by the same names: start it in the same folder. Interrupted or killed, it "
      "goes on where\n"
      "it was when it is given again. The parts stay; remove them when OUT.tdb is there.\n\n"
      "Example: a build in three shares, on any machines, joined\n"
      "  tellurion build earth.tdb etopo5_dem_5min.tif --kind elevation --part 1/3   # and 2/3, and 3/3\n"
      "  tellurion merge earth.tdb earth.tdb.parts");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace tellurion::app
