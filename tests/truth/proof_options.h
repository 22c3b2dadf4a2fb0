#pragma once

#include <string>
#include <vector>

// The command line of a proof, and the main() that all of them share: --NAME=VALUE beside GoogleTest's own options.
// What a proof does not know ends it with status 2: a slip of the pen must not cost an hour.
namespace tellurion::truth {

/// The names that the program takes. Each proof defines its own.
extern const std::vector<std::string> kOptionNames;

/// What was given, or `otherwise`.
std::string option(const std::string& name, const std::string& otherwise);
/// Likewise a number; ends the program with status 2 where the text is none.
double option(const std::string& name, double otherwise);
int option(const std::string& name, int otherwise);
/// Likewise numbers with commas between them.
std::vector<double> option(const std::string& name, const std::vector<double>& otherwise);

}  // namespace tellurion::truth
