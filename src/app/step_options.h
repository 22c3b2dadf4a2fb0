#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "io/net_address.h"

namespace tellurion::app {

/// Windows and machines in step (docs/several-machines.md).
struct StepArguments {
  std::string lead;    ///< [ADDRESS:]PORT
  std::string follow;  ///< HOST:PORT
  std::string secretFile;
  int patience_ms = 100;
  std::string framesLog;
  std::string frustum;  ///< a file of channels
  std::string channel;

  bool leads() const { return !lead.empty(); }
  bool follows() const { return !follow.empty(); }
};

/// --lead, --follow, --secret-file, --patience, --frames-log, --frustum and --channel, checked as they are read.
void addStepOptions(CLI::App& command, StepArguments& arguments);

/// Ends the subcommand where what the leader says is said of a follower too, or the other way round.
void checkStepOptions(const CLI::App& command, const StepArguments& arguments);

/// Of --secret-file, else of the environment's TELLURION_STEP_SECRET; empty: neither is there. Fails where it cannot be
/// read, is too short or too long.
io::Result<std::string> readStepSecret(const StepArguments& arguments);

}  // namespace tellurion::app
