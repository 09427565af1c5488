#include "bench/asvo_holes.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>

#include "bench/asvo_methods.h"
#include "bench/figures.h"
#include "sinew/render/raster_view.h"
#include "sinew/svo/holes/hole_reference.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

constexpr float kPieces = 0.5f;  // voxels
constexpr float kStretches[] = {1.0f, 1.5f, 2.0f, 3.0f, 4.0f, 6.0f, 8.0f};

struct Tally {
  HoleCount sum;
  double worst_excess = 0.0;  // share of a picture's covered pixels
  uint32_t pictures = 0;
};

class HoleHunt {
 public:
  HoleHunt(const AsvoBody& body, const AsvoOptions& options)
      : body_(body),
        options_(options),
        source_(body.source()),
        reference_(source_, body.svo(), kPieces, &body.surface),
        painter_(body) {}

  // Every method in one pose.
  void measure(const AsvoPose& pose, std::map<AsvoMethod, Tally>& tallies) {
    const CameraView camera = body_camera(body_box(body_, pose), 0.9f);
    const RasterView view = camera_raster_view(camera, options_.size, options_.size);
    painter_.set_pose(pose);
    SurfacePicture by_lattice, truly;
    reference_.draw_lattice(painter_.posed(), pose.pose.placement, view, by_lattice);
    reference_.draw_true(pose.pose, pose.pose.placement, view, truly);
    for (const AsvoMethod method : kAsvoMethods) {
      painter_.draw(method, view, picture_);
      // The lattice carries its own reference; the others move voxels as skinning says.
      const bool lattice = method == AsvoMethod::lattice;
      const HoleCount count = count_holes(lattice ? by_lattice : truly, picture_);
      Tally& tally = tallies[method];
      tally.sum += count;
      ++tally.pictures;
      const double share = double(count.excess) / double(std::max<uint64_t>(count.covered, 1));
      tally.worst_excess = std::max(tally.worst_excess, share);
    }
  }

  DistanceSummary distance(const AsvoPose& pose) {
    painter_.set_pose(pose);
    return reference_.distance(painter_.posed());
  }

  const HoleReference& reference() const { return reference_; }

 private:
  const AsvoBody& body_;
  const AsvoOptions& options_;
  SvoSource source_;
  HoleReference reference_;
  AsvoPainter painter_;
  Visibility picture_;
};

void add_rows(const AsvoBody& body, const std::string& what, const HoleHunt& hunt,
              const std::map<AsvoMethod, Tally>& tallies, json& rows) {
  for (const auto& [method, tally] : tallies) {
    rows.push_back({{"table", "asvo_holes"},
                    {"scene", body.name},
                    {"case", what},
                    {"method", name_of(method)},
                    {"pictures", tally.pictures},
                    {"surface_pixels", tally.sum.surface},
                    {"covered_pixels", tally.sum.covered},
                    {"holes", tally.sum.holes},
                    {"excess", tally.sum.excess},
                    {"worst_excess", tally.worst_excess},
                    {"reference_points", hunt.reference().points()},
                    {"points_lost", hunt.reference().lost()},
                    {"points_stray", hunt.reference().strays()}});
  }
}

void add_distance(const AsvoBody& body, const std::string& what, const DistanceSummary& distance,
                  json& rows) {
  rows.push_back({{"table", "asvo_distance"},
                  {"scene", body.name},
                  {"case", what},
                  {"points", distance.points},
                  {"median", distance.median},
                  {"of_99_percent", distance.most_of_100},
                  {"largest", distance.largest}});
}

void measure_clips(const AsvoBody& body, const AsvoOptions& options, HoleHunt& hunt, json& rows) {
  const size_t clips = body.turns ? 1 : std::max<size_t>(body.triangles.clips.size(), 1);
  for (size_t c = 0; c < clips; ++c) {
    const std::string name = body.turns                     ? "turning"
                             : body.triangles.clips.empty() ? "at rest"
                                                            : body.triangles.clips[c].name;
    std::map<AsvoMethod, Tally> tallies;
    DistanceSummary worst;
    AsvoPose pose;
    for (uint32_t f = 0; f < options.frames; ++f) {
      pose_at(body, static_cast<int>(c), double(f) / options.frames, pose);
      hunt.measure(pose, tallies);
      if (body.turns) continue;
      const DistanceSummary here = hunt.distance(pose);
      worst.points += here.points;
      worst.median = std::max(worst.median, here.median);
      worst.most_of_100 = std::max(worst.most_of_100, here.most_of_100);
      worst.largest = std::max(worst.largest, here.largest);
    }
    add_rows(body, name, hunt, tallies, rows);
    if (!body.turns) add_distance(body, name, worst, rows);
  }
}

void measure_stretches(const AsvoBody& body, HoleHunt& hunt, json& rows) {
  const uint32_t joint = bone_to_stretch(body);
  for (const float factor : kStretches) {
    AsvoPose pose;
    pose_at(body, 0, 0.25, pose);
    stretch_bone(body, joint, factor, pose);
    std::map<AsvoMethod, Tally> tallies;
    hunt.measure(pose, tallies);
    const std::string what = fmt::format(
        "{} x {:g}", body.voxels.nodes[body.voxels.skins[0].joints[joint]].name, factor);
    add_rows(body, what, hunt, tallies, rows);
    add_distance(body, what, hunt.distance(pose), rows);
  }
}

}  // namespace

void measure_holes(const AsvoBody& body, const AsvoOptions& options, json& rows) {
  HoleHunt hunt(body, options);
  measure_clips(body, options, hunt, rows);
  if (!body.turns) measure_stretches(body, hunt, rows);
}

void add_hole_figures(const json& rows, json& figures) {
  uint64_t holes = 0, surface = 0, excess = 0, covered = 0, pictures = 0;
  double worst = 0.0;
  for (const json& row : rows) {
    if (row["table"] != "asvo_holes" || row["method"] != name_of(AsvoMethod::lattice)) continue;
    holes += row["holes"].get<uint64_t>();
    surface += row["surface_pixels"].get<uint64_t>();
    excess += row["excess"].get<uint64_t>();
    covered += row["covered_pixels"].get<uint64_t>();
    pictures += row["pictures"].get<uint64_t>();
    worst = std::max(worst, row["worst_excess"].get<double>());
  }
  if (pictures == 0) return;
  figures.push_back(figure("holes", double(holes),
                           fmt::format("pixels, of {} of the surface in {} pictures: clips of all "
                                       "bodies, and bones stretched up to 8 times",
                                       surface, pictures)));
  figures.push_back(
      figure("excess", double(excess) / double(std::max<uint64_t>(covered, 1)),
             fmt::format("of all covered pixels; {:.5f} in the worst picture", worst)));
}

}  // namespace sinew::bench
