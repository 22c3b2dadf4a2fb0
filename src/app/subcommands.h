#pragma once

#include <CLI/CLI.hpp>

// Each subcommand of the program: a file beside this one with one function that adds it to the command line. What a
// subcommand does runs in its callback, which ends by throwing CLI::RuntimeError(1) for a failed run; wrong use is 2.
namespace tellurion::app {

void addBuild(CLI::App& program);
void addMerge(CLI::App& program);
void addInfo(CLI::App& program);
void addVerify(CLI::App& program);
void addQuery(CLI::App& program);
void addRender(CLI::App& program);
void addFly(CLI::App& program);
void addBench(CLI::App& program);
void addView(CLI::App& program);
void addSources(CLI::App& program);
void addExport(CLI::App& program);
void addImport(CLI::App& program);

}  // namespace tellurion::app
