// Which frames of an animation stand for all of it when one tree is built for them.
// Based on: J. Bittner, D. Meister, "T-SAH", 2015 (T), sections 4 and 6.1 (uniform frames); L.
// Kaufman, P. Rousseeuw, "Finding Groups in Data", 1990, chapter 2 (k-medoids: BUILD and SWAP).
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "sinew/bvh/frames/frames.h"

namespace sinew {

// An animation as seen by a builder: frames, and the boxes of all primitives in any of them.
// boxes(frame, out) must be callable from several threads at once; it may leave boxes that are not
// finite, and must not throw.
struct AnimatedBoxes {
  uint32_t primitive_count = 0;
  std::vector<double> times;    // seconds, or whatever the caller likes; rising along one clip
  std::vector<double> weights;  // of the frames, >= 0; empty: by the time around each
  std::function<void(uint32_t frame, std::span<Box> out)> boxes;

  uint32_t frame_count() const { return static_cast<uint32_t>(times.size()); }
};

// Pose space: the frames of all clips of a character, one clip after the other. A clip counts by
// its length in time, or by the sum of its weights where it has them; a clip of no length, such as
// a single pose, counts as much a frame as the others do on average. Times stay as they are, so
// they do not rise from clip to clip and only choose_frames() makes sense of the whole. All clips
// must have the same primitives.
AnimatedBoxes join_clips(std::vector<AnimatedBoxes> clips);

// What share of [first, last] every frame of it stands for; sum 1. By half the time to both
// neighbours, or the given weights; all the same if these say nothing.
std::vector<double> frame_weights(const AnimatedBoxes& animation, uint32_t first, uint32_t last);

// The weights of frames (the first of them has number `first`), each given to the nearest of the
// `chosen` ones (rising); halfway between two, half to each.
std::vector<double> weights_by_nearness(std::span<const uint32_t> chosen, uint32_t first,
                                        std::span<const double> weights);

enum class FrameChoice : uint8_t {
  uniform,  // T's: evenly spread over the frames, first and last included
  medoids,  // the frames whose own trees serve all other frames best
};

// `count` frames of [first, last], rising, and how much each stands for (sum 1): for uniform frames
// the weights of the frames nearest to it, for medoids of those that its tree serves best.
// Frames that add nothing are left out: of equal frames one is taken, and medoids stop where
// another one would lower the average cost by less than a thousandth. Medoids avoid frames with
// boxes that are not finite. At least one frame; needs first <= last.
//
// The distance of medoids: frames are far from each other if a good tree for one is a bad one for
// the other. So a small tree is built in every frame, over a fixed random subset of the primitives,
// and its cost is measured in every other frame. This is what the frames are chosen for, so it
// needs no scale: a body that moves, grows, or turns as a whole, and clothes that wave without
// coming near other parts, are near to themselves. Of more than 96 frames, 96 are looked at.
std::vector<uint32_t> choose_frames(const AnimatedBoxes& animation, uint32_t first, uint32_t last,
                                    uint32_t count, FrameChoice choice,
                                    std::vector<double>* weights = nullptr);

// The boxes of those frames, all finite (see make_frame_boxes).
FrameBoxes sample_frames(const AnimatedBoxes& animation, std::span<const uint32_t> frames,
                         std::span<const double> weights);

// The fixed random subset: one primitive of each of `count` equal runs, rising; all of them if
// there are no more. The same for the same arguments.
std::vector<uint32_t> sample_primitives(uint32_t primitive_count, uint32_t count);

// Boxes of some primitives in some frames, with equal weights: a small model of the animation.
FrameBoxes sample_boxes(const AnimatedBoxes& animation, std::span<const uint32_t> frames,
                        std::span<const uint32_t> primitives,
                        std::vector<uint32_t>* finite_boxes = nullptr);

// What a tree really costs: in frames that it was not made for.
struct HeldOutCost {
  std::vector<uint32_t> frames;
  std::vector<double> costs;  // C_i of each
  double mean = 0.0;          // by the frames' weights; 0 if there are none
  double max = 0.0;
};

// Over at most `most` frames of [first, last], evenly spread, without the representatives.
// `representatives` (rising) and their boxes: where a box is not finite, the nearest one's stands.
HeldOutCost held_out_cost(const Tree& tree, const AnimatedBoxes& animation, uint32_t first,
                          uint32_t last, std::span<const uint32_t> representatives,
                          const FrameBoxes& representative_boxes, const CostModel& model = {},
                          uint32_t most = 50);

// The boxes of one frame; where they are not finite, those of the nearest representative.
std::vector<Box> repaired_frame(const AnimatedBoxes& animation, uint32_t frame,
                                std::span<const uint32_t> representatives,
                                const FrameBoxes& representative_boxes);

// `count` of the numbers [first, last], evenly spread, first and last included; all of them if
// there are no more. The middle if count is 1.
std::vector<uint32_t> evenly_spread(uint32_t first, uint32_t last, uint32_t count);

}  // namespace sinew
