// A report of `sinew bench stream` as text and as a page.
#include <fmt/format.h>

#include "bench/report.h"
#include "bench/stream.h"
#include "bench/svg_plot.h"
#include "bench/tables.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

std::string number(const json& row, const char* key, int digits) {
  return fmt::format("{:.{}f}", row[key].get<double>(), digits);
}

std::string rows_text(const json& rows) {
  std::string file, settle, keep, flight;
  for (const json& row : rows) {
    const std::string table = row["table"];
    if (table == "stream_file") {
      file = fmt::format(
          "\n{} voxels along the longest side, {} voxels in {} blocks: file {} MiB, {} bytes a "
          "voxel;\nmemory {} MiB, of which skeleton {} and detail {}; least budget {}\n",
          row["resolution"].get<uint32_t>(), row["voxels"].get<uint64_t>(),
          row["blocks"].get<uint32_t>(), number(row, "file_mib", 1),
          number(row, "bytes_per_voxel", 2), number(row, "memory_mib", 1),
          number(row, "skeleton_mib", 1), number(row, "detail_mib", 1),
          number(row, "least_mib", 1));
    } else if (table == "stream_settle") {
      settle += fmt::format(
          "{:<12}{:<12}{:>10}{:>10}{:>10}{:>11}{:>7}{:>8}{:>9}{:>10}{:>10}\n",
          row["budget"].get<std::string>(), row["view"].get<std::string>(),
          number(row, "first_ms", 0), number(row, "first_psnr", 1), number(row, "settled_ms", 0),
          row["identical"].get<bool>() ? "identical" : "differs",
          row["fits"].get<bool>() ? "fits" : "-", row["loaded"].get<uint64_t>(),
          row["evicted"].get<uint64_t>(), number(row, "read_mib", 1), number(row, "most_mib", 1));
      keep += fmt::format("{:<12}{:<12}{:>10}{:>10}{:>11}{:>7}{:>8}{:>10}\n",
                          row["budget"].get<std::string>(), row["view"].get<std::string>(),
                          number(row, "whole_ms", 0), number(row, "kept_ms", 0),
                          row["kept_identical"].get<bool>() ? "identical" : "differs",
                          row["kept_parts"].get<uint64_t>(), row["kept_loaded"].get<uint64_t>(),
                          number(row, "kept_most_mib", 1));
    } else if (table == "stream_flight") {
      flight += fmt::format(
          "{:<12}{:>9}{:>9}{:>9}{:>9}{:>12}{:>9}{:>8}{:>8}{:>10}{:>8}{:>9}{:>10}\n",
          row["budget"].get<std::string>(), number(row, "median_ms", 1), number(row, "p99_ms", 1),
          number(row, "largest_ms", 1), number(row, "stutter", 2),
          number(row, "whole_median_ms", 1), row["stalled"].get<int>(),
          row["coarse_frames"].get<int>(), number(row, "psnr_median", 1),
          number(row, "psnr_least", 1), row["loaded"].get<uint64_t>(),
          row["evicted"].get<uint64_t>(), number(row, "read_mib", 1));
    }
  }
  return fmt::format(
      "{}\nUntil the picture is settled, frame by frame\n"
      "{:<12}{:<12}{:>10}{:>10}{:>10}{:>11}{:>7}{:>8}{:>9}{:>10}{:>10}\n{}\n"
      "Pictures to keep, in parts\n{:<12}{:<12}{:>10}{:>10}{:>11}{:>7}{:>8}{:>10}\n{}\n"
      "A flight\n{:<12}{:>9}{:>9}{:>9}{:>9}{:>12}{:>9}{:>8}{:>8}{:>10}{:>8}{:>9}{:>10}\n{}",
      file, "budget", "view", "first ms", "its PSNR", "settled", "", "", "loaded", "evicted",
      "read MiB", "most MiB", settle, "budget", "view", "whole ms", "ms", "", "parts", "loaded",
      "most MiB", keep, "budget", "median", "p99", "largest", "stutter", "whole's med", "stalled",
      "coarse", "PSNR", "its least", "loaded", "evicted", "read MiB", flight);
}

std::string plot_of(const json& rows) {
  LinePlot plot;
  plot.title = "Frames of the flight";
  plot.x_label = "frame";
  plot.y_label = "ms";
  plot.log_x = plot.log_y = false;
  const char* const colors[] = {"#0072b2", "#d55e00", "#009e73"};
  for (const json& row : rows) {
    if (row["table"] != "stream_flight") continue;
    PlotLine line{row["budget"], colors[plot.lines.size() % 3], false, {}, {}};
    for (const double ms : row["frame_ms"].get<std::vector<double>>()) {
      line.x.push_back(double(line.x.size()));
      line.y.push_back(ms);
    }
    plot.lines.push_back(std::move(line));
  }
  return plot.lines.empty() ? std::string() : svg(plot);
}

}  // namespace

std::string stream_text(const json& report) {
  return bench_head(report) + rows_text(report["rows"]) + "\n" + figures_text(report["figures"]) +
         skipped_text(report);
}

std::string stream_page(const json& report) {
  return html_page(report, plot_of(report["rows"]) + "<pre style=\"overflow-x:auto\">" +
                               escape_markup(rows_text(report["rows"])) + "</pre>\n");
}

}  // namespace sinew::bench
