// A body's triangles over the clips of its scene, as tree builders see them.
#pragma once

#include <cstdint>

#include "sinew/bvh/frames/frame_choice.h"
#include "sinew/motion/motion.h"
#include "sinew/scene/sample.h"
#include "sinew/world/scene_bodies.h"

namespace sinew {

// The object whose pose shows the body in frame number `frame`: they take turns, so that objects
// that move differently all count. The scene's objects where the pose has them present; -1 if none
// is.
int32_t object_in_frame(const SceneBody& body, const ScenePose& pose, uint32_t frame);

// At most `most_frames` frames (at least 2) of a clip, at its frame rate or fewer, its first and
// last time included; one frame of a clip without length, of kRestPose, and of what does not
// deform. Boxes are in the body's own space, and empty in frames that show none of its objects. The
// scene and the body must outlive what is returned.
AnimatedBoxes body_animation(const Scene& scene, const SceneBody& body, int clip,
                             uint32_t most_frames);

}  // namespace sinew
