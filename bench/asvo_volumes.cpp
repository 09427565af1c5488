#include "bench/asvo_volumes.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include "bench/asvo_methods.h"
#include "bench/figures.h"
#include "bench/measure.h"
#include "bench/openvdb_volume.h"
#include "sinew/base/parallel.h"
#include "sinew/io/svo/svo.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

template <class T>
uint64_t bytes_of(const std::vector<T>& values) {
  return values.size() * sizeof(T);
}
uint64_t bytes_of(const SvoLevel& level) {
  return bytes_of(level.normals) + bytes_of(level.colors) + bytes_of(level.spreads);
}

std::vector<SvoPart> memory_parts(const Svo& svo) {
  return {{"nodes", bytes_of(svo.nodes)},
          {"blocks", bytes_of(svo.blocks)},
          {"cells", bytes_of(svo.cells)},
          {"bricks", bytes_of(svo.bricks)},
          {"normals of voxels", bytes_of(svo.normals)},
          {"colours of voxels",
           bytes_of(svo.colors) + bytes_of(svo.color_ends) + bytes_of(svo.color_selectors)},
          {"attributes of bricks", bytes_of(svo.brick_level)},
          {"attributes of cells and nodes", bytes_of(svo.cell_level) + bytes_of(svo.node_level)},
          {"places of corners", bytes_of(svo.corner_places)},
          {"skin of corners", bytes_of(svo.corner_joints) + bytes_of(svo.corner_weights) +
                                  bytes_of(svo.joint_palette)},
          {"morph targets", bytes_of(svo.targets) + bytes_of(svo.deltas)}};
}

void add_rows(const AsvoBody& body, const char* where, const std::vector<SvoPart>& parts,
              json& rows) {
  const double voxels = double(body.svo().voxel_count());
  for (const SvoPart& part : parts) {
    rows.push_back({{"table", "asvo_bytes"},
                    {"scene", body.name},
                    {"where", where},
                    {"part", part.name},
                    {"bytes", part.bytes},
                    {"bytes_per_voxel", double(part.bytes) / voxels},
                    {"leaf_voxels", body.svo().voxel_count()}});
  }
}

// A file that is gone when this is.
class Temporary {
 public:
  Temporary()
      : path_((std::filesystem::temp_directory_path() /
               fmt::format("sinew-bench-{}.svo", static_cast<int>(getpid())))
                  .string()) {}
  ~Temporary() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace

Result<void> measure_bytes(const AsvoBody& body, json& rows) {
  const Svo& svo = body.svo();
  add_rows(body, "memory", memory_parts(svo), rows);
  add_rows(body, "memory, in all", {{"octree", svo.bytes()}}, rows);
  // What a pose needs beside the octree.
  SvoMotion motion = make_svo_motion(svo);
  const uint64_t corners = svo.corner_places.size();
  add_rows(body, "a body's pose",
           {{"bounds of blocks", motion.blocks.bytes()},
            {"moved corners", corners * sizeof(vec3)},
            {"their cofactors", corners * sizeof(mat3)}},
           rows);
  const std::vector<ThesisVoxel> voxels = make_thesis_voxels(body.surface, body.source());
  const ThesisOctree thesis = make_thesis_octree(body.surface.grid, voxels, body.joint_count);
  const CornerVoxels corner_voxels =
      make_corner_voxels(body.surface.grid, voxels, body.joint_count);
  add_rows(body, "opponents",
           {{"thesis, 48 bytes a node", thesis.bytes()},
            {"corners, without levels", corner_voxels.bytes()}},
           rows);
  const Temporary file;
  SINEW_TRY(const SavedSvo saved, save_svo(body.voxels, file.path()));
  add_rows(body, "disk", saved.parts, rows);
  add_rows(body, "disk, in all", {{"file", saved.bytes}}, rows);
  return {};
}

Result<void> measure_voxelise(const AsvoBody& body, const AsvoOptions& options, json& rows) {
  for (const int threads : {1, options.threads}) {
    const ThreadLimit limit(threads);
    std::vector<double> surface_ms, octree_ms;
    uint64_t voxels = 0;
    for (uint32_t i = 0; i < std::max(options.repeats / 2, 1u); ++i) {
      Result<VoxelSurface> surface;
      surface_ms.push_back(
          milliseconds([&] { surface = voxelise_at(body, body.rest, body.surface.grid); }));
      if (!surface) return fail(surface.error());
      voxels = surface->voxels;
      Result<Svo> svo;
      octree_ms.push_back(milliseconds([&] { svo = make_svo(*surface, body.source()); }));
      if (!svo) return fail(svo.error());
    }
    const double ms = median(surface_ms);
    rows.push_back({{"table", "asvo_voxelise"},
                    {"scene", body.name},
                    {"threads", threads},
                    {"triangles", body.faces.size()},
                    {"voxels", voxels},
                    {"voxelise_ms", ms},
                    {"octree_ms", median(octree_ms)},
                    {"voxels_per_s", 1e3 * double(voxels) / ms},
                    {"triangles_per_s", 1e3 * double(body.faces.size()) / ms},
                    {"voxels_per_s_with_octree", 1e3 * double(voxels) / (ms + median(octree_ms))}});
    if (options.threads == 1) break;
  }
  return {};
}

Result<void> measure_revoxelise(const AsvoBody& body, const AsvoOptions& options, json& rows) {
  SvoMotion motion = make_svo_motion(body.svo());
  PosedSvo posed;
  AsvoPose pose;
  std::vector<vec3> moved(body.rest.size());
  std::vector<double> move_ms, voxelise_ms, octree_ms, ours_ms, openvdb_ms;
  uint64_t voxels = 0;
  std::optional<uint64_t> openvdb_voxels;
  // Voxels are as large as the octree's.
  for (uint32_t i = 0; i < std::max(options.repeats / 2, 1u) + 1; ++i) {
    pose_at(body, 0, double(i) / 30.0, pose);
    const double ours = milliseconds([&] {
      posed.set_pose(motion, pose.pose);
      parallel_for(body.svo().block_count(), 4, [&](size_t begin, size_t end) {
        for (size_t b = begin; b < end; ++b) posed.make_block(static_cast<uint32_t>(b));
      });
    });
    const double moving = milliseconds([&] {
      parallel_for(moved.size(), 4096, [&](size_t begin, size_t end) {
        positions(body.motion(), pose.pose, static_cast<uint32_t>(begin),
                  std::span(moved).subspan(begin, end - begin));
      });
    });
    SINEW_TRY(const VoxelGrid grid,
              grid_of_voxels(surface_box(moved, body.faces), body.surface.grid.voxel));
    Result<VoxelSurface> surface;
    const double voxelising = milliseconds([&] { surface = voxelise_at(body, moved, grid); });
    if (!surface) return fail(surface.error());
    Result<Svo> svo;
    const double making = milliseconds([&] {
      svo = make_svo(*surface, {body.faces, body.materials, RigidMotion{moved}});
    });
    if (!svo) return fail(svo.error());
    voxels = svo->voxel_count();
    const double openvdb =
        milliseconds([&] { openvdb_voxels = mesh_to_volume(moved, body.faces, grid.voxel); });
    if (i == 0) continue;  // it warmed up
    ours_ms.push_back(ours);
    move_ms.push_back(moving);
    voxelise_ms.push_back(voxelising);
    octree_ms.push_back(making);
    openvdb_ms.push_back(openvdb);
  }
  const double theirs = median(move_ms) + median(voxelise_ms) + median(octree_ms);
  rows.push_back({{"table", "asvo_revoxelise"},
                  {"scene", body.name},
                  {"voxels", voxels},
                  {"corners", body.svo().corner_places.size()},
                  {"pose_ms", median(ours_ms)},
                  {"move_ms", median(move_ms)},
                  {"voxelise_ms", median(voxelise_ms)},
                  {"octree_ms", median(octree_ms)},
                  {"ratio", theirs / median(ours_ms)}});
  if (openvdb_voxels) {
    json& row = rows.back();
    row["openvdb_ms"] = median(openvdb_ms);
    row["openvdb_voxels"] = *openvdb_voxels;
    row["openvdb_ratio"] = (median(move_ms) + median(openvdb_ms)) / median(ours_ms);
  }
  return {};
}

void add_volume_figures(const json& rows, json& figures) {
  for (const json& row : rows) {
    if (row["scene"] != "creature") continue;
    if (row["table"] == "asvo_bytes") {
      const std::string where = row["where"];
      const auto note = [&] {
        return fmt::format("creature: {:.1f} MB of {} leaf voxels",
                           1e-6 * row["bytes"].get<double>(), row["leaf_voxels"].get<uint64_t>());
      };
      if (where == "memory, in all") {
        figures.push_back(figure("bytes_memory", row["bytes_per_voxel"], note()));
      } else if (where == "disk, in all") {
        figures.push_back(figure("bytes_disk", row["bytes_per_voxel"], note()));
      }
    } else if (row["table"] == "asvo_voxelise" && row["threads"] == 1) {
      figures.push_back(
          figure("voxelise_per_core", row["voxels_per_s"],
                 fmt::format("one thread: {} voxels of {} triangles in {:.0f} ms; with the octree "
                             "{:.2f} million a second",
                             row["voxels"].get<uint64_t>(), row["triangles"].get<uint64_t>(),
                             row["voxelise_ms"].get<double>(),
                             1e-6 * row["voxels_per_s_with_octree"].get<double>())));
    } else if (row["table"] == "asvo_revoxelise") {
      figures.push_back(figure(
          "over_revoxelise", row["ratio"],
          fmt::format("{:.1f} ms to move vertices, voxelise and make an octree, over {:.2f} ms to "
                      "move {} corners",
                      row["move_ms"].get<double>() + row["voxelise_ms"].get<double>() +
                          row["octree_ms"].get<double>(),
                      row["pose_ms"].get<double>(), row["corners"].get<uint64_t>())));
    }
  }
}

}  // namespace sinew::bench
