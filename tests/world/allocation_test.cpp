// Frames that are like the ones before need no new memory. Sanitizers bring their own operator new.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SINEW_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || \
    __has_feature(memory_sanitizer)
#define SINEW_SANITIZED 1
#endif
#endif

#ifndef SINEW_SANITIZED
#include <gtest/gtest.h>

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

#include "sinew/math/random.h"
#include "sinew/scene/study.h"
#include "sinew/world/world.h"

namespace {

std::atomic<bool> counting = false;
std::atomic<int> allocations = 0;

void* allocate(std::size_t size, std::size_t alignment) {
  if (counting.load(std::memory_order_relaxed)) ++allocations;
  const std::size_t rounded = (size + alignment - 1) / alignment * alignment;
  void* const memory = std::aligned_alloc(alignment, rounded > 0 ? rounded : alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

// GCC takes free() in an inlined operator delete for a mistake.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"
#endif

void* operator new(std::size_t size) {
  return allocate(size, alignof(std::max_align_t));
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

namespace sinew {
namespace {

struct Queries {
  std::vector<Ray> rays = std::vector<Ray>(500);
  std::vector<Hit> hits = std::vector<Hit>(500), all;
  std::vector<uint8_t> any = std::vector<uint8_t>(500);
  std::vector<TriangleId> inside;

  explicit Queries(const Box& box) {
    Random random(9);
    for (Ray& ray : rays) {
      ray.origin = box.center() + length(box.extent()) * random.direction();
      ray.direction = box.center() + random.uniform3(-0.3f, 0.3f) * box.extent() - ray.origin;
    }
  }
  void ask(const World& world) {
    world.closest_hits(rays, hits);
    world.any_hits(rays, any);
    world.all_hits(rays[0], all);
    world.nearest_point(rays[0].origin);
    world.triangles_in_box({rays[0].origin, world.box().center()}, inside);
  }
};

TEST(Allocation, FramesLikeTheOnesBeforeNeedNone) {
  for (const char* name : {"creature,triangles=8000", "bodies,subdivisions=3,motion=free"}) {
    const Scene scene = *make_study_scene(name);
    for (const TopTree top : {TopTree::objects, TopTree::treelets}) {
      for (const UpdateMode mode : {UpdateMode::full, UpdateMode::hybrid, UpdateMode::lazy}) {
        World world = *prepare(scene, {.update = mode, .top_tree = top});
        Queries queries(world.box());
        int counts[3];  // the first shows that they are counted
        for (int& count : counts) {
          allocations = 0;
          for (const double seconds : {0.1, 0.4, 0.7}) {
            counting = true;
            const bool posed = world.set_time(seconds).has_value();
            queries.ask(world);
            const bool staged = world.stage_time(seconds + 0.1).has_value();
            world.flip();
            queries.ask(world);
            counting = false;
            ASSERT_TRUE(posed && staged);
          }
          count = allocations;
        }
        EXPECT_GT(counts[0], 0) << name << ", " << name_of(mode);
        EXPECT_EQ(counts[2], 0) << name << ", " << name_of(mode);
      }
    }
  }
}

}  // namespace
}  // namespace sinew
#endif
