// Plots as SVG text that stands by itself: lines over linear or logarithmic axes, and bars. Text
// takes the colour of the page (currentColor), so they can be read on light and on dark.
#pragma once

#include <string>
#include <vector>

namespace sinew::bench {

struct PlotLine {
  std::string name;
  std::string color;  // "#0072b2"
  bool dashed = false;
  std::vector<double> x, y;  // x rising
};

// A point that stands out, with a note (shown by hovering).
struct PlotMark {
  double x = 0.0, y = 0.0;
  std::string note;
};

struct LinePlot {
  std::string title;
  std::string x_label, y_label;  // with units
  bool log_x = true, log_y = true;
  bool x_percent = false;  // x is a share: 0.3 is written 30%
  std::vector<PlotLine> lines;
  std::vector<PlotMark> marks;
  std::string mark_name;  // in the legend
};

// Empty text if there is no point to show.
std::string svg(const LinePlot& plot);

struct BarSeries {
  std::string name;
  std::string color;
  std::vector<double> values;  // one a group; negative: absent
};

struct BarPlot {
  std::string title;
  std::string y_label;
  std::vector<std::string> groups;
  std::vector<BarSeries> series;
};

std::string svg(const BarPlot& plot);

// Text with what HTML and XML take for markup written out.
std::string escape_markup(const std::string& text);

}  // namespace sinew::bench
