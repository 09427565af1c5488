// Walks through an AFF file and those it includes, and gathers what they say.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "sinew/io/aff/animated.h"
#include "sinew/io/aff/keyframes.h"
#include "sinew/io/aff/material.h"
#include "sinew/io/aff/mesh.h"
#include "sinew/io/aff/text.h"
#include "sinew/scene/scene.h"

namespace sinew::aff {

// What is rigid and moves together: one node with a mesh, and one for each set of animated
// triangles.
struct Object {
  std::string name;
  int32_t frame = -1;        // the node under which it hangs, or -1
  glm::dmat4 to_frame{1.0};  // its space -> the frame's
  MeshBuilder mesh;          // in its own space, and so are the following
  std::vector<AnimatedTriangles> animated;
  std::map<std::vector<float>, size_t> by_times;  // index into `animated`
};

// A node that the keyframes of this name move.
struct NamedNode {
  std::string name;
  uint32_t node = 0;
};

Affine affine(const glm::dmat4& m);

struct Timing {
  double start = 0.0;  // seconds
  double end = 0.0;
  int32_t frames = 0;  // 0: the files do not say
};

struct Content {
  std::vector<Object> objects;
  std::vector<NamedNode> named_nodes;
  std::map<std::string, Keyframes> keyframes;  // by name
  Timing timing;
  uint64_t bytes = 0;  // that reading took, about
};

// Adds nodes, cameras, lights, materials, images and warnings to the scene; meshes, objects and
// clips are the caller's matter.
class Reader {
 public:
  Reader(Scene& scene, const std::filesystem::path& path, const LoadOptions& options);

  // To be called once.
  Result<Content> run();

 private:
  // What a pair of braces or a file encloses.
  struct Scope {
    glm::dmat4 to_object{1.0};
    size_t object = 0;        // index into Content::objects
    int32_t frame = -1;       // node of the animated transform around it
    bool in_include = false;  // in a file that was included below that transform
  };

  // `file` is canonical, `name` what errors call it and must live while the file is read.
  Result<const std::string*> text_of(const std::string& file, const std::string& name);
  Result<void> read_file(const std::string& file, const std::string& name);
  Result<void> read_statements(Words& words);
  Result<bool> read_structure(std::string_view statement, Words& words);
  Result<bool> read_setting(std::string_view statement, Words& words);
  Result<bool> read_primitive(std::string_view statement, Words& words);

  Result<void> read_include(Words& words);
  Result<void> read_static_transform(Words& words);
  Result<void> read_animated_transform(Words& words);
  Result<void> read_keys(Words& words);

  Result<void> read_view(Words& words);
  Result<void> read_light(Words& words, bool animated);
  Result<void> read_fill(Words& words, bool extended);
  Result<void> read_background(Words& words);
  Result<void> read_timing(Words& words);

  Result<void> read_polygon(Words& words, bool patch);
  Result<void> read_sphere(Words& words);
  Result<void> read_cone(Words& words);
  Result<void> read_textured_triangle(Words& words, bool patch);
  Result<void> read_animated_triangle(Words& words);
  Result<void> read_mesh(Words& words);

  Result<uint32_t> use_material(const std::string& texture, const Words& words);
  Result<void> add(Primitive primitive, const std::string& texture, const Words& words);
  Result<void> add(const Tessellation& shape, const Words& words);
  Result<void> open_object(std::string name, int32_t frame, const glm::dmat4& to_frame,
                           const Words& words);
  // The node whose space is the one of the statements here, -1 if that is the world's.
  Result<int32_t> node_here(const Words& words);
  Result<uint32_t> add_node(Node node, const Words& words);
  Result<void> charge(uint64_t bytes, const Words& words);
  uint64_t memory_left() const;
  glm::dmat4 to_frame() const;

  Scene& scene_;
  const std::string path_;              // of the top file, as errors name it
  const std::filesystem::path folder_;  // canonical
  const LoadOptions options_;
  Content content_;
  Materials materials_;
  std::map<std::string, std::string> texts_;  // by canonical path
  std::vector<std::string> including_;        // canonical, those being read, outermost first
  std::vector<Scope> scopes_;                 // innermost last
  int64_t detail_;                            // included files of higher levels are left out
  vec3 ambient_light_{1.0f};
  uint64_t bytes_ = 0;       // taken so far
  uint64_t text_bytes_ = 0;  // read through so far; a file counts each time
  uint32_t includes_ = 0;
};

}  // namespace sinew::aff
