#include "bench/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <vector>

#include "bench/figures.h"
#include "bench/svg_plot.h"
#include "bench/update_report.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

constexpr const char* kStyle = R"(
:root { color-scheme: light dark; }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem;
       color: #1b1f24; background: #ffffff; }
table { border-collapse: collapse; margin: 1rem 0; }
th, td { padding: .3rem .8rem; text-align: left; border-bottom: 1px solid #8884;
         vertical-align: top; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
.goal { color: #117733; } .floor { color: #946c00; } .missed { color: #b3261e; }
.note { color: #57606a; font-size: .9em; }
svg { width: 100%; height: auto; margin: .5rem 0 1.5rem; }
@media (prefers-color-scheme: dark) {
  body { color: #e6e9ec; background: #15181c; }
  .goal { color: #62d08a; } .floor { color: #e4b94a; } .missed { color: #ff8a80; }
  .note { color: #9aa4ae; }
}
)";

// A colour of its own for everybody who takes part; Embree's are warm.
std::string color_of(const std::string& name) {
  static const std::map<std::string, const char*> kColors = {{"sinew auto", "#3b82f6"},
                                                             {"sinew full", "#0f9d8a"},
                                                             {"sinew hybrid", "#7c6cf0"},
                                                             {"sinew lazy", "#22a447"},
                                                             {"embree refit", "#e4572e"},
                                                             {"embree low rebuild", "#d18f00"},
                                                             {"sinew 1", "#3b82f6"},
                                                             {"sinew coherent", "#22a447"},
                                                             {"embree 1", "#e4572e"},
                                                             {"embree 8", "#d18f00"},
                                                             {"embree 16", "#b5651d"},
                                                             {"embree 8 coherent", "#c94f7c"},
                                                             {"embree 16 coherent", "#a03a8c"},
                                                             {"embree stream", "#8a8f98"},
                                                             {"embree stream coherent", "#5c6470"}};
  const auto found = kColors.find(name);
  return found != kColors.end() ? found->second : "#888888";
}

std::string limit_text(const json& figure, const char* name) {
  if (!figure.contains(name)) return "";
  return fmt::format("{} {:g}", figure["better"] == "more" ? "&ge;" : "&le;",
                     figure[name].get<double>());
}

std::string figures_table(const json& figures) {
  if (figures.empty()) return "";
  constexpr const char* kClasses[] = {"goal", "floor", "missed", ""};
  std::string out =
      "<h2>Figures</h2>\n<table>\n<tr><th>figure</th><th class=\"n\">value</th>"
      "<th class=\"n\">goal</th><th class=\"n\">floor</th><th></th><th></th></tr>\n";
  for (const json& f : figures) {
    const Verdict reached = verdict(f);
    out += fmt::format(
        "<tr><td><code>{}</code></td><td class=\"n\">{:.2f}</td><td class=\"n\">{}</td>"
        "<td class=\"n\">{}</td><td class=\"{}\">{}</td><td class=\"note\">{}</td></tr>\n",
        escape_markup(f["name"]), f["value"].get<double>(), limit_text(f, "goal"),
        limit_text(f, "floor"), kClasses[static_cast<size_t>(reached)], name_of(reached),
        escape_markup(f["note"]));
  }
  return out + "</table>\n";
}

// Where our lines cross Embree's.
std::vector<PlotMark> marks_of(const json& rows, std::string_view table, const std::string& scene,
                               const std::vector<SweepLine>& lines) {
  std::vector<PlotMark> marks;
  for (const json& row : rows) {
    if (row["table"] != "crossing" || row["sweep"] != table || row["scene"] != scene) continue;
    const std::string first = row["a"], second = row["b"];
    if (!first.starts_with("sinew") || !second.starts_with("embree")) continue;
    const auto a = std::ranges::find(lines, first, &SweepLine::method);
    if (a == lines.end()) continue;
    for (const double x : row["x"]) marks.push_back({x, interpolate(*a, x), row["says"]});
  }
  return marks;
}

std::string crossings_list(const json& rows, std::string_view table, const std::string& scene) {
  std::string out;
  for (const json& row : rows) {
    if (row["table"] != "crossing" || row["sweep"] != table || row["scene"] != scene) continue;
    out += "<li>" + escape_markup(row["says"]) + "</li>\n";
  }
  return out.empty() ? "" : "<ul class=\"note\">\n" + out + "</ul>\n";
}

std::string sweep_plots(const json& rows, const char* table, const char* x_label, bool percent) {
  std::string out;
  for (const std::string& scene : sweep_scenes(rows, table)) {
    const std::vector<SweepLine> lines = sweep_lines(rows, table, scene);
    LinePlot plot{.title = scene,
                  .x_label = x_label,
                  .y_label = "ms a frame, pose in, hits out",
                  .x_percent = percent,
                  .lines = {},
                  .marks = {},
                  .mark_name = "cross Embree's"};
    for (const SweepLine& line : lines) {
      plot.lines.push_back(
          {line.method, color_of(line.method), line.method.starts_with("embree"), line.x, line.ms});
    }
    plot.marks = marks_of(rows, table, scene, lines);
    out += svg(plot) + crossings_list(rows, table, scene);
  }
  return out;
}

void add_name(std::vector<std::string>& list, const std::string& name) {
  if (std::ranges::find(list, name) == list.end()) list.push_back(name);
}

// Rays a second of one scene, tree and test, by kind of ray.
std::string trace_plot(const std::vector<const json*>& rows, const std::string& title) {
  BarPlot plot{.title = title, .y_label = "millions of rays a second", .groups = {}, .series = {}};
  std::vector<std::string> calls;
  for (const json* row : rows) {
    add_name(plot.groups, (*row)["kind"]);
    add_name(calls, (*row)["call"]);
  }
  for (const std::string& call : calls) {
    BarSeries& series = plot.series.emplace_back(BarSeries{call, color_of(call), {}});
    series.values.assign(plot.groups.size(), -1.0);
    for (const json* row : rows) {
      if ((*row)["call"] != call) continue;
      const auto group = std::ranges::find(plot.groups, (*row)["kind"].get<std::string>());
      series.values[static_cast<size_t>(group - plot.groups.begin())] = (*row)["mrays_per_s"];
    }
  }
  return svg(plot);
}

std::string trace_plots(const json& rows) {
  std::vector<std::string> titles;
  std::map<std::string, std::vector<const json*>> by_title;
  for (const json& row : rows) {
    if (row["table"] != "trace") continue;
    const std::string title =
        fmt::format("{} at {:.2f} s, {} tree, {} test", row["scene"].get<std::string>(),
                    row["time_s"].get<double>(), row["tree"].get<std::string>(),
                    row["test"].get<std::string>());
    add_name(titles, title);
    by_title[title].push_back(&row);
  }
  std::string out;
  for (const std::string& title : titles) out += trace_plot(by_title[title], title);
  return out.empty() ? "" : "<h2>Rays a second</h2>\n" + out;
}

std::string section(const char* title, const char* words, const std::string& body) {
  if (body.empty()) return "";
  return fmt::format("<h2>{}</h2>\n<p>{}</p>\n{}", title, words, body);
}

std::string machine_line(const json& report) {
  const json& machine = report["machine"];
  return fmt::format(
      "<p class=\"note\">sinew {}, {} kernels, {} threads on {}; against {}. All take part in one "
      "process and in turn; times are medians.</p>\n",
      escape_markup(report["version"]), escape_markup(machine["kernels"]),
      machine["threads"].get<int>(), escape_markup(machine["processor"]),
      escape_markup(report["opponents"][0]));
}

}  // namespace

std::string html_page(const json& report, const std::string& body) {
  const std::string title = "sinew bench " + report["bench"].get<std::string>();
  std::string out = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width\">\n<title>{0}</title>\n"
      "<style>{1}</style>\n</head>\n<body>\n<h1>{0}</h1>\n",
      escape_markup(title), kStyle);
  out += machine_line(report) + figures_table(report["figures"]) + body;
  if (report.contains("skipped")) {
    for (const json& sentence : report["skipped"]) {
      out += "<p class=\"note\">Skipped: " + escape_markup(sentence) + "</p>\n";
    }
  }
  return out + "</body>\n</html>\n";
}

std::string report_page(const json& report) {
  const json& rows = report["rows"];
  std::string body =
      section("What rays reach",
              "Time of a frame, primary and shadow rays, against the share of the deforming "
              "objects' treelets that rays reach. Circles: ours cross Embree's.",
              sweep_plots(rows, "visible_fraction", "treelets reached", true));
  body += section(
      "How many rays",
      "Time of a frame against its number of picks: rays that have nothing to do with each other.",
      sweep_plots(rows, "ray_count", "rays a frame", false));
  return html_page(report, body + trace_plots(rows));
}

}  // namespace sinew::bench
