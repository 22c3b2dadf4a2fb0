#pragma once

#include <string_view>

namespace tellurion::app {

/// Writes to standard output, at once. False: not all of it could be (a full disk, a reader that is gone; from here on
/// that is no signal that ends the program).
bool wroteAnswer(std::string_view text);

/// What to say then.
inline constexpr const char* kCannotAnswer =
    "the answers cannot be written to standard output; is the disk full, or the reader gone?";

/// A subcommand's whole answer; where it cannot be written that is told, and the subcommand ends with status 1.
void printAnswer(const char* command, std::string_view text);

}  // namespace tellurion::app
