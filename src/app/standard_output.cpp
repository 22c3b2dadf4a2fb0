#include "app/standard_output.h"

#include <csignal>
#include <cstdio>

#include "app/studio.h"

namespace tellurion::app {

bool wroteAnswer(std::string_view text) {
  std::signal(SIGPIPE, SIG_IGN);
  return std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
}

void printAnswer(const char* command, std::string_view text) {
  if (!wroteAnswer(text)) failRun(command, kCannotAnswer);
}

}  // namespace tellurion::app
