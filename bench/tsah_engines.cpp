#include "bench/tsah_engines.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "sinew/base/check.h"
#include "sinew/bvh/builders/build.h"
#include "sinew/bvh/bvh.h"

namespace sinew::bench {
namespace {

// Rebuilds of positions that were checked before cannot fail.
Bvh must(Result<Bvh> built) {
  SINEW_CHECK(built);
  return std::move(*built);
}

class RefitEngine final : public FrameEngine {
 public:
  explicit RefitEngine(std::string name) : FrameEngine(std::move(name)) {}

  Result<void> build(const MethodTrees& method, const FlatScene& scene) {
    for (const TreePart& part : method.parts) {
      SINEW_TRY(Bvh bvh, sinew::build(scene.positions, scene.triangles, part.traced, part.areas));
      begins_.push_back(part.begin);
      bvhs_.push_back(std::move(bvh));
    }
    return {};
  }

  void prepare(const FlatScene& frame, double u) override {
    frame_ = &frame;
    current_ = 0;
    while (current_ + 1 < begins_.size() && begins_[current_ + 1] <= u) ++current_;
  }
  void update() override { SINEW_CHECK(bvhs_[current_].update_borrowed(frame_->positions)); }
  std::vector<Call> calls(TriangleTest test) const override {
    return our_calls(bvhs_[current_], test);
  }

 private:
  const FlatScene* frame_ = nullptr;
  size_t current_ = 0;
  std::vector<double> begins_;
  std::vector<Bvh> bvhs_;
};

class RebuildEngine final : public FrameEngine {
 public:
  RebuildEngine(std::string name, Rebuild how, const FlatScene& scene)
      : FrameEngine(std::move(name)), how_(how), boxes_(scene.triangles.size()) {}

  void prepare(const FlatScene& frame, double) override {
    frame_ = &frame;
    if (how_ != Rebuild::best) return;
    triangle_boxes(frame.positions, frame.triangles, boxes_);
    const FrameBoxes one = make_frame_boxes({boxes_});
    const TreePart part = finish(best_tree_of_frame(one), one, 0, 0.0);
    bvh_ = must(build(frame.positions, frame.triangles, part.traced, part.areas));
  }
  void update() override {
    if (how_ == Rebuild::best) return;
    if (how_ == Rebuild::binned) {
      bvh_ = must(build(frame_->positions, frame_->triangles));
      return;
    }
    triangle_boxes(frame_->positions, frame_->triangles, boxes_);
    const HlbvhSplit split = how_ == Rebuild::hlbvh_sah ? HlbvhSplit::sah : HlbvhSplit::median;
    bvh_ = must(build(frame_->positions, frame_->triangles, build_hlbvh(boxes_, split)));
  }
  std::vector<Call> calls(TriangleTest test) const override { return our_calls(*bvh_, test); }

 private:
  Rebuild how_;
  const FlatScene* frame_ = nullptr;
  std::vector<Box> boxes_;
  std::optional<Bvh> bvh_;
};

class EmbreeEngine final : public FrameEngine {
 public:
  EmbreeEngine(std::string name, EmbreeMode mode, TriangleTest test, const FlatScene& scene)
      : FrameEngine(std::move(name)), scene_({mode, test == TriangleTest::robust}) {
    scene_.add_mesh(scene.positions, scene.triangles, EmbreeMotion::deforms);
    scene_.commit();
  }

  // The vertices are put where Embree reads them: whoever moves them could write them there.
  void prepare(const FlatScene& frame, double) override {
    std::ranges::copy(frame.positions, scene_.vertices().begin());
  }
  void update() override {
    (void)scene_.vertices();  // asking says that they change
    scene_.commit();
  }
  std::vector<Call> calls(TriangleTest) const override { return embree_calls(scene_); }

 private:
  EmbreeScene scene_;
};

const char* name_of(Rebuild how) {
  constexpr const char* kNames[] = {"SAH-rebuild", "binned SAH rebuild", "HLBVH-med", "HLBVH-SAH"};
  return kNames[static_cast<size_t>(how)];
}

}  // namespace

Result<std::unique_ptr<FrameEngine>> make_refit_engine(const MethodTrees& method,
                                                       const FlatScene& scene) {
  auto engine = std::make_unique<RefitEngine>(method.name);
  SINEW_CHECKED(engine->build(method, scene));
  return engine;
}

std::unique_ptr<FrameEngine> make_rebuild_engine(Rebuild how, const FlatScene& scene) {
  return std::make_unique<RebuildEngine>(name_of(how), how, scene);
}

std::unique_ptr<FrameEngine> make_embree_engine(std::string name, EmbreeMode mode,
                                                TriangleTest test, const FlatScene& scene) {
  return std::make_unique<EmbreeEngine>(std::move(name), mode, test, scene);
}

}  // namespace sinew::bench
