#pragma once

#include <filesystem>
#include <string_view>

#include "scene/entry.h"
#include "scene/scene_file.h"

namespace tellurion::scene {

// Tables of layers in scene files. All throw EntryFault. folder: what relative paths are relative to.

/// One of [[elevation]].
ElevationLayer readElevation(const Entry& layer, const std::filesystem::path& folder);
/// One of [[imagery]]. scene: what of it stands above the layers' tables, and its elevation.
ImageryLayer readImagery(const Entry& layer, const Scene& scene, const std::filesystem::path& folder);

}  // namespace tellurion::scene
