#pragma once

#include <string>
#include <vector>

namespace tellurion::app {

/// One measured quantity over time, a value for each of PlotPage::times.
struct PlotSeries {
  std::string name;  ///< for the legend
  std::vector<double> values;
};

/// One diagram: lines, or areas stacked on each other, over the page's time.
struct PlotPanel {
  std::string title;
  std::string unit;  ///< of the vertical axis
  std::vector<PlotSeries> series;
  bool stacked = false;  ///< areas, the first series lowest; else a line for each series
};

/// Diagrams below each other over one time axis.
struct PlotPage {
  std::string title;
  std::string subtitle;
  std::vector<double> times;  ///< seconds, increasing
  std::vector<PlotPanel> panels;
};

/// The page as an SVG 1.1 document. Vertical axes begin at 0 and end at a round number; each panel has its title, its
/// unit and, for more than one series, a legend. Where there are more values than pixels, a line shows the smallest and
/// the largest of each pixel column, so that no spike is lost. Text may hold any characters.
std::string svgOf(const PlotPage& page);

}  // namespace tellurion::app
