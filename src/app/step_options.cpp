#include "app/step_options.h"

#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "app/studio.h"
#include "io/step_wire.h"

namespace tellurion::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kVariable = "TELLURION_STEP_SECRET";
constexpr int kMostPatience_ms = 60000;

std::string addressProblem(const std::string& text) {
  const auto address = io::parseNetAddress(text);
  return address ? "" : address.error().message;
}

io::Result<std::string> fromFile(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = fs::is_regular_file(path, error) ? fs::file_size(path, error) : 0;
  if (error) return io::fail(io::Failure::Code::notFound, "the secret cannot be read: " + error.message(), path);
  if (size > io::kLongestSecret + 2) return std::string(io::kLongestSecret + 1, ' ');
  std::ifstream file(path, std::ios::binary);
  std::string secret(std::istreambuf_iterator<char>(file), {});
  if (!file) return io::fail(io::Failure::Code::ioError, "the secret cannot be read", path);
  while (!secret.empty() && (secret.back() == '\n' || secret.back() == '\r'))
    secret.pop_back();
  const auto others = fs::perms::group_read | fs::perms::others_read;
  if ((fs::status(path, error).permissions() & others) != fs::perms::none)
    fmt::print(stderr, "tellurion view: warning: {}: other users can read the secret: chmod 600 {}\n", path, path);
  return secret;
}

}  // namespace

void addStepOptions(CLI::App& command, StepArguments& arguments) {
  constexpr const char* kGroup = "In step with other windows and machines (docs/several-machines.md)";
  const CLI::Validator address(addressProblem, "");
  auto* lead = command.add_option("--lead", arguments.lead,
                                  "[ADDRESS:]PORT: others may follow this window; without an ADDRESS only on this "
                                  "machine, with one that others can reach only with a secret; port 0: any");
  auto* follow = command.add_option("--follow", arguments.follow,
                                    "HOST:PORT: shows what the window there shows, in the same frame; keeps its "
                                    "picture and looks on where that one is gone");
  lead->check(address)->type_name("[ADDRESS:]PORT")->group(kGroup);
  follow->check(address)->type_name("HOST:PORT")->group(kGroup)->excludes(lead);
  command
      .add_option("--secret-file", arguments.secretFile,
                  fmt::format("File with what leader and followers share, {} to {} bytes; else the environment's {}",
                              io::kShortestSecret, io::kLongestSecret, kVariable))
      ->group(kGroup);
  command
      .add_option("--patience", arguments.patience_ms,
                  "Milliseconds that the leader waits in a frame for followers in step; who takes longer runs behind "
                  "until it keeps up again")
      ->check(CLI::Range(0, kMostPatience_ms))
      ->capture_default_str()
      ->needs(lead)
      ->group(kGroup);
  command.add_option("--frames-log", arguments.framesLog, "CSV: what was shown in each frame, and when")->group(kGroup);
  auto* frustum = command.add_option("--frustum", arguments.frustum,
                                     "TOML of [[channel]]s (docs/projections.md): shows a part of what is around the "
                                     "leader's eye; all of the same --size");
  frustum->needs(follow)->group(kGroup);
  command.add_option("--channel", arguments.channel, "Which channel of --frustum to show")
      ->needs(frustum)
      ->group(kGroup);
}

void checkStepOptions(const CLI::App& command, const StepArguments& arguments) {
  for (const char* option : {"--secret-file", "--frames-log", "--frustum"}) {
    if (command.count(option) > 0 && command.get_option(option)->as<std::string>().empty())
      wrongUse("view", fmt::format("{}: '' names no file", option));
  }
  if (!arguments.follows()) {
    if (!arguments.leads() && (command.count("--secret-file") > 0 || command.count("--frames-log") > 0))
      wrongUse("view", "--secret-file and --frames-log are for windows in step: give --lead or --follow too");
    return;
  }
  if (command.count("--resolution") > 0)
    wrongUse("view", "--resolution: a window that follows draws the pixels that it has; leave it out with --follow");
  constexpr std::array kLeaders{
      "--camera",  "--path",     "--places", "--fov",      "--tolerance",    "--vertices-per-pixel",
      "--quality", "--frame-ms", "--time",   "--no-morph", "--exaggeration", "--background"};
  for (const char* option : kLeaders) {
    if (command.count(option) > 0)
      wrongUse("view", fmt::format("{} is the leader's to say: leave it out with --follow, and give it to the window "
                                   "that leads",
                                   option));
  }
}

io::Result<std::string> readStepSecret(const StepArguments& arguments) {
  const char* variable = std::getenv(kVariable);
  const bool isFile = !arguments.secretFile.empty();
  if (!isFile && variable == nullptr) return std::string();
  auto secret = isFile ? fromFile(arguments.secretFile) : io::Result<std::string>(variable);
  if (!secret) return secret;
  if (secret->size() < io::kShortestSecret || secret->size() > io::kLongestSecret)
    return io::fail(io::Failure::Code::invalidArgument,
                    fmt::format("a secret has {} to {} bytes; this makes one: openssl rand -hex 32",
                                io::kShortestSecret, io::kLongestSecret),
                    isFile ? arguments.secretFile : kVariable);
  return secret;
}

}  // namespace tellurion::app
