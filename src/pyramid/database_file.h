#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "pyramid/database.h"

namespace tellurion::pyramid {

/// Whether there is a regular file to open as a tile database; the failure says what is there instead.
io::Result<void> checkDatabaseFile(const std::filesystem::path& path);

/// Whether a tile database can be written under that name: its folder is there, and it is no folder itself.
io::Result<void> checkOutputName(const std::filesystem::path& path);

/// By the first bytes of the file; unfinished ones are tile databases too.
bool isTileDatabaseFile(const std::filesystem::path& path);

/// The command that goes on with an unfinished build at OUT.tdb.part, as far as the file knows it: OUT.tdb, the inputs,
/// kind, tiling and body. Names are as they were given, relative to the folder where the build was begun.
std::string commandToGoOn(const TileDatabase& part);

/// The options that commandToGoOn cannot name, for the file does not hold them: they have to be given as they were.
std::string_view optionsToRepeat(const DatabaseMeta& meta);

/// What to say of a tile database that is not complete.
io::Failure unfinished(const TileDatabase& database);

}  // namespace tellurion::pyramid
