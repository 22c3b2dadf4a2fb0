#include "scene/viewer_memory.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "scene/scene_toml.h"

namespace tellurion::scene {
namespace {

constexpr int kLeast = 100;
constexpr int kMost = 65536;

const std::vector<Entry>& listOf(const Entry& entry, const char* name) {
  if (entry.shape != Entry::Shape::list) complain(entry.where, fmt::format("'{}' must be a list", name));
  return entry.parts;
}

ViewerMemory::Size sizeFrom(const Entry& entry) {
  const std::vector<Entry>& sides = listOf(entry, "window");
  if (sides.size() != 2) complain(entry.where, "'window' must be [width, height]");
  return {.width = asWhole(sides[0], kLeast, kMost), .height = asWhole(sides[1], kLeast, kMost)};
}

}  // namespace

io::Result<ViewerMemory> parseViewerMemory(std::string_view text, const std::string& where) {
  const auto root = readToml(text, where, {});
  if (!root) return tl::unexpected(root.error());
  try {
    allow(*root, {"window", "panels", "hint"});
    ViewerMemory memory;
    if (const Entry* window = find(*root, "window")) memory.window = sizeFrom(*window);
    if (const Entry* panels = find(*root, "panels")) {
      for (const Entry& panel : listOf(*panels, "panels")) {
        const std::string name = asText(panel);
        if (name != "layers" && name != "settings" && name != "statistics")
          complain(panel.where, fmt::format("there is no panel '{}'", name));
        memory.layers = memory.layers || name == "layers";
        memory.settings = memory.settings || name == "settings";
        memory.statistics = memory.statistics || name == "statistics";
      }
    }
    memory.hasHint = booleanAt(*root, "hint", false);
    return memory;
  } catch (const EntryFault& fault) {
    return tl::unexpected(fault.failure);
  }
}

std::string formatViewerMemory(const ViewerMemory& memory) {
  std::vector<std::string> panels;
  if (memory.layers) panels.emplace_back("\"layers\"");
  if (memory.settings) panels.emplace_back("\"settings\"");
  if (memory.statistics) panels.emplace_back("\"statistics\"");
  std::string text;
  if (memory.window) text = fmt::format("window = [{}, {}]\n", memory.window->width, memory.window->height);
  return text + fmt::format("panels = [{}]\nhint = {}\n", fmt::join(panels, ", "), memory.hasHint);
}

}  // namespace tellurion::scene
