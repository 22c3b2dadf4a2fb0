#pragma once

#include <span>
#include <string>
#include <vector>

#include "scene/globe.h"

// What is written over the picture. To be called between ViewWindow::beginPanels() and endPanels().
namespace tellurion::app {

/// A line on a dark band along the lower edge: `right` at its right end, and of `parts`, most important first, as many
/// as find room beside it.
void drawStatusLine(const std::vector<std::string>& parts, const std::string& right);
struct Figure {
  const char* name;
  std::string value;
};

/// A table in the upper right corner.
void drawStatistics(std::span<const Figure> figures);
/// A short message at the upper edge.
void drawNotice(const std::string& text);
/// The table of controls in the middle.
void drawHelp();

}  // namespace tellurion::app
