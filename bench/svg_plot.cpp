#include "bench/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew::bench {
namespace {

constexpr double kWidth = 825.0, kHeight = 400.0;  // of the whole plot
constexpr double kLeft = 66.0, kRight = 205.0, kTop = 34.0, kBottom = 52.0;
constexpr double kPlotWidth = kWidth - kLeft - kRight, kPlotHeight = kHeight - kTop - kBottom;

// Maps values to [0, 1].
struct Axis {
  bool log = false;
  double low = 0.0, high = 1.0;

  double at(double value) const {
    if (log) return std::log(value / low) / std::log(high / low);
    return (value - low) / (high - low);
  }
  bool holds(double value) const { return value >= low * 0.9999 && value <= high * 1.0001; }
};

double pixel_x(const Axis& axis, double x) {
  return kLeft + kPlotWidth * axis.at(x);
}
double pixel_y(const Axis& axis, double y) {
  return kTop + kPlotHeight * (1.0 - axis.at(y));
}

Axis make_axis(bool log, double low, double high) {
  if (!log) return {false, std::min(0.0, low), high > 0.0 ? 1.05 * high : 1.0};
  if (!(high > low)) return {true, low / 2.0, low * 2.0};
  const double room = std::pow(high / low, 0.04);
  return {true, low / room, high * room};
}

// 1, 2 and 5 times powers of ten; only powers of ten where the axis is long, and all multiples
// where it is short.
std::vector<double> log_ticks(const Axis& axis) {
  std::vector<double> ticks;
  const double decades = std::log10(axis.high / axis.low);
  for (double ten = std::pow(10.0, std::floor(std::log10(axis.low))); ten <= axis.high;
       ten *= 10.0) {
    for (int step = 1; step < 10; ++step) {
      if (step > 1 && (decades > 3.5 || (decades > 0.9 && step != 2 && step != 5))) continue;
      if (axis.holds(step * ten)) ticks.push_back(step * ten);
    }
  }
  return ticks;
}

std::vector<double> linear_ticks(const Axis& axis) {
  const double rough = (axis.high - axis.low) / 6.0;
  const double ten = std::pow(10.0, std::floor(std::log10(rough)));
  const double step = rough > 5.0 * ten   ? 10.0 * ten
                      : rough > 2.0 * ten ? 5.0 * ten
                      : rough > ten       ? 2.0 * ten
                                          : ten;
  std::vector<double> ticks;
  for (double tick = std::ceil(axis.low / step) * step; tick <= axis.high; tick += step) {
    ticks.push_back(tick);
  }
  return ticks;
}

std::string tick_text(double value, bool percent) {
  if (percent) return fmt::format("{:g}%", 100.0 * value);
  if (value >= 1e6) return fmt::format("{:g}M", value * 1e-6);
  if (value >= 1e3) return fmt::format("{:g}k", value * 1e-3);
  return fmt::format("{:g}", value);
}

std::string text(double x, double y, const char* anchor, const std::string& what,
                 const char* more = "") {
  return fmt::format(
      "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" fill=\"currentColor\"{}>{}</text>\n", x,
      y, anchor, more, escape_markup(what));
}

std::string open_svg(const std::string& title) {
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" "
             "font-family=\"sans-serif\" font-size=\"12\" role=\"img\">\n<title>{}</title>\n",
             kWidth, kHeight, escape_markup(title)) +
         text(kLeft, 18, "start", title, " font-weight=\"bold\" font-size=\"14\"");
}

std::string line(double x0, double y0, double x1, double y1, double opacity) {
  return fmt::format(
      "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"currentColor\" "
      "stroke-opacity=\"{}\"/>\n",
      x0, y0, x1, y1, opacity);
}

std::string y_axis(const Axis& axis, const std::string& label) {
  std::string out;
  for (const double tick : axis.log ? log_ticks(axis) : linear_ticks(axis)) {
    const double y = pixel_y(axis, tick);
    out += line(kLeft, y, kLeft + kPlotWidth, y, 0.15);
    out += text(kLeft - 6, y + 4, "end", tick_text(tick, false));
  }
  const double middle = kTop + kPlotHeight / 2;
  const std::string turn = fmt::format(" transform=\"rotate(-90 16 {:.1f})\"", middle);
  return out + text(16, middle, "middle", label, turn.c_str());
}

std::string x_axis(const Axis& axis, const std::string& label, bool percent) {
  std::string out;
  for (const double tick : axis.log ? log_ticks(axis) : linear_ticks(axis)) {
    const double x = pixel_x(axis, tick);
    out += line(x, kTop, x, kTop + kPlotHeight, 0.15);
    out += text(x, kTop + kPlotHeight + 17, "middle", tick_text(tick, percent));
  }
  return out + text(kLeft + kPlotWidth / 2, kHeight - 12, "middle", label);
}

std::string frame() {
  return fmt::format(
      "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"currentColor\" "
      "stroke-opacity=\"0.5\"/>\n",
      kLeft, kTop, kPlotWidth, kPlotHeight);
}

const char* dashes(const PlotLine& line) {
  return line.dashed ? " stroke-dasharray=\"6 4\"" : "";
}

std::string draw_line(const PlotLine& line, const Axis& x, const Axis& y) {
  std::string points, dots;
  for (size_t i = 0; i < line.x.size(); ++i) {
    const double px = pixel_x(x, line.x[i]), py = pixel_y(y, line.y[i]);
    points += fmt::format("{:.1f},{:.1f} ", px, py);
    dots += fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\" fill=\"{}\"><title>{}: {:.4g}, {:.4g}"
        "</title></circle>\n",
        px, py, line.color, escape_markup(line.name), line.x[i], line.y[i]);
  }
  return fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"{}/>\n",
                     points, line.color, dashes(line)) +
         dots;
}

std::string draw_marks(const LinePlot& plot, const Axis& x, const Axis& y) {
  std::string out;
  for (const PlotMark& mark : plot.marks) {
    if (!x.holds(mark.x) || !y.holds(mark.y)) continue;
    out += fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"7\" fill=\"none\" stroke=\"currentColor\" "
        "stroke-width=\"1.5\"><title>{}</title></circle>\n",
        pixel_x(x, mark.x), pixel_y(y, mark.y), escape_markup(mark.note));
  }
  return out;
}

std::string legend(const LinePlot& plot) {
  std::string out;
  double y = kTop + 12;
  const double x = kLeft + kPlotWidth + 14;
  for (const PlotLine& line : plot.lines) {
    out += fmt::format(
        "<line x1=\"{0:.1f}\" y1=\"{1:.1f}\" x2=\"{2:.1f}\" y2=\"{1:.1f}\" stroke=\"{3}\" "
        "stroke-width=\"2.5\"{4}/>\n",
        x, y - 4, x + 22, line.color, dashes(line));
    out += text(x + 28, y, "start", line.name);
    y += 19;
  }
  if (plot.marks.empty()) return out;
  out += fmt::format(
      "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"6\" fill=\"none\" stroke=\"currentColor\" "
      "stroke-width=\"1.5\"/>\n",
      x + 11, y - 4);
  return out + text(x + 28, y, "start", plot.mark_name);
}

}  // namespace

std::string escape_markup(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string svg(const LinePlot& plot) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double x_low = kInfinity, x_high = -kInfinity, y_low = kInfinity, y_high = -kInfinity;
  for (const PlotLine& line : plot.lines) {
    for (const double x : line.x) x_low = std::min(x_low, x), x_high = std::max(x_high, x);
    for (const double y : line.y) y_low = std::min(y_low, y), y_high = std::max(y_high, y);
  }
  if (!(x_low <= x_high)) return "";
  const Axis x = make_axis(plot.log_x, x_low, x_high), y = make_axis(plot.log_y, y_low, y_high);
  std::string out = open_svg(plot.title);
  out += x_axis(x, plot.x_label, plot.x_percent) + y_axis(y, plot.y_label) + frame();
  for (const PlotLine& line : plot.lines) out += draw_line(line, x, y);
  return out + draw_marks(plot, x, y) + legend(plot) + "</svg>\n";
}

std::string svg(const BarPlot& plot) {
  double most = 0.0;
  for (const BarSeries& series : plot.series) {
    for (const double value : series.values) most = std::max(most, value);
  }
  const Axis y = make_axis(false, 0.0, most);
  std::string out = open_svg(plot.title) + y_axis(y, plot.y_label) + frame();
  const double group = kPlotWidth / double(std::max<size_t>(plot.groups.size(), 1));
  const double bar = 0.86 * group / double(std::max<size_t>(plot.series.size(), 1));
  for (size_t g = 0; g < plot.groups.size(); ++g) {
    const double left = kLeft + (double(g) + 0.07) * group;
    for (size_t s = 0; s < plot.series.size(); ++s) {
      const BarSeries& series = plot.series[s];
      if (series.values[g] < 0.0) continue;
      const double top = pixel_y(y, series.values[g]);
      out += fmt::format(
          "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\">"
          "<title>{}, {}: {:.3g}</title></rect>\n",
          left + double(s) * bar, top, 0.92 * bar, kTop + kPlotHeight - top, series.color,
          escape_markup(plot.groups[g]), escape_markup(series.name), series.values[g]);
    }
    out += text(left + 0.43 * group, kTop + kPlotHeight + 17, "middle", plot.groups[g]);
  }
  double row = kTop + 12;
  for (const BarSeries& series : plot.series) {
    const double x = kLeft + kPlotWidth + 14;
    out += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"14\" height=\"12\" fill=\"{}\"/>\n",
                       x, row - 10, series.color);
    out += text(x + 20, row, "start", series.name);
    row += 19;
  }
  return out + "</svg>\n";
}

}  // namespace sinew::bench
