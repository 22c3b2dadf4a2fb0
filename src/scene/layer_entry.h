#pragma once

#include <string>
#include <string_view>

#include "scene/scene_file.h"

namespace tellurion::scene {

/// What a source can be told to be from its text, where the scene does not say: a URL, a template with {x} or a
/// tilemapresource.xml is a service, a folder a catalogue, all else a file. Looks at the disk.
SourceKind sourceKindOf(const std::string& source);

bool isServiceUrl(std::string_view text);
/// From the command line: "URL" or "URL#LAYER".
raster::ServiceLayer serviceFromUrl(std::string_view text);

}  // namespace tellurion::scene
