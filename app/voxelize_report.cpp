#include "app/voxelize_report.h"

#include <fmt/format.h>

#include "app/json_text.h"

namespace sinew::app {
namespace {

double ratio(double a, double b) {
  return b > 0.0 ? a / b : 0.0;
}

double each(uint64_t bytes, uint64_t voxels) {
  return ratio(static_cast<double>(bytes), static_cast<double>(voxels));
}

}  // namespace

std::string table_of(const VoxelizeReport& report) {
  std::string text = fmt::format("{:<24} {:>16} {:>10} {:>11} {:>8} {:>8}\n", "object",
                                 "resolution", "triangles", "voxels", "B/voxel", "s");
  for (const VoxelizedObjectReport& o : report.objects) {
    const std::string size =
        fmt::format("{}x{}x{}", o.resolution[0], o.resolution[1], o.resolution[2]);
    const std::string bytes = o.bytes == 0 ? "-" : fmt::format("{:.2f}", each(o.bytes, o.voxels));
    const std::string seconds = o.bytes == 0 ? "-" : fmt::format("{:.2f}", o.seconds);
    text += fmt::format("{:<24.24} {:>16} {:>10} {:>11} {:>8} {:>8}\n", o.name, size, o.triangles,
                        o.voxels, bytes, seconds);
  }
  text += fmt::format("voxels of {:g}: {} in {:.2f} s, {:.2f} million a second on {} thread{}\n",
                      report.voxel, report.voxels, report.make_s,
                      1e-6 * ratio(static_cast<double>(report.voxels), report.make_s),
                      report.threads, report.threads == 1 ? "" : "s");
  if (report.frames > 1) text += fmt::format("frames: {}\n", report.frames);
  if (report.file_bytes > 0) {
    text += fmt::format("{}  {} bytes, {:.2f} a voxel\n", report.output, report.file_bytes,
                        each(report.file_bytes, report.voxels));
  }
  return text;
}

std::string json_of(const VoxelizeReport& report) {
  nlohmann::ordered_json objects = nlohmann::ordered_json::array();
  for (const VoxelizedObjectReport& o : report.objects) {
    nlohmann::ordered_json row;
    row["name"] = o.name;
    row["resolution"] = {o.resolution[0], o.resolution[1], o.resolution[2]};
    row["triangles"] = o.triangles;
    row["voxels"] = o.voxels;
    if (o.bytes > 0) {
      row["bytes"] = o.bytes;
      row["parts"] = o.parts;
      row["bytes_per_voxel"] = each(o.bytes, o.voxels);
      row["seconds"] = o.seconds;
    }
    objects.push_back(std::move(row));
  }
  nlohmann::ordered_json out;
  out["input"] = report.input;
  out["output"] = report.output;
  out["voxel"] = report.voxel;
  out["shell"] = report.shell;
  out["solid"] = report.solid;
  out["threads"] = report.threads;
  out["frames"] = report.frames;
  out["objects"] = std::move(objects);
  out["voxels"] = report.voxels;
  out["file_bytes"] = report.file_bytes;
  out["voxelize_s"] = report.make_s;
  out["voxels_per_s"] = ratio(static_cast<double>(report.voxels), report.make_s);
  out["peak_bytes"] = report.peak_bytes;
  out["total_s"] = report.total_s;
  out["warnings"] = report.warnings;
  return json_text(out);
}

}  // namespace sinew::app
