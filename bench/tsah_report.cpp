#include "bench/tsah_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <vector>

#include "bench/report.h"
#include "bench/svg_plot.h"
#include "bench/tables.h"
#include "bench/tsah_methods.h"
#include "bench/tsah_poses.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

// The scenes that have rows of a table, in the order in which they were measured.
std::vector<std::string> scenes_of(const json& rows, std::string_view table) {
  std::vector<std::string> out;
  for (const json& row : rows) {
    if (row["table"] != table) continue;
    const std::string scene = row["scene"];
    if (std::ranges::find(out, scene) == out.end()) out.push_back(scene);
  }
  return out;
}

template <class Use>
void each_row(const json& rows, std::string_view table, const std::string& scene, const Use& use) {
  for (const json& row : rows) {
    if (row["table"] == table && row["scene"] == scene) use(row);
  }
}

std::string scene_head(const json& rows, std::string_view table, const std::string& scene) {
  for (const json& row : rows) {
    if (row["table"] != table || row["scene"] != scene) continue;
    return fmt::format("{}: {} triangles, {}", scene, row["triangles"].get<uint64_t>(),
                       row["motion"].get<std::string>());
  }
  return scene;
}

std::string paper_text(const json& row) {
  if (!row.contains("paper")) return fmt::format("{:24}", "");
  const json& paper = row["paper"];
  return fmt::format("{:8.1f} {:7.0f} {:7.0f}", paper["build_s"].get<double>(),
                     paper["average"].get<double>(), paper["maximum"].get<double>());
}

std::string paper_head(const json& rows, const std::string& scene) {
  for (const json& row : rows) {
    if (row["table"] != "tsah_cost" || row["scene"] != scene || !row.contains("paper")) continue;
    return fmt::format("  s, average, maximum in T's {}{}",
                       row["paper"]["scene"].get<std::string>(),
                       row["paper"]["same_input"].get<bool>() ? "" : " (not the same input)");
  }
  return "";
}

// What T-SAH makes of SAH0's cost, beside what it made of it in the paper.
std::string ratio_text(const json& rows, const std::string& scene) {
  const json *first = nullptr, *tsah = nullptr;
  each_row(rows, "tsah_cost", scene, [&](const json& row) {
    if (row["method"] == kSahFirst) first = &row;
    if (row["method"] == kTsah) tsah = &row;
  });
  if (first == nullptr || tsah == nullptr || !first->contains("paper")) return "";
  const auto ratio = [](const json& a, const json& b) {
    return a["average"].get<double>() / b["average"].get<double>();
  };
  return fmt::format("T-SAH over SAH0: {:.3f}; in the paper {:.3f}\n", ratio(*tsah, *first),
                     ratio((*tsah)["paper"], (*first)["paper"]));
}

std::string costs_text(const json& rows) {
  std::string out;
  for (const std::string& scene : scenes_of(rows, "tsah_cost")) {
    const std::string paper = paper_head(rows, scene);
    out += fmt::format("\n{}\n{:<28} {:>8} {:>8} {:>8} {:>7} {}\n",
                       scene_head(rows, "tsah_cost", scene), "cost over the animation", "build s",
                       "average", "maximum", "frames", paper);
    each_row(rows, "tsah_cost", scene, [&](const json& row) {
      const std::string note = row["note"];
      out += fmt::format("{:<28} {:8.2f} {:8.1f} {:8.1f} {:7}{}{}{}\n",
                         row["method"].get<std::string>(), row["build_s"].get<double>(),
                         row["average"].get<double>(), row["maximum"].get<double>(),
                         row["frames"].get<size_t>(), paper.empty() ? "" : paper_text(row),
                         note.empty() ? "" : "  ", note);
    });
    out += ratio_text(rows, scene);
  }
  return out;
}

std::string frames_text(const json& rows) {
  std::string out;
  for (const std::string& scene : scenes_of(rows, "tsah_frame")) {
    out += fmt::format("\n{}\n{:<28} {:>6} {:>9} {:>9} {:>9} {:>13}\n",
                       scene_head(rows, "tsah_frame", scene), "a frame of T's workload", "test",
                       "update ms", "MRays/s", "total ms", "primary only");
    each_row(rows, "tsah_frame", scene, [&](const json& row) {
      out += fmt::format("{:<28} {:>6} {:9.2f} {:9.2f} {:9.1f} {:13.2f}\n",
                         row["method"].get<std::string>(), row["test"].get<std::string>(),
                         row["update_ms"].get<double>(), row["mrays_per_s"].get<double>(),
                         row["total_ms"].get<double>(), row["primary_ms"].get<double>());
    });
  }
  return out;
}

// Ours are blue and green, single frames' trees grey and brown, rebuilds purple, Embree's warm.
std::string color_of(const std::string& name) {
  static const std::map<std::string, const char*, std::less<>> kColors = {
      {"SAH-rebuild", "#111111"},
      {"SAH-rebuild, no insertion", "#999999"},
      {"SAH0", "#8c564b"},
      {"SAH0 + insertion", "#c49c94"},
      {"SAH middle frame", "#7f7f7f"},
      {"SAH*", "#bcbd22"},
      {"T-SAH k=0", "#1f77b4"},
      {"T-SAH k=2", "#17becf"},
      {"T-SAH k=4", "#2ca02c"},
      {"T-SAH, 3 trees", "#0b5d1e"},
      {"T-SAH, at most 4 trees", "#22a447"},
      {"T, Metropolis-Hastings", "#d62728"},
      {"T, sorted batch", "#ff7f0e"},
      {"T, random", "#e377c2"},
      {"T k=0", "#d62728"},
      {"T k=2", "#ff7f0e"},
      {"T k=4", "#e377c2"},
      {"binned SAH rebuild", "#5b3f9e"},
      {"HLBVH-med", "#9467bd"},
      {"HLBVH-SAH", "#c5b0d5"},
      {"embree refit", "#e4572e"},
      {"embree refit, middle", "#ff9896"},
      {"embree low rebuild", "#d18f00"},
      {"embree medium rebuild", "#b5651d"},
      {"embree high rebuild", "#a03a3a"}};
  const auto found = kColors.find(name);
  return found != kColors.end() ? found->second : "#3b82f6";
}

struct PlotWords {
  const char* title;
  const char* x_label;
  const char* y_label;
  bool x_percent = true;
};

// A plot for every scene from rows with x and y. Of rows with a triangle test only the fast ones.
std::string plots(const json& rows, std::string_view table, const PlotWords& words) {
  std::string out;
  for (const std::string& scene : scenes_of(rows, table)) {
    LinePlot plot{.title = scene,
                  .x_label = words.x_label,
                  .y_label = words.y_label,
                  .log_x = false,
                  .x_percent = words.x_percent,
                  .lines = {},
                  .marks = {},
                  .mark_name = {}};
    each_row(rows, table, scene, [&](const json& row) {
      if (row.contains("test") && row["test"] != "fast") return;
      const std::string name = row["method"];
      if (row["x"].empty()) return;
      plot.lines.push_back({name, color_of(name), name.starts_with("embree"), row["x"], row["y"]});
    });
    out += svg(plot);
  }
  return out.empty() ? "" : fmt::format("<h2>{}</h2>\n{}", words.title, out);
}

std::string preformatted(const char* title, const std::string& text) {
  if (text.empty()) return "";
  return fmt::format("<h2>{}</h2>\n<pre style=\"overflow-x:auto\">{}</pre>\n", title,
                     escape_markup(text));
}

}  // namespace

std::string tsah_text(const json& report) {
  const json& rows = report["rows"];
  return bench_head(report) + costs_text(rows) + frames_text(rows) + poses_text(rows) +
         skipped_text(report) + figures_text(report["figures"]);
}

std::string tsah_page(const TsahReport& report) {
  const json& rows = report.json["rows"];
  std::string body = preformatted("Costs", costs_text(rows));
  body += plots(rows, "cost_over_frames",
                {"Cost over the animation", "of the animation", "cost (c_T = 3, c_I = 2)"});
  body += preformatted("Frames", frames_text(rows));
  body += plots(rows, "frame_time",
                {"Time of a frame", "of the animation", "ms a frame: update and all rays"});
  body += preformatted("Poses of a character", poses_text(rows));
  body += plots(rows, "convergence_selection",
                {"Convergence: selection of nodes", "seconds", "average cost", false});
  body += plots(rows, "convergence_exponent",
                {"Convergence: exponents", "seconds", "average cost", false});
  if (!report.pictures.empty()) {
    body +=
        "<h2>Trees</h2>\n<p>Nodes with less than a fiftieth of the triangles: what is in one "
        "of them has one colour, and lies in its box. Only what moves is shown.</p>\n" +
        report.pictures;
  }
  return html_page(report.json, body);
}

}  // namespace sinew::bench
