// Those who take part in table 2 of `sinew bench tsah`: ours with trees of all methods, and
// Embree's modes, over the same moving mesh.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bench/calls.h"
#include "bench/embree_scene.h"
#include "bench/tsah_methods.h"
#include "bench/tsah_scenes.h"
#include "sinew/base/error.h"

namespace sinew::bench {

class FrameEngine {
 public:
  explicit FrameEngine(std::string name) : name_(std::move(name)) {}
  virtual ~FrameEngine() = default;

  const std::string& name() const { return name_; }
  // Not timed: gives it the vertices of a frame, which stay as they are until the next one.
  virtual void prepare(const FlatScene& frame, double u) = 0;
  // Timed: all that must be done before rays come. May be repeated.
  virtual void update() = 0;
  // Its calls for the frame updated last, always in the same order.
  virtual std::vector<Call> calls(TriangleTest test) const = 0;

 private:
  std::string name_;
};

// A tree, or several that follow each other, refit to every frame in our update mode `automatic`.
Result<std::unique_ptr<FrameEngine>> make_refit_engine(const MethodTrees& method,
                                                       const FlatScene& scene);

enum class Rebuild : uint8_t {
  best,       // T's SAH-rebuild: the update is not counted
  binned,     // our own default builder
  hlbvh_med,  // T's opponents
  hlbvh_sah,
};
std::unique_ptr<FrameEngine> make_rebuild_engine(Rebuild how, const FlatScene& scene);

// `scene`: the first frame that it is built for. Its test is that of the calls asked for later.
std::unique_ptr<FrameEngine> make_embree_engine(std::string name, EmbreeMode mode,
                                                TriangleTest test, const FlatScene& scene);

}  // namespace sinew::bench
