#include "app/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

namespace tellurion::app {
namespace {

constexpr double kWidth = 1000.0;
constexpr double kLeft = 76.0;
constexpr double kRight = 150.0;  ///< the legends stand there
constexpr double kHead = 64.0;
constexpr double kPanelHeight = 130.0;
constexpr double kPanelGap = 46.0;
constexpr double kFoot = 30.0;
constexpr double kPlotWidth = kWidth - kLeft - kRight;
constexpr double kLegendLine = 15.0;

constexpr std::array kLineColours{"#1f5fa8", "#d1561c", "#2d8a4e", "#8b3fa0"};
/// From deep to light, so that stacked series show their order.
constexpr std::array<std::array<double, 3>, 5> kStackRamp{
    {{46, 26, 87}, {38, 92, 140}, {32, 146, 140}, {110, 197, 96}, {248, 226, 60}}};

/// Bytes of the character that begins there, 0 when XML has none such there.
std::size_t characterBytes(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) {
    return i < text.size() ? static_cast<std::uint32_t>(static_cast<unsigned char>(text[i])) : 0u;
  };
  const std::uint32_t lead = byte(at);
  if (lead < 0x80) return lead >= 0x20 ? 1 : 0;
  const std::size_t bytes = lead >= 0xF0 ? 4 : (lead >= 0xE0 ? 3 : 2);
  if (lead < 0xC2 || lead > 0xF4) return 0;
  std::uint32_t code = lead & (0x7Fu >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(at + i) & 0xC0u) != 0x80u) return 0;
    code = code << 6 | (byte(at + i) & 0x3Fu);
  }
  constexpr std::array<std::uint32_t, 5> kLeast{0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
  return code < kLeast[bytes] || surrogate || code == 0xFFFE || code == 0xFFFF || code > 0x10FFFF ? 0 : bytes;
}

std::string escaped(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t bytes = characterBytes(text, i);
    if (bytes == 0) {
      out += '?';
    } else if (text[i] == '&') {
      out += "&amp;";
    } else if (text[i] == '<') {
      out += "&lt;";
    } else if (text[i] == '>') {
      out += "&gt;";
    } else {
      out += text.substr(i, bytes);
    }
    i += std::max<std::size_t>(bytes, 1);
  }
  return out;
}

struct Axis {
  double end = 1.0;
  double step = 1.0;
};

/// Round steps (1, 2 or 5 times a power of ten), at most `most` of them, from 0 to at least `largest`.
Axis axisUpTo(double largest, int most) {
  if (!(largest > 0.0)) return {};
  const double power = std::pow(10.0, std::floor(std::log10(largest / most)));
  for (const double factor : {1.0, 2.0, 5.0, 10.0}) {
    const double step = factor * power;
    const double steps = std::ceil(largest / step - 1e-9);
    if (steps <= most) return {.end = steps * step, .step = step};
  }
  return {.end = 10.0 * most * power, .step = 10.0 * power};
}

std::string stackColour(std::size_t i, std::size_t count) {
  const double at = count < 2 ? 0.0 : static_cast<double>(i * (kStackRamp.size() - 1)) / static_cast<double>(count - 1);
  const auto low = std::min(static_cast<std::size_t>(at), kStackRamp.size() - 2);
  const auto channel = [&](std::size_t c) {
    return static_cast<int>(std::lround(std::lerp(kStackRamp[low][c], kStackRamp[low + 1][c], at - double(low))));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", channel(0), channel(1), channel(2));
}

/// One page being written.
class Writer {
 public:
  explicit Writer(const PlotPage& page) : page_(page) {
    const double duration = page.times.empty() ? 0.0 : page.times.back();
    time_ = axisUpTo(duration, 12);
    if (time_.end > 1.02 * duration && duration > 0.0) time_.end = duration;
  }

  std::string write() {
    const auto panels = static_cast<double>(page_.panels.size());
    const double height = kHead + panels * (kPanelHeight + kPanelGap) + kFoot;
    out_ = fmt::format(
        R"(<?xml version="1.0" encoding="UTF-8"?>
<svg xmlns="http://www.w3.org/2000/svg" version="1.1" width="{0}" height="{1}" viewBox="0 0 {0} {1}"
  font-family="DejaVu Sans, Arial, sans-serif" font-size="11">
<rect width="{0}" height="{1}" fill="#ffffff"/>
)",
        kWidth, height);
    text(kLeft, 24, "start", page_.title, R"(font-size="15" font-weight="bold")");
    text(kLeft, 42, "start", page_.subtitle, R"(fill="#555555")");
    double top = kHead + 20.0;
    for (const PlotPanel& panel : page_.panels) {
      drawPanel(panel, top);
      top += kPanelHeight + kPanelGap;
    }
    text(kLeft + kPlotWidth / 2, height - 14, "middle", "seconds of the path", "");
    return out_ + "</svg>\n";
  }

 private:
  void text(double x, double y, const char* anchor, std::string_view words, std::string_view more) {
    out_ += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" {}>{}</text>\n", x, y, anchor, more,
                        escaped(words));
  }
  void line(double x1, double y1, double x2, double y2, const char* colour) {
    out_ += fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\"/>\n", x1, y1, x2,
                        y2, colour);
  }
  double xOf(std::size_t i) const { return kLeft + page_.times[i] / time_.end * kPlotWidth; }

  double largest(const PlotPanel& panel) const {
    std::vector<double> totals(page_.times.size(), 0.0);
    double most = 0.0;
    for (const PlotSeries& series : panel.series) {
      for (std::size_t i = 0; i < totals.size(); ++i) {
        totals[i] = panel.stacked ? totals[i] + series.values[i] : series.values[i];
        most = std::max(most, totals[i]);
      }
    }
    return most;
  }

  void drawPanel(const PlotPanel& panel, double top) {
    const Axis axis = axisUpTo(largest(panel), 5);
    out_ += "<g>\n";
    text(kLeft, top - 8, "start", panel.title, R"(font-weight="bold" font-size="12")");
    for (int i = 0; i * axis.step <= axis.end * 1.0001; ++i) {
      const double y = top + kPanelHeight * (1.0 - i * axis.step / axis.end);
      line(kLeft, y, kLeft + kPlotWidth, y, i == 0 ? "#444444" : "#dddddd");
      text(kLeft - 6, y + 4, "end", fmt::format("{:g}", i * axis.step), "");
    }
    for (int i = 0; i * time_.step <= time_.end * 1.0001; ++i) {
      const double x = kLeft + kPlotWidth * i * time_.step / time_.end;
      line(x, top + kPanelHeight, x, top + kPanelHeight + 4, "#444444");
      text(x, top + kPanelHeight + 16, "middle", fmt::format("{:g}", i * time_.step), "");
    }
    line(kLeft, top, kLeft, top + kPanelHeight, "#444444");
    const double middle = top + kPanelHeight / 2;
    text(18, middle, "middle", panel.unit, fmt::format(R"x(transform="rotate(-90 18 {:.1f})")x", middle));
    const auto yOf = [&](double value) { return top + kPanelHeight * (1.0 - value / axis.end); };
    if (panel.stacked) {
      drawStack(panel, yOf);
    } else {
      for (std::size_t s = 0; s < panel.series.size(); ++s)
        drawLine(panel.series[s], kLineColours[s % kLineColours.size()], yOf);
    }
    if (panel.series.size() > 1) drawLegend(panel, top);
    out_ += "</g>\n";
  }

  /// The last frame of each pixel column, and the very last.
  std::vector<std::size_t> columns() const {
    std::vector<std::size_t> out;
    for (std::size_t i = 0; i < page_.times.size(); ++i) {
      if (i + 1 == page_.times.size() || std::floor(xOf(i)) != std::floor(xOf(i + 1))) out.push_back(i);
    }
    return out;
  }

  template <typename YOf>
  void drawLine(const PlotSeries& series, const char* colour, const YOf& yOf) {
    out_ +=
        fmt::format(R"(<polyline fill="none" stroke="{}" stroke-width="1.2" stroke-linejoin="round" points=")", colour);
    std::size_t first = 0;
    for (const std::size_t last : columns()) {
      const auto begin = series.values.begin();
      const auto [low, high] = std::minmax_element(begin + static_cast<std::ptrdiff_t>(first),
                                                   begin + static_cast<std::ptrdiff_t>(last) + 1);
      const auto [early, late] = std::minmax(low, high);
      out_ += pointAt(early - begin, *early, yOf);
      if (early != late) out_ += pointAt(late - begin, *late, yOf);
      first = last + 1;
    }
    out_ += "\"/>\n";
  }

  template <typename YOf>
  std::string pointAt(std::ptrdiff_t i, double value, const YOf& yOf) const {
    return fmt::format("{:.1f},{:.1f} ", xOf(static_cast<std::size_t>(i)), yOf(value));
  }

  template <typename YOf>
  void drawStack(const PlotPanel& panel, const YOf& yOf) {
    const std::vector<std::size_t> shown = columns();
    std::vector<double> floor(page_.times.size(), 0.0);
    for (std::size_t s = 0; s < panel.series.size(); ++s) {
      out_ += fmt::format(R"(<polygon fill="{}" points=")", stackColour(s, panel.series.size()));
      for (const std::size_t i : shown)
        out_ += pointAt(static_cast<std::ptrdiff_t>(i), floor[i] + panel.series[s].values[i], yOf);
      for (std::size_t k = shown.size(); k-- > 0;)
        out_ += pointAt(static_cast<std::ptrdiff_t>(shown[k]), floor[shown[k]], yOf);
      out_ += "\"/>\n";
      for (const std::size_t i : shown)
        floor[i] += panel.series[s].values[i];
    }
  }

  /// Stacked series stand in the legend as in the picture, the highest first; in two columns where one is too short.
  void drawLegend(const PlotPanel& panel, double top) {
    const std::size_t count = panel.series.size();
    const auto rows = static_cast<std::size_t>(kPanelHeight / kLegendLine);
    const double columnWidth = count > rows ? 66.0 : kRight;
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t s = panel.stacked ? count - 1 - i : i;
      const std::size_t column = i / rows;
      const double x = kLeft + kPlotWidth + 12 + columnWidth * static_cast<double>(column);
      const double y = top + 8 + kLegendLine * static_cast<double>(i % rows);
      const std::string colour = panel.stacked ? stackColour(s, count) : kLineColours[s % kLineColours.size()];
      out_ +=
          fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"10\" height=\"10\" fill=\"{}\"/>\n", x, y - 5, colour);
      text(x + 15, y + 4, "start", panel.series[s].name, "");
    }
  }

  const PlotPage& page_;
  Axis time_;
  std::string out_;
};

}  // namespace

std::string svgOf(const PlotPage& page) {
  return Writer(page).write();
}

}  // namespace tellurion::app
