#pragma once

#include <string>

// What is written over the picture. To be called between ViewWindow::beginPanels() and endPanels().
namespace tellurion::app {

/// A line on a dark band along the lower edge. `right` stands at the right end, `left` is cut where they would meet.
void drawStatusLine(const std::string& left, const std::string& right);
/// A short message at the upper edge.
void drawNotice(const std::string& text);
/// The table of controls in the middle.
void drawHelp();

}  // namespace tellurion::app
