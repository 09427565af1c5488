// A picture that gets better from frame to frame while nothing moves. The first frame of a view is
// what render_frame() makes of it, sub-sampled and cut short as the settings say; those after it
// add passes over all pixels, complete with all their rays, as far as the time budget lets them
// (one pass a frame if there is none). The mean tends to the picture without either limit.
#pragma once

#include <vector>

#include "sinew/render/frame.h"

namespace sinew {

class Refinement {
 public:
  // As render_frame(). Starts anew if the pose, the camera or the settings (but for the time
  // budget) differ from the last call's in any bit, or scene or world are other objects. Begins to
  // sum anew where details of octrees larger than memory have come (svo/file/stream.h).
  FrameStats draw(const World& world, const Scene& scene, const ScenePose& pose,
                  const CameraView& camera, const RenderSettings& settings, RenderScratch& scratch,
                  Image& out);

  // For what draw() cannot see: the scene or the world was given other contents.
  void restart() { view_.scene = nullptr; }

  // Samples that every pixel has had at least, not counting a first picture that was not complete.
  uint32_t samples() const { return passes_ * view_.settings.samples; }

 private:
  // Everything that a picture depends on.
  struct View {
    const Scene* scene = nullptr;  // null: there has been none
    const World* world = nullptr;
    CameraView camera;
    RenderSettings settings;  // without a time budget
    std::vector<Affine> nodes, joints;
    std::vector<uint8_t> visible;
    std::vector<float> weights;
    std::vector<vec3> free;
    std::vector<Pose> objects, voxels;  // for their keys; the spans are not compared

    bool shows(const World& world, const Scene& scene, const ScenePose& pose,
               const CameraView& camera, const RenderSettings& settings) const;
    void keep(const World& world, const Scene& scene, const ScenePose& pose,
              const CameraView& camera, const RenderSettings& settings);
  };

  FrameStats begin(const World& world, const Scene& scene, const ScenePose& pose,
                   const RenderSettings& settings, RenderScratch& scratch, Image& out);
  void show(Image& out) const;
  void forget_coarser(const Scene& scene);

  View view_;
  Image first_;  // shown where no pass has been yet
  Image sum_;    // of all samples since
  uint32_t passes_ = 0;
  uint32_t tile_ = 0;          // where the pass that has begun goes on
  uint64_t paging_epoch_ = 0;  // what the sum was drawn with
  uint32_t restarts_ = 0;      // of the sum of this view
};

}  // namespace sinew
