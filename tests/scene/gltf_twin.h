// A second reader and evaluator of animated glTF files, slow and in double: it goes from the file's
// own bytes to world positions, sharing nothing with the library. It trusts the file, and knows the
// features that the test files use (triangle lists, no sparse accessors).
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace sinew::test {

class GltfTwin {
 public:
  explicit GltfTwin(const std::string& path);

  static constexpr int kRest = -1;  // an animation index: the file's rest pose
  int animation_count() const;

  // Objects are the nodes with meshes, depth first from the scene's roots.
  size_t object_count() const { return objects_.size(); }
  std::string object_name(size_t object) const;

  // The last key of the animation, in seconds.
  double animation_end(int animation) const;

  // For each object the corners of its triangles in the world, three a triangle, in the file's
  // order.
  std::vector<std::vector<glm::dvec3>> corners(int animation, double time) const;

 private:
  using Json = nlohmann::json;
  using Numbers = std::vector<double>;
  struct Frame;  // animated values and world matrices at one time

  void read_file(const std::string& path);
  void visit(size_t node, size_t parent);
  const Numbers& accessor(size_t index) const;
  Numbers decode(const Json& accessor) const;
  Numbers sample(const Json& sampler, double time, bool rotation) const;
  Frame frame(int animation, double time) const;
  glm::dmat4 local(size_t node, const Frame& frame) const;
  std::vector<glm::dvec3> primitive_points(size_t node, const Json& primitive,
                                           const Frame& frame) const;

  Json json_;
  std::vector<std::string> buffers_;
  std::vector<size_t> parent_;                 // one a node; kNoParent for roots
  std::vector<size_t> order_;                  // nodes of the scene, depth first
  std::vector<size_t> objects_;                // those with meshes
  mutable std::map<size_t, Numbers> decoded_;  // accessors read so far
};

}  // namespace sinew::test
