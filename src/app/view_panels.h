#pragma once

#include <string>
#include <vector>

// What is written over the picture. To be called between ViewWindow::beginPanels() and endPanels().
namespace tellurion::app {

/// A line on a dark band along the lower edge: `right` at its right end, and of `parts`, most important first, as many
/// as find room beside it.
void drawStatusLine(const std::vector<std::string>& parts, const std::string& right);
/// A short message at the upper edge.
void drawNotice(const std::string& text);
/// The table of controls in the middle.
void drawHelp();

}  // namespace tellurion::app
