#pragma once

#include <filesystem>

#include "scene/entry.h"
#include "scene/sky.h"

namespace tellurion::scene {

/// What the table [sky] of a scene means (docs/scene-file.md), catalogues read. folder: what relative paths are
/// relative to. Throws EntryFault on unknown keys, wrong types, values out of range and catalogues that cannot be read.
SkySettings readSky(const Entry& table, const std::filesystem::path& folder);

}  // namespace tellurion::scene
