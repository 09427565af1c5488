#include "bench/larsson_engines.h"

#include "sinew/base/check.h"
#include "sinew/bvh/larsson/larsson_bodies.h"
#include "sinew/world/world.h"

namespace sinew::bench {
namespace {

// Keys are numbered in time: FrameInput::key counts them.
std::vector<float> key_times(size_t keys) {
  std::vector<float> times;
  for (size_t k = 0; k < keys; ++k) times.push_back(static_cast<float>(k));
  return times;
}

class LarssonEngine final : public TableEngine {
 public:
  LarssonEngine(std::span<const BodyInput> bodies, LarssonUpdate update,
                const larsson::Config& config)
      : inputs_(bodies), update_(update) {
    for (const BodyInput& body : bodies) {
      std::vector<larsson::Hierarchy> keys;
      for (const std::vector<vec3>& shape : body.key_shapes) {
        keys.emplace_back(shape, body.triangles, config);
      }
      const std::vector<float> times = key_times(keys.size());
      bodies_.add(larsson::KeyHierarchies(times, std::move(keys)));
    }
  }

  void begin_frame(const FrameInput& frame) override {
    for (uint32_t b = 0; b < inputs_.size(); ++b) {
      if (!inputs_[b].moves) continue;
      larsson::KeyHierarchies& body = bodies_.body(b);
      body.select(frame.key[b]);
      if (update_ == LarssonUpdate::hybrid) {
        body.active().update_hybrid(frame.positions[b]);
      } else {
        body.active().update_bottom_up(frame.positions[b]);
      }
    }
    bodies_.sort();
  }

  void closest_hits(std::span<const Ray> rays, std::span<Hit> hits) override {
    for (size_t i = 0; i < rays.size(); ++i) hits[i] = bodies_.closest_hit(rays[i]);
  }
  void any_hits(std::span<const Ray> rays, std::span<uint8_t> hit) override {
    for (size_t i = 0; i < rays.size(); ++i) hit[i] = bodies_.any_hit(rays[i]);
  }

  larsson::UpdateWork update_work() const override {
    return sum([this](const larsson::Hierarchy& h) {
      return update_ == LarssonUpdate::hybrid ? h.hybrid_work() : h.bottom_up_work();
    });
  }
  larsson::UpdateWork visit_work() const override {
    return sum([](const larsson::Hierarchy& h) { return h.visit_work(); });
  }

 private:
  template <class Work>
  larsson::UpdateWork sum(const Work& work) const {
    larsson::UpdateWork out;
    for (uint32_t b = 0; b < inputs_.size(); ++b) {
      if (!inputs_[b].moves) continue;
      const larsson::UpdateWork part = work(bodies_.body(b).active());
      out.vertices += part.vertices;
      out.boxes += part.boxes;
    }
    return out;
  }

  std::span<const BodyInput> inputs_;
  LarssonUpdate update_;
  larsson::Bodies bodies_;
};

// One object a key; only that of the nearest key is there.
class SinewEngine final : public TableEngine {
 public:
  Result<void> build(std::span<const BodyInput> bodies, UpdateMode mode) {
    inputs_ = bodies;
    for (const BodyInput& body : bodies) {
      first_object_.push_back(static_cast<ObjectId>(body_of_.size()));
      times_.push_back(key_times(body.key_shapes.size()));
      for (const std::vector<vec3>& shape : body.key_shapes) {
        const auto vertices = static_cast<uint32_t>(shape.size());
        const Motion motion =
            body.moves ? Motion(FreeMotion{vertices}) : Motion(RigidMotion{shape});
        Pose pose;
        pose.positions = shape;
        SINEW_TRY(const BodyId id, world_.add_body({body.triangles, motion, pose}));
        SINEW_TRY(const ObjectId object, world_.add_object(id));
        SINEW_CHECKED(world_.set_pose(object, pose));
        body_of_.push_back(static_cast<uint32_t>(first_object_.size() - 1));
      }
    }
    // Everything is made once, so that no memory is new to the frames that count.
    world_.set_update_mode(UpdateMode::full);
    world_.commit();
    world_.set_update_mode(mode);
    return {};
  }

  void begin_frame(const FrameInput& frame) override {
    for (uint32_t b = 0; b < inputs_.size(); ++b) {
      if (!inputs_[b].moves) continue;
      const uint32_t key = larsson::KeyHierarchies::nearest(times_[b], frame.key[b]);
      Pose pose;
      pose.positions = frame.positions[b];
      for (uint32_t k = 0; k < times_[b].size(); ++k) {
        world_.set_visible(first_object_[b] + k, k == key);
      }
      const auto posed = world_.set_pose(first_object_[b] + key, pose);
      SINEW_CHECK(posed);
    }
    world_.commit();
  }

  void closest_hits(std::span<const Ray> rays, std::span<Hit> hits) override {
    world_.closest_hits(rays, hits);
    for (Hit& hit : hits) {
      if (hit) hit.object = body_of_[hit.object];
    }
  }
  void any_hits(std::span<const Ray> rays, std::span<uint8_t> hit) override {
    world_.any_hits(rays, hit);
  }

 private:
  std::span<const BodyInput> inputs_;
  World world_;
  std::vector<ObjectId> first_object_;     // one a body; its keys' objects follow each other
  std::vector<std::vector<float>> times_;  // one a body
  std::vector<uint32_t> body_of_;          // one an object
};

}  // namespace

std::unique_ptr<TableEngine> make_larsson_engine(std::span<const BodyInput> bodies,
                                                 LarssonUpdate update,
                                                 const larsson::Config& config) {
  return std::make_unique<LarssonEngine>(bodies, update, config);
}

Result<std::unique_ptr<TableEngine>> make_sinew_engine(std::span<const BodyInput> bodies,
                                                       UpdateMode mode) {
  auto engine = std::make_unique<SinewEngine>();
  SINEW_CHECKED(engine->build(bodies, mode));
  return engine;
}

}  // namespace sinew::bench
