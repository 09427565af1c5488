#include "bench/figures.h"

#include <embree3/rtcore.h>

#include <array>
#include <fstream>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/bvh/trace/traverse.h"

namespace sinew::bench {
namespace {

constexpr std::optional<double> kNone = std::nullopt;

constexpr std::array kFigures = {
    FigureInfo{"refit_bodies", "1", false, 0.4, 0.8},
    FigureInfo{"picks_100", "1", true, 10.0, 5.0},
    FigureInfo{"picks_10000", "1", true, 2.0, 1.3},
    FigureInfo{"herd_frame", "1", true, 5.0, 3.0},
    FigureInfo{"visible_30", "1", true, 1.5, 1.2},
    FigureInfo{"auto_regret", "1", false, 1.05, 1.10},
    FigureInfo{"bytes_per_triangle", "byte", false, 70.0, 110.0},
    FigureInfo{"single_ray_robust", "1", true, 1.25, 1.0},
    FigureInfo{"single_ray_fast", "1", true, 1.15, 0.95},
    FigureInfo{"packet_speed", "1", true, 1.1, 1.0},
    FigureInfo{"packet_speed_fast", "1", true, kNone, kNone},
    FigureInfo{"refit_ratio", "1", false, kNone, kNone},
    FigureInfo{"cost_moderate", "1", false, 1.03, 1.06},
    FigureInfo{"recovered", "1", true, 0.96, 0.85},
    FigureInfo{"optimise_250k_s", "s", false, 3.0, 8.0},
    FigureInfo{"optimise_1600k_s", "s", false, 25.0, 60.0},
    FigureInfo{"frame_full", "1", true, 1.2, 1.05},
    FigureInfo{"frame_full_least", "1", true, 0.95, 0.95},
    FigureInfo{"frame_full_robust", "1", true, kNone, kNone},
    FigureInfo{"frame_primary", "1", true, 1.6, 1.25},
    FigureInfo{"frame_primary_robust", "1", true, kNone, kNone},
    FigureInfo{"best_single_frame", "1", true, 1.0, 0.97},
    FigureInfo{"best_single_frame_scattering", "1", true, 1.1, kNone},
    FigureInfo{"segments_regret", "1", false, 1.15, 1.4},
    FigureInfo{"fps_800", "1/s", true, 40.0, 20.0},
    FigureInfo{"splats_per_core", "1/s", true, 150e6, 80e6},
    FigureInfo{"holes", "pixel", false, 0.0, 0.0},
    FigureInfo{"excess", "1", false, 0.001, 0.005},
    FigureInfo{"over_thesis", "1", true, 3.0, 2.0},
    FigureInfo{"over_thesis_palettes", "1", true, kNone, kNone},
    FigureInfo{"over_thesis_literal", "1", true, kNone, kNone},
    FigureInfo{"over_revoxelise", "1", true, 30.0, 10.0},
    FigureInfo{"bytes_memory", "byte", false, 6.0, 10.0},
    FigureInfo{"bytes_disk", "byte", false, 3.0, 5.0},
    FigureInfo{"voxelise_per_core", "1/s", true, 10e6, 4e6},
    FigureInfo{"flight_stutter", "1", false, 2.0, 4.0},
    FigureInfo{"flight_psnr", "dB", true, 35.0, 35.0},
    FigureInfo{"settled", "1", true, 1.0, 1.0},
    FigureInfo{"bytes_4096", "byte", false, 3.0, 5.0},
    FigureInfo{"animated_over_static", "1", true, 0.7, 0.5},
    FigureInfo{"octree_over_bvh", "1", true, 0.7, 0.4},
    FigureInfo{"traced_far_pixels", "pixel", false, 0.0, kNone},
    FigureInfo{"traced_psnr", "dB", true, kNone, kNone},
    FigureInfo{"bytes_smaller", "byte", false, kNone, kNone},
};

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

}  // namespace

const FigureInfo* find_figure(std::string_view name) {
  for (const FigureInfo& info : kFigures) {
    if (info.name == name) return &info;
  }
  return nullptr;
}

nlohmann::json figure(const char* name, double value, const std::string& note) {
  const FigureInfo* const info = find_figure(name);
  SINEW_CHECK(info != nullptr);
  nlohmann::json out = {{"name", name},
                        {"value", value},
                        {"unit", info->unit},
                        {"better", info->more_is_better ? "more" : "less"},
                        {"note", note}};
  if (info->goal) out["goal"] = *info->goal;
  if (info->floor) out["floor"] = *info->floor;
  return out;
}

Verdict verdict(const nlohmann::json& figure) {
  if (!figure.contains("goal")) return Verdict::none;
  const double sign = figure["better"] == "more" ? 1.0 : -1.0;
  const double value = sign * figure["value"].get<double>();
  if (value >= sign * figure["goal"].get<double>()) return Verdict::goal;
  if (!figure.contains("floor")) return Verdict::missed;
  return value >= sign * figure["floor"].get<double>() ? Verdict::floor : Verdict::missed;
}

const char* name_of(Verdict verdict) {
  constexpr const char* kNames[] = {"goal met", "floor met", "missed", ""};
  return kNames[static_cast<size_t>(verdict)];
}

nlohmann::json report_head(const char* bench) {
  return {{"bench", bench},
          {"version", SINEW_VERSION},
          {"machine",
           {{"processor", processor()}, {"threads", thread_count()}, {"kernels", kernel_target()}}},
          {"opponents", {"Embree " RTC_VERSION_STRING}}};
}

}  // namespace sinew::bench
