// Crowds: instances of one octree, each in a pose of its own, in a square; seen as a whole.
#include <algorithm>
#include <cmath>

#include "bench/measure.h"
#include "bench/voxtrace_pictures.h"
#include "bench/workload.h"
#include "sinew/svo/draw/rasterize.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

constexpr uint32_t kFrames = 5;  // and one before, which warms up

class Crowd {
 public:
  static Result<Crowd> open(const AsvoBody& body, uint32_t count) {
    Crowd out(body);
    SINEW_TRY(const BodyId id, out.world_.add_octree({&body.svo(), {}}));
    for (uint32_t i = 0; i < count; ++i) {
      SINEW_TRY(const ObjectId object, out.world_.add_object(id));
      out.objects_.push_back(object);
    }
    return out;
  }

  // Every instance at its own time of the clip.
  void sample(uint32_t frame) {
    poses_.resize(objects_.size());
    const Box box = surface_box(body_.rest, body_.faces);
    const float step = 1.1f * std::max(box.extent().x, box.extent().z);
    const auto side = static_cast<uint32_t>(std::ceil(std::sqrt(double(objects_.size()))));
    for (uint32_t i = 0; i < objects_.size(); ++i) {
      const double u = double(i) / double(objects_.size()) + 0.031 * frame;
      pose_at(body_, 0, u - std::floor(u), poses_[i]);
      poses_[i].pose.placement[3] +=
          vec3(step * static_cast<float>(i % side), 0.0f, step * static_cast<float>(i / side));
    }
  }

  Result<void> commit() {
    for (uint32_t i = 0; i < objects_.size(); ++i) {
      SINEW_CHECKED(world_.set_pose(objects_[i], poses_[i].pose));
    }
    world_.commit();
    return {};
  }
  const World& world() const { return world_; }

 private:
  explicit Crowd(const AsvoBody& body) : body_(body) {}
  const AsvoBody& body_;
  World world_;
  std::vector<ObjectId> objects_;
  std::vector<AsvoPose> poses_;
};

Result<json> measure_crowd(const AsvoBody& body, uint32_t count, const VoxtraceOptions& options) {
  const uint64_t before = resident_bytes();
  SINEW_TRY(Crowd crowd, Crowd::open(body, count));
  std::vector<Ray> rays;
  QueryOptions query;
  VoxtraceHits hits;
  std::vector<double> commit_ms, trace_ms, again_ms, frame_ms;
  for (uint32_t frame = 0; frame <= kFrames; ++frame) {
    crowd.sample(frame);
    Result<void> good;
    const double committing = milliseconds([&] { good = crowd.commit(); });
    if (!good) return fail(good.error());
    if (frame == 0) {
      const CameraView camera =
          frame_box(crowd.world().box(), normalize(vec3(0.3f, 0.6f, 1.0f)), 0.6f, 1.0f);
      const CameraRays make(camera, options.size, options.size);
      const float smallest = RasterSettings().smallest;
      query.footprint = {smallest * make.pixel_width(), smallest * make.pixel_spread()};
      rays = primary_rays(camera, options.size, options.size);
    }
    const auto look = [&] { trace(crowd.world(), RayKind::primary, rays, query, hits); };
    const double first = milliseconds(look), again = milliseconds(look);
    if (frame == 0) continue;
    commit_ms.push_back(committing);
    trace_ms.push_back(first);
    again_ms.push_back(again);
    frame_ms.push_back(committing + first);
  }
  const uint64_t after = resident_bytes();
  const UpdateStats stats = crowd.world().stats();
  return json{{"table", "voxtrace_crowd"},
              {"instances", count},
              {"commit_ms", median(commit_ms)},
              {"trace_ms", median(trace_ms)},
              {"again_ms", median(again_ms)},
              {"frame_ms", median(frame_ms)},
              {"hits", hits_of(RayKind::primary, hits)},
              {"blocks", stats.blocks},
              {"blocks_made", stats.blocks_made},
              {"cells_made", stats.cells_made},
              {"bytes", after - std::min(before, after)}};
}

}  // namespace

Result<void> measure_crowds(const AsvoBody& body, const VoxtraceOptions& options, json& rows) {
  for (const uint32_t count : {1u, 3u, 10u, 30u, 100u, 300u, 1000u}) {
    if (count > options.crowd) break;
    SINEW_TRY(json row, measure_crowd(body, count, options));
    row["voxels"] = body.svo().voxel_count();
    rows.push_back(std::move(row));
  }
  return {};
}

}  // namespace sinew::bench
