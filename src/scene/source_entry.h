#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "scene/entry.h"
#include "scene/scene_file.h"

namespace tellurion::scene {

// Where the data of a layer come from, as the table of a scene file says. All throw EntryFault. folder: what relative
// paths are relative to.

struct LayerSourceEntry {
  std::string source;  ///< as ImageryLayer has all of these
  SourceKind from = SourceKind::file;
  raster::ServiceLayer service;
  std::vector<std::string> alsoFrom;
};

/// These, and the keys that a layer of a service has besides source and type.
Keys withServiceKeys(Keys keys);

/// Of a layer of this kind ("elevation", "imagery"). Fails where files are not there. mayBeSeveral: a list of files
/// is taken.
LayerSourceEntry readSource(const Entry& layer, std::string_view kind, bool mayBeSeveral,
                            const std::filesystem::path& folder);

/// A path as it can be opened, or a URL.
std::string sourceAt(const Entry& entry, const std::filesystem::path& folder);
/// As the layer's type says (empty: as the source looks).
SourceKind kindOfSource(const Entry& layer, const std::string& type, const std::string& source);
void expectFile(const Entry& entry, const std::string& source, std::string_view kind,
                const std::filesystem::path& folder);

}  // namespace tellurion::scene
