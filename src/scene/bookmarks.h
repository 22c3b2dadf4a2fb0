#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scene/camera.h"

namespace tellurion::scene {

/// A view that a person wants to find again.
struct Bookmark {
  std::string name;
  std::string body;  ///< "earth", "mars", "moon", or a scene's own
  Camera camera;
};

/// TOML: a table [[bookmark]] each, with `name`, `body` and `camera` as --camera takes it. Fails naming the place in
/// the file. where: for messages.
io::Result<std::vector<Bookmark>> parseBookmarks(std::string_view text, const std::string& where);
std::string formatBookmarks(std::span<const Bookmark> bookmarks);

}  // namespace tellurion::scene
