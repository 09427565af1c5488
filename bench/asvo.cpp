#include "bench/asvo.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <utility>

#include "bench/asvo_body.h"
#include "bench/asvo_frames.h"
#include "bench/asvo_holes.h"
#include "bench/asvo_images.h"
#include "bench/asvo_rival.h"
#include "bench/asvo_volumes.h"
#include "bench/figures.h"
#include "bench/openvdb_volume.h"
#include "bench/parts.h"
#include "sinew/base/parallel.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

constexpr const char* kCreature = "creature";
constexpr const char* kCoarse = "coarse";
constexpr const char* kPigMan = "pigman";
constexpr const char* kStatic = "static";

bool wants(const AsvoOptions& options, std::string_view part) {
  return wants_part(options.only, part);
}

std::vector<AsvoBodyChoice> chosen_bodies(const AsvoOptions& options, json& skipped) {
  std::vector<AsvoBodyChoice> out;
  const auto wants_body = [&](const char* name) { return wants_part(options.bodies, name); };
  if (wants_body(kCreature)) out.push_back({kCreature, options.creature, false});
  if (wants_body(kCoarse)) out.push_back({kCoarse, options.creature, false});
  if (wants_body(kPigMan)) {
    const std::string file = options.data + "/skinned/pigman/pigman.glb";
    if (std::filesystem::exists(file)) {
      out.push_back({kPigMan, file, false});
    } else {
      skipped.push_back(fmt::format("pigman: {} is not there (say where with --data)", file));
    }
  }
  if (wants_body(kStatic)) out.push_back({kStatic, options.creature, true});
  return out;
}

// Whether any chosen part looks at the body: opening one takes long.
bool is_of_use(const AsvoBodyChoice& choice, const AsvoOptions& options) {
  const auto any = [&](std::initializer_list<const char*> parts) {
    return std::ranges::any_of(parts, [&](const char* part) { return wants(options, part); });
  };
  if (choice.name == kCreature) {
    return any({"frames", "size", "grade", "splats", "thesis", "memory", "voxelise", "revoxelise",
                "resolution"});
  }
  if (any({"frames", "memory", "holes"})) return true;
  return !choice.turns && any({"thesis", "images"});
}

// What is measured of the creature in fine voxels alone.
Result<void> measure_creature(AsvoBody& body, const AsvoOptions& options, json& rows) {
  if (wants(options, "size")) SINEW_CHECKED(measure_sizes(body, options, rows));
  if (wants(options, "grade")) measure_grades(body, options, rows);
  if (wants(options, "splats")) measure_splats(body, options, rows);
  if (wants(options, "thesis")) measure_rivals(body, options, rows);
  if (wants(options, "memory")) SINEW_CHECKED(measure_bytes(body, rows));
  if (wants(options, "voxelise")) SINEW_CHECKED(measure_voxelise(body, options, rows));
  if (wants(options, "revoxelise")) SINEW_CHECKED(measure_revoxelise(body, options, rows));
  if (wants(options, "resolution")) SINEW_CHECKED(measure_resolutions(body, options, rows));
  return {};
}

Result<void> measure_body(AsvoBody& body, const AsvoOptions& options, json& rows,
                          std::string& pictures) {
  rows.push_back({{"table", "asvo_body"},
                  {"scene", body.name},
                  {"triangles", body.faces.size()},
                  {"leaf_voxels", body.svo().voxel_count()},
                  {"places", body.surface.voxels},
                  {"cells", body.svo().cells.size()},
                  {"corners", body.svo().corner_places.size()},
                  {"joints", body.joint_count},
                  {"voxelise_ms", body.voxelise_ms},
                  {"octree_ms", body.make_ms}});
  if (wants(options, "frames")) SINEW_CHECKED(measure_frames(body, options, rows));
  if (body.name == kCreature) return measure_creature(body, options, rows);
  if (wants(options, "thesis") && !body.turns) measure_rivals(body, options, rows);
  if (wants(options, "memory")) SINEW_CHECKED(measure_bytes(body, rows));
  if (wants(options, "holes")) measure_holes(body, options, rows);
  if (wants(options, "images")) SINEW_CHECKED(measure_images(body, options, rows, pictures));
  return {};
}

}  // namespace

std::vector<std::string> asvo_parts() {
  return {"frames",   "size",       "grade", "splats", "thesis",    "memory",
          "voxelise", "revoxelise", "holes", "images", "resolution"};
}

std::vector<std::string> asvo_bodies() {
  return {kCreature, kCoarse, kPigMan, kStatic};
}

Result<AsvoReport> bench_asvo(const AsvoOptions& options) {
  SINEW_CHECKED(check_parts(options.only, asvo_parts()));
  SINEW_CHECKED(check_parts(options.bodies, asvo_bodies()));
  const ThreadLimit limit(options.threads);
  json rows = json::array(), figures = json::array(), skipped = json::array();
  AsvoReport out;
  for (const AsvoBodyChoice& choice : chosen_bodies(options, skipped)) {
    if (!is_of_use(choice, options)) continue;
    const bool fine = choice.name == kCreature;
    SINEW_TRY(AsvoBody body, open_asvo_body(choice, fine ? options.fine : options.resolution));
    SINEW_CHECKED(measure_body(body, options, rows, out.pictures));
  }
  add_drawing_figures(rows, figures);
  add_hole_figures(rows, figures);
  add_rival_figures(rows, figures);
  add_volume_figures(rows, figures);
  out.json = report_head("asvo");
  out.json["figures"] = std::move(figures);
  out.json["rows"] = std::move(rows);
  if (!kHasOpenVdb && wants(options, "revoxelise")) {
    skipped.push_back(
        "OpenVDB's meshToVolume: install libopenvdb-dev and libboost-dev, and build again");
  }
  out.json["skipped"] = std::move(skipped);
  return out;
}

}  // namespace sinew::bench
