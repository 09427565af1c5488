// First visits: a body whose upper tree, and treelets whose insides, are made when the first ray
// comes, by the thread whose ray it is. Nobody waits: whoever finds a place being made looks
// through it for its own ray without storing anything.
//
//   links[t]:  kUnmade --claim (compare-and-swap)--> kBeingMade --publish (release)--> child word
//
// Every treelet has its own place in the Bvh8, so a claim needs no memory and the bits do not
// depend on who makes it. Links are reset when the pose changes.
#pragma once

#include <atomic>
#include <cstdint>

#include "sinew/bvh/update/update.h"
#include "sinew/bvh/update/update_kernels.h"
#include "sinew/bvh/wide.h"
#include "sinew/motion/clusters.h"
#include "sinew/motion/motion.h"

namespace sinew {

// Values of Bvh8::links beside child words.
inline constexpr uint32_t kUnmade = 0xffffffffu;
inline constexpr uint32_t kBeingMade = 0xfffffffeu;

// A body in a pose. Constant while rays are traced, but for what the atomics guard.
struct VisitedBody {
  const Bvh8Layout* layout = nullptr;
  Bvh8* bvh = nullptr;
  const Motion* motion = nullptr;
  const Pose* pose = nullptr;
  const vec3* positions = nullptr;  // of all vertices, where they are known; else from the motion
  const ClusterBounds* clusters = nullptr;
  std::atomic<uint32_t> upper = kUnmade;  // kUnmade, kBeingMade, or the root's child word
  std::atomic<uint32_t> made = 0;         // treelets made in this pose, by rays
  WorkTime upper_work;                    // what the upper tree took
  WorkTime make_work;                     // what timed_treelets() took
};

// Every eighth treelet that rays make is timed; not the first ones, which find all caches cold.
constexpr uint32_t kTimedEvery = 8, kTimedFirst = 5;
constexpr bool is_timed(uint32_t made_before) {
  return made_before % kTimedEvery == kTimedFirst;
}
inline uint32_t timed_treelets(const VisitedBody& body) {
  const uint32_t made = body.made.load(std::memory_order_relaxed);
  return (made + kTimedEvery - kTimedFirst - 1) / kTimedEvery;
}

inline bool is_ready(const VisitedBody& body) {
  return body.upper.load(std::memory_order_acquire) < kBeingMade;
}

// Makes the upper tree, unless another thread is at it: then returns false.
bool visit_upper(VisitedBody& body, Threads threads = Threads::one);

// Makes the treelet and returns its root's child word; kNoChild if another thread is at it.
uint32_t visit_treelet(VisitedBody& body, uint32_t treelet);

// A treelet's box, and its packets in a copy of the caller's, without anything being stored.
using TreeletPackets = std::array<TrianglePacket, kMaxTreeletTriangles>;
Box look_at_box(const VisitedBody& body, uint32_t treelet);
void look_at_packets(const VisitedBody& body, uint32_t treelet, TreeletPackets& out);

}  // namespace sinew
