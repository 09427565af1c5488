// Update mode `automatic`: which of full, hybrid and lazy an object gets, from the share of its
// treelets that rays reached in its last frame.
#include "sinew/world/world_impl.h"

namespace sinew {
namespace {

// Where an object changes from lazy to full and back; apart, so that it does not go to and fro.
constexpr float kMostlyReached = 0.75f, kPartlyReached = 0.55f;

// A full update says nothing about what rays reach, so every so often one frame is tried without.
constexpr uint32_t kFramesBetweenTrials = 32;

}  // namespace

UpdateMode World::Impl::choose(ObjectId id, const PosedObject& last, uint64_t rays) {
  Object& object = objects[id];
  const Body& body = bodies[object.body];
  const UpdateMode thrifty = body.derivable ? UpdateMode::lazy : UpdateMode::hybrid;
  if (mode != UpdateMode::automatic) {
    return mode == UpdateMode::lazy ? thrifty : mode;
  }
  UpdateChoice& choice = object.choice;
  ++object.frames;
  if (!last.shaped || (last.mode != UpdateMode::full && rays == 0)) {
    if (!last.shaped) choice = {thrifty, 0.0f, "its first frame"};
    return choice.mode;
  }
  if (last.mode == UpdateMode::full) {
    if (object.frames < kFramesBetweenTrials) return choice.mode;
    object.frames = 0;
    choice = {thrifty, choice.reached, "a trial after many full updates"};
    return choice.mode;
  }
  const auto treelets = static_cast<float>(body.layout.treelets.size());
  choice.reached = static_cast<float>(last.visited.made.load(std::memory_order_relaxed)) / treelets;
  const bool was_full = object.frames == 1 && choice.mode != UpdateMode::full;
  const bool full = choice.reached > (was_full ? kPartlyReached : kMostlyReached);
  choice.mode = full ? UpdateMode::full : thrifty;
  choice.why = full ? "rays reached most of it" : "rays reached a part of it";
  if (full) object.frames = 0;
  return choice.mode;
}

}  // namespace sinew
