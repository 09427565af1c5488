#include "bench/asvo_rival.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <vector>

#include "bench/asvo_methods.h"
#include "bench/figures.h"
#include "bench/measure.h"
#include "sinew/base/parallel.h"
#include "sinew/render/raster_view.h"
#include "sinew/svo/thesis/thesis_skinned.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

constexpr uint32_t kWarmups = 2;

constexpr const char* kLattice = "lattice";
constexpr const char* kGather = "every voxel skinned, gathers";
constexpr const char* kPalette = "every voxel skinned, palettes in registers";
constexpr const char* kLiteral = "thesis, one thread";

struct Runner {
  const char* name;
  std::function<RasterStats()> draw;
  std::vector<double> total{}, drawing{};
  RasterStats last{};
};

// Every repeat is a new pose, drawn by all in turn.
void compete(const AsvoBody& body, AsvoPainter& painter, std::vector<Runner>& runners,
             uint32_t repeats) {
  AsvoPose pose;
  for (uint32_t i = 0; i < kWarmups + repeats; ++i) {
    pose_at(body, 0, double(i % 30) / 30.0, pose);
    for (size_t k = 0; k < runners.size(); ++k) {
      Runner& runner = runners[(k + i) % runners.size()];
      const double ms = milliseconds([&] {
        painter.set_pose(pose);
        runner.last = runner.draw();
      });
      if (i < kWarmups) continue;
      runner.total.push_back(ms);
      runner.drawing.push_back(runner.last.draw_ms);
    }
  }
}

void add_rows(const AsvoBody& body, const std::vector<Runner>& runners, int threads, bool culled,
              json& rows) {
  const double least = median(runners[0].total);
  for (const Runner& runner : runners) {
    rows.push_back({{"table", "asvo_rival"},
                    {"scene", body.name},
                    {"method", runner.name},
                    {"threads", threads},
                    {"culled", culled},
                    {"total_ms", median(runner.total)},
                    {"draw_ms", median(runner.drawing)},
                    {"drawn", runner.last.voxels_drawn},
                    {"over_lattice", median(runner.total) / least}});
  }
}

}  // namespace

void measure_rivals(const AsvoBody& body, const AsvoOptions& options, json& rows) {
  AsvoPainter painter(body);
  const SkinnedVoxels skinned =
      make_skinned_voxels(body.svo(), make_thesis_voxels(body.surface, body.source()));
  AsvoPose pose;
  pose_at(body, 0, 0.0, pose);
  const CameraView camera = body_camera(body_box(body, pose), 0.9f);
  const RasterView view = camera_raster_view(camera, options.size, options.size);
  Visibility picture;
  SkinnedTable gather{&skinned, SkinnedLookup::gather, {}};
  SkinnedTable palette{&skinned, SkinnedLookup::palette, {}};
  const RasterScratchPtr gather_scratch = make_raster_scratch();
  const RasterScratchPtr palette_scratch = make_raster_scratch();
  for (const bool culled : {true, false}) {
    painter.settings = {.lod = culled, .occlusion = culled};
    for (const int threads : {options.threads, 1}) {
      const ThreadLimit limit(threads);
      std::vector<Runner> runners;
      runners.push_back({kLattice, [&] {
                           painter.draw(AsvoMethod::lattice, view, picture);
                           return painter.lattice_stats;
                         }});
      runners.push_back({kGather, [&] {
                           return rasterize_skinned(painter.lattice_instance(), view,
                                                    painter.settings, gather, *gather_scratch,
                                                    picture);
                         }});
      runners.push_back({kPalette, [&] {
                           return rasterize_skinned(painter.lattice_instance(), view,
                                                    painter.settings, palette, *palette_scratch,
                                                    picture);
                         }});
      runners.push_back({kLiteral, [&] {
                           RasterStats stats;
                           stats.draw_ms = milliseconds(
                               [&] { painter.draw(AsvoMethod::thesis, view, picture); });
                           stats.voxels_drawn = painter.thesis_stats.drawn;
                           return stats;
                         }});
      compete(body, painter, runners, options.repeats);
      add_rows(body, runners, threads, culled, rows);
      if (options.threads == 1) break;
    }
  }
}

void add_rival_figures(const json& rows, json& figures) {
  const auto find = [&](const char* method, bool culled) -> const json* {
    for (const json& row : rows) {
      if (row["table"] == "asvo_rival" && row["scene"] == "creature" && row["method"] == method &&
          row["culled"] == culled) {
        return &row;  // with all threads: they come first
      }
    }
    return nullptr;
  };
  const json *gather = find(kGather, true), *palette = find(kPalette, true);
  const json *gather_all = find(kGather, false), *palette_all = find(kPalette, false);
  const json* const literal = find(kLiteral, true);
  if (gather == nullptr || palette == nullptr || literal == nullptr) return;
  const auto ratio = [](const json* row) { return (*row)["over_lattice"].get<double>(); };
  figures.push_back(
      figure("over_thesis", ratio(gather),
             fmt::format("whole pictures; joints' matrices gathered for every voxel; with nothing "
                         "culled and no levels {:.2f}",
                         ratio(gather_all))));
  figures.push_back(
      figure("over_thesis_palettes", ratio(palette),
             fmt::format("the same where every cell's joints lie in registers, which takes cells: "
                         "the strongest rival there is; with nothing culled {:.2f}",
                         ratio(palette_all))));
  figures.push_back(figure("over_thesis_literal", ratio(literal),
                           "the thesis's method as it was published, scalar, one thread"));
}

}  // namespace sinew::bench
