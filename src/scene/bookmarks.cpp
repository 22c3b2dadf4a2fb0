#include "scene/bookmarks.h"

#include <fmt/format.h>

#include "scene/scene_toml.h"

namespace tellurion::scene {
namespace {

constexpr std::size_t kMost = 10'000;

std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') out += '\\';
    if (byte < 0x20 || byte == 0x7f) {
      out += fmt::format("\\u{:04x}", byte);
    } else {
      out += c;
    }
  }
  return out + "\"";
}

Bookmark readBookmark(const Entry& table) {
  allow(table, {"name", "body", "camera"});
  const auto text = [&table](std::string_view key) {
    const auto value = textAt(table, key);
    if (!value) complain(table.where, fmt::format("a bookmark needs '{}'", key));
    return *value;
  };
  const auto camera = parseCamera(text("camera"));
  if (!camera) complain(table.where, io::describe(camera.error()));
  return {.name = text("name"), .body = text("body"), .camera = *camera};
}

}  // namespace

io::Result<std::vector<Bookmark>> parseBookmarks(std::string_view text, const std::string& where) {
  const auto root = readToml(text, where, {});
  if (!root) return tl::unexpected(root.error());
  try {
    allow(*root, {"bookmark"});
    const auto tables = tablesAt(*root, "bookmark");
    if (tables.size() > kMost) complain(where, fmt::format("more than {} bookmarks", kMost));
    std::vector<Bookmark> bookmarks;
    for (const Entry* table : tables)
      bookmarks.push_back(readBookmark(*table));
    return bookmarks;
  } catch (const EntryFault& fault) {
    return tl::unexpected(fault.failure);
  }
}

std::string formatBookmarks(std::span<const Bookmark> bookmarks) {
  std::string text;
  for (const Bookmark& bookmark : bookmarks)
    text += fmt::format("[[bookmark]]\nname = {}\nbody = {}\ncamera = {}\n\n", quoted(bookmark.name),
                        quoted(bookmark.body), quoted(formatCamera(bookmark.camera)));
  return text;
}

}  // namespace tellurion::scene
