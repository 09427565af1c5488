// A report of `sinew bench voxtrace` as text and as a page.
#include <fmt/format.h>

#include "bench/report.h"
#include "bench/svg_plot.h"
#include "bench/tables.h"
#include "bench/voxtrace.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

constexpr double kMiB = 1024.0 * 1024.0;

struct Column {
  const char* key;
  const char* head;
  int width;
  int digits = 0;  // behind the point
  double scale = 1.0;
};
struct Table {
  const char* name;
  const char* title;
  std::vector<Column> columns;
};

const std::vector<Table>& tables() {
  static const std::vector<Table> kTables = {
      {"voxtrace_body",
       "The body",
       {{"scene", "scene", 34},
        {"resolution", "resolution", 12},
        {"triangles", "triangles", 11},
        {"voxels", "voxels", 11},
        {"cells", "cells", 9}}},
      {"voxtrace_speed",
       "Million rays a second, when everything that they meet was made",
       {{"engine", "engine", 16},
        {"level", "level", 10},
        {"rays", "rays", 9},
        {"pose", "pose", 7, 3},
        {"count", "rays", 9},
        {"hits", "hits", 9},
        {"rays_per_s", "M/s", 9, 2, 1e-6}}},
      {"voxtrace_pose",
       "What these rays have made of the animated octree",
       {{"pose", "pose", 7, 3},
        {"hit_share", "hits", 7, 3},
        {"blocks", "blocks", 9},
        {"blocks_made", "made", 9},
        {"cells_made", "cells", 9},
        {"voxels_anew", "voxels anew", 13}}},
      {"voxtrace_first",
       "From a new pose to its picture, first visits included: ms",
       {{"engine", "engine", 16},
        {"pose_ms", "pose", 10, 2},
        {"first_ms", "picture", 10, 2},
        {"total_ms", "both", 10, 2},
        {"again_ms", "again", 10, 2}}},
      {"voxtrace_bytes",
       "Bytes of the octree and of one pose of it",
       {{"part", "part", 34},
        {"bytes", "MiB", 9, 2, 1.0 / kMiB},
        {"bytes_per_voxel", "a voxel", 9, 2}}},
      {"voxtrace_picture",
       "Silhouettes: pixels of only one; those more than a pixel from the other",
       {{"what", "pictures", 38},
        {"pose", "pose", 7, 3},
        {"pixels", "pixels", 9},
        {"only_first", "1st only", 10},
        {"only_second", "2nd only", 10},
        {"far", "far", 7},
        {"psnr", "PSNR dB", 9, 2},
        {"psnr_inside", "inside", 9, 2}}},
      {"voxtrace_crowd",
       "Crowds, each instance in a pose of its own: ms",
       {{"instances", "instances", 11},
        {"voxels", "voxels", 11},
        {"commit_ms", "commit", 9, 2},
        {"trace_ms", "picture", 10, 2},
        {"frame_ms", "frame", 9, 2},
        {"again_ms", "again", 9, 2},
        {"hits", "hits", 9},
        {"blocks", "blocks", 9},
        {"blocks_made", "made", 9},
        {"cells_made", "cells", 9},
        {"bytes", "MiB", 9, 1, 1.0 / kMiB}}}};
  return kTables;
}

std::string cell_text(const json& row, const Column& column) {
  if (!row.contains(column.key)) return "";
  const json& value = row[column.key];
  if (value.is_string()) return value.get<std::string>();
  return fmt::format("{:.{}f}", column.scale * value.get<double>(), column.digits);
}

std::string rows_text(const json& rows) {
  std::string out;
  for (const Table& table : tables()) {
    std::string lines;
    for (const json& row : rows) {
      if (row["table"] != table.name) continue;
      for (const Column& c : table.columns) {
        const bool words = row.contains(c.key) && row[c.key].is_string();
        lines += words ? fmt::format("{:<{}}", cell_text(row, c), c.width)
                       : fmt::format("{:>{}}", cell_text(row, c), c.width);
      }
      lines += "\n";
    }
    if (lines.empty()) continue;
    out += fmt::format("\n{}\n", table.title);
    for (const Column& c : table.columns) {
      out += c.width > 13 || std::string_view(c.key) == "level"
                 ? fmt::format("{:<{}}", c.head, c.width)
                 : fmt::format("{:>{}}", c.head, c.width);
    }
    out += "\n" + lines;
  }
  return out;
}

std::string speeds(const json& rows) {
  BarPlot plot;
  plot.title = "Rays through the finest voxels";
  plot.y_label = "million rays a second";
  const char* const engines[] = {"triangles", "animated", "voxelised anew"};
  const char* const colors[] = {"#0072b2", "#d55e00", "#009e73"};
  for (size_t e = 0; e < 3; ++e) {
    BarSeries series{engines[e], colors[e], {}};
    for (const json& row : rows) {
      if (row["table"] != "voxtrace_speed" || row["engine"] != engines[e]) continue;
      if (row["level"] != "finest") continue;
      series.values.push_back(1e-6 * row["rays_per_s"].get<double>());
      if (e > 0) continue;
      plot.groups.push_back(
          fmt::format("{} {:.2f}", row["rays"].get<std::string>(), row["pose"].get<double>()));
    }
    plot.series.push_back(std::move(series));
  }
  return plot.groups.empty() ? "" : svg(plot);
}

std::string crowds(const json& rows) {
  LinePlot plot;
  plot.title = "Crowds, each instance in a pose of its own";
  plot.x_label = "instances";
  plot.y_label = "ms";
  const std::pair<const char*, const char*> choices[] = {
      {"frame_ms", "frame"}, {"commit_ms", "commit"}, {"again_ms", "picture, all made"}};
  const char* const colors[] = {"#0072b2", "#d55e00", "#009e73"};
  for (size_t i = 0; i < 3; ++i) {
    PlotLine line{choices[i].second, colors[i], false, {}, {}};
    for (const json& row : rows) {
      if (row["table"] != "voxtrace_crowd") continue;
      line.x.push_back(row["instances"]);
      line.y.push_back(row[choices[i].first]);
    }
    if (!line.x.empty()) plot.lines.push_back(std::move(line));
  }
  return plot.lines.empty() ? "" : svg(plot);
}

}  // namespace

std::string voxtrace_text(const json& report) {
  return bench_head(report) + rows_text(report["rows"]) + "\n" + figures_text(report["figures"]) +
         skipped_text(report);
}

std::string voxtrace_page(const json& report) {
  const json& rows = report["rows"];
  return html_page(report, speeds(rows) + crowds(rows) + "<pre style=\"overflow-x:auto\">" +
                               escape_markup(rows_text(rows)) + "</pre>\n");
}

}  // namespace sinew::bench
