// What stands in L's tables: L's own updates and ours behind one face, over the same bodies in
// world space. Calls take whole sets of rays, so that asking costs nobody anything.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/bvh/larsson/larsson.h"
#include "sinew/bvh/update/update.h"
#include "sinew/math/ray.h"
#include "sinew/math/vec.h"

namespace sinew::bench {

// One body. It gets a hierarchy for each of its key shapes.
struct BodyInput {
  std::span<const uvec3> triangles;
  std::vector<std::vector<vec3>> key_shapes;  // world; key-major, at least one
  bool moves = false;                         // else its only key shape is where it stays
};

// Where the bodies are in one frame: views, one entry a body.
struct FrameInput {
  std::span<const std::vector<vec3>> positions;  // world
  std::span<const float> key;                    // the nearest key's hierarchy is used
};

class TableEngine {
 public:
  virtual ~TableEngine() = default;
  virtual void begin_frame(const FrameInput& frame) = 0;
  // Hit::object is the number of the body.
  virtual void closest_hits(std::span<const Ray> rays, std::span<Hit> hits) = 0;
  virtual void any_hits(std::span<const Ray> rays, std::span<uint8_t> hit) = 0;

  // What updates and then queries have touched in this frame; nothing if the engine does not count.
  virtual larsson::UpdateWork update_work() const { return {}; }
  virtual larsson::UpdateWork visit_work() const { return {}; }
};

enum class LarssonUpdate : uint8_t { bottom_up, hybrid };

// The bodies must outlive the engines.
std::unique_ptr<TableEngine> make_larsson_engine(std::span<const BodyInput> bodies,
                                                 LarssonUpdate update,
                                                 const larsson::Config& config);
Result<std::unique_ptr<TableEngine>> make_sinew_engine(std::span<const BodyInput> bodies,
                                                       UpdateMode mode);

}  // namespace sinew::bench
