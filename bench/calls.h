// The calls by which rays can be traced, one row a call and engine, so that all are measured and
// the best of an engine can be taken. A call works in the calling thread.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "bench/embree_scene.h"
#include "sinew/bvh/bvh.h"
#include "sinew/math/ray.h"

namespace sinew::bench {

enum class TriangleTest : uint8_t { robust, fast };  // fast: no promise about shared edges
const char* name_of(TriangleTest test);

struct Call {
  std::string name;  // begins with the engine's: "sinew" or "embree"
  std::function<void(std::span<const Ray>, std::span<Hit>)> closest;
  std::function<void(std::span<const Ray>, std::span<uint8_t>)> any;
};

inline constexpr const char* kOurSingle = "sinew 1";
inline constexpr const char* kOurGroups = "sinew groups";
inline constexpr const char* kEmbreeSingle = "embree 1";

std::vector<Call> our_calls(const Bvh& bvh, TriangleTest test);
// `scene` is made with or without ROBUST, as the test says.
std::vector<Call> embree_calls(const EmbreeScene& scene);

// All rays by one call, in chunks from all threads; chunk boundaries are multiples of 16 rays.
void trace_closest(const Call& call, std::span<const Ray> rays, std::span<Hit> hits);
void trace_any(const Call& call, std::span<const Ray> rays, std::span<uint8_t> hit);

}  // namespace sinew::bench
