#include "bench/asvo_report.h"

#include <fmt/format.h>

#include <vector>

#include "bench/report.h"
#include "bench/svg_plot.h"
#include "bench/tables.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

// A table of rows: which columns, and how each is written.
struct Column {
  const char* key;
  const char* head;
  int digits;  // behind the point; -1: as it is
  double scale = 1.0;
};
struct Table {
  const char* name;
  const char* title;
  std::vector<Column> columns;
};

const std::vector<Table>& tables() {
  static const std::vector<Table> kTables = {
      {"asvo_body",
       "Bodies",
       {{"scene", "body", -1},
        {"triangles", "triangles", -1},
        {"leaf_voxels", "voxels", -1},
        {"places", "places", -1},
        {"cells", "cells", -1},
        {"corners", "corners", -1},
        {"joints", "joints", -1}}},
      {"asvo_frame",
       "Frames with Phong, normals of normal maps, shadow maps, skinning: ms",
       {{"scene", "body", -1},
        {"lights", "lights", -1},
        {"frames_per_s", "frames/s", 1},
        {"total_ms", "total", 2},
        {"sample_ms", "sample", 2},
        {"pose_ms", "pose", 2},
        {"shadow_ms", "shadow", 2},
        {"draw_ms", "draw", 2},
        {"shade_ms", "shade", 2},
        {"rest_ms", "rest", 2},
        {"leaf_voxels", "voxels", -1},
        {"voxels_drawn", "drawn", -1},
        {"leaves_drawn", "leaves", -1},
        {"shadow_voxels_drawn", "in shadow maps", -1}}},
      {"asvo_size",
       "Frames against the body's share of the picture (A, figure 3)",
       {{"scene", "body", -1},
        {"share", "share", 2},
        {"frames_per_s", "frames/s", 1},
        {"total_ms", "ms", 2},
        {"voxels_drawn", "drawn", -1},
        {"leaves_drawn", "leaves", -1}}},
      {"asvo_grade",
       "Drawn against the amount of animation (A, figure 9)",
       {{"scene", "body", -1},
        {"grade", "movement", 2},
        {"lattice_drawn", "lattice", -1},
        {"thesis_drawn", "thesis", -1},
        {"thesis_without_s_drawn", "without S", -1},
        {"lattice_ms", "lattice ms", 2},
        {"thesis_ms", "thesis ms", 1}}},
      {"asvo_resolution",
       "Frames against resolution",
       {{"scene", "body", -1},
        {"resolution", "resolution", -1},
        {"leaf_voxels", "voxels", -1},
        {"frames_per_s", "frames/s", 1},
        {"total_ms", "ms", 2},
        {"voxels_drawn", "drawn", -1}}},
      {"asvo_splats",
       "Splats of one thread, nothing left out",
       {{"scene", "body", -1},
        {"voxels", "voxels", -1},
        {"placed", "placed", -1},
        {"pose_ms", "pose ms", 2},
        {"view_ms", "cells ms", 2},
        {"draw_ms", "draw ms", 2},
        {"splats_per_s", "M splats/s", 1, 1e-6},
        {"voxels_per_s", "M voxels/s in all", 1, 1e-6}}},
      {"asvo_rival",
       "The lattice against skinning every voxel, in the same rasteriser: ms",
       {{"scene", "body", -1},
        {"method", "method", -1},
        {"threads", "threads", -1},
        {"culled", "culled, levels", -1},
        {"total_ms", "total", 2},
        {"draw_ms", "draw", 2},
        {"drawn", "drawn", -1},
        {"over_lattice", "over lattice", 2}}},
      {"asvo_holes",
       "Holes and excess, pixels",
       {{"scene", "body", -1},
        {"case", "case", -1},
        {"method", "method", -1},
        {"pictures", "pictures", -1},
        {"surface_pixels", "surface", -1},
        {"covered_pixels", "covered", -1},
        {"holes", "holes", -1},
        {"excess", "excess", -1}}},
      {"asvo_distance",
       "The lattice's distance from true skinning, voxels; of clips the worst frame",
       {{"scene", "body", -1},
        {"case", "case", -1},
        {"median", "median", 4},
        {"of_99_percent", "99%", 3},
        {"largest", "largest", 2}}},
      {"asvo_image",
       "Against ray traced triangles",
       {{"scene", "body", -1},
        {"method", "method", -1},
        {"psnr", "PSNR dB", 2},
        {"flip", "FLIP", 4},
        {"psnr_of_body", "PSNR, body", 2},
        {"flip_of_body", "FLIP, body", 4}}},
      {"asvo_bytes",
       "Bytes",
       {{"scene", "body", -1},
        {"where", "where", -1},
        {"part", "part", -1},
        {"bytes", "bytes", -1},
        {"bytes_per_voxel", "a voxel", 3}}},
      {"asvo_voxelise",
       "Voxelising, with attributes",
       {{"scene", "body", -1},
        {"threads", "threads", -1},
        {"triangles", "triangles", -1},
        {"voxels", "voxels", -1},
        {"voxelise_ms", "ms", 0},
        {"octree_ms", "octree ms", 0},
        {"voxels_per_s", "M voxels/s", 2, 1e-6},
        {"triangles_per_s", "M triangles/s", 2, 1e-6}}},
      {"asvo_revoxelise",
       "A pose against voxelising anew: ms",
       {{"scene", "body", -1},
        {"pose_ms", "our pose", 2},
        {"move_ms", "move", 2},
        {"voxelise_ms", "voxelise", 1},
        {"octree_ms", "octree", 1},
        {"ratio", "ratio", 1},
        {"openvdb_ms", "OpenVDB", 1},
        {"openvdb_voxels", "its voxels", -1},
        {"openvdb_ratio", "ratio", 1}}}};
  return kTables;
}

std::string cell_text(const json& row, const Column& column) {
  if (!row.contains(column.key)) return "";
  const json& value = row[column.key];
  if (value.is_string()) return value.get<std::string>();
  if (column.digits < 0) return value.dump();
  return fmt::format("{:.{}f}", column.scale * value.get<double>(), column.digits);
}

// The table as text with aligned columns; empty if it has no rows.
std::string table_text(const json& rows, const Table& table) {
  std::vector<std::vector<std::string>> lines(1);
  for (const Column& column : table.columns) lines[0].push_back(column.head);
  for (const json& row : rows) {
    if (row["table"] != table.name) continue;
    std::vector<std::string>& line = lines.emplace_back();
    for (const Column& column : table.columns) line.push_back(cell_text(row, column));
  }
  if (lines.size() == 1) return "";
  std::string out;
  for (const auto& line : lines) {
    for (size_t c = 0; c < line.size(); ++c) {
      size_t width = 0;
      for (const auto& other : lines) width = std::max(width, other[c].size());
      const bool words = table.columns[c].digits < 0 && c < 3;
      out +=
          words ? fmt::format("{:<{}}  ", line[c], width) : fmt::format("{:>{}}  ", line[c], width);
    }
    out += "\n";
  }
  return out;
}

struct LineChoice {
  const char* key;
  const char* name;
  const char* color;
  bool dashed = false;
};

std::string plot(const json& rows, const char* table, const char* x, LinePlot words,
                 const std::vector<LineChoice>& lines) {
  for (const LineChoice& choice : lines) {
    PlotLine line{choice.name, choice.color, choice.dashed, {}, {}};
    for (const json& row : rows) {
      if (row["table"] != table || row["scene"] != "creature") continue;
      line.x.push_back(row[x]);
      line.y.push_back(row[choice.key]);
    }
    if (!line.x.empty()) words.lines.push_back(std::move(line));
  }
  return words.lines.empty() ? "" : svg(words);
}

LinePlot words_of(const char* title, const char* x, const char* y, bool log) {
  LinePlot out;
  out.title = title;
  out.x_label = x;
  out.y_label = y;
  out.log_x = log;
  out.log_y = log;
  return out;
}

std::string plots(const json& rows) {
  std::string out = plot(rows, "asvo_size", "share",
                         words_of("Frame rate against size (A, figure 3)",
                                  "share of the picture's height", "frames a second", true),
                         {{"frames_per_s", "lattice", "#3b82f6"}});
  out += plot(rows, "asvo_grade", "grade",
              words_of("Levels of detail against animation (A, figure 9)",
                       "movement, in that of the clip", "nodes drawn", false),
              {{"lattice_drawn", "lattice", "#3b82f6"},
               {"thesis_drawn", "thesis", "#e4572e"},
               {"thesis_without_s_drawn", "thesis without S", "#d18f00", true}});
  out += plot(rows, "asvo_resolution", "resolution",
              words_of("Frame rate against resolution", "voxels along the longest side",
                       "frames a second", true),
              {{"frames_per_s", "lattice", "#3b82f6"}});
  return out;
}

}  // namespace

std::string asvo_text(const json& report) {
  const json& rows = report["rows"];
  std::string out = bench_head(report);
  for (const Table& table : tables()) {
    const std::string text = table_text(rows, table);
    if (!text.empty()) out += fmt::format("\n{}\n{}", table.title, text);
  }
  return out + skipped_text(report) + figures_text(report["figures"]);
}

std::string asvo_page(const AsvoReport& report) {
  const json& rows = report.json["rows"];
  std::string body = plots(rows);
  for (const Table& table : tables()) {
    const std::string text = table_text(rows, table);
    if (text.empty()) continue;
    body += fmt::format("<h2>{}</h2>\n<pre style=\"overflow-x:auto\">{}</pre>\n",
                        escape_markup(table.title), escape_markup(text));
  }
  if (!report.pictures.empty()) body += "<h2>Pictures</h2>\n" + report.pictures;
  return html_page(report.json, body);
}

}  // namespace sinew::bench
