// Scene: everything a file holds, constant while frames are made. Right-handed, +Y up, metres and
// radians, as glTF 2.0. Times are in seconds.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sinew/math/affine.h"
#include "sinew/scene/clip.h"
#include "sinew/scene/image.h"
#include "sinew/scene/material.h"
#include "sinew/scene/mesh.h"
#include "sinew/svo/format.h"

namespace sinew {

enum class LightType : uint8_t { directional, point, spot };

// Shines from its node's origin along its node's -Z (KHR_lights_punctual).
struct Light {
  std::string name;
  LightType type = LightType::directional;
  vec3 color{1.0f};         // linear
  float intensity = 1.0f;   // directional: lux; point and spot: candela
  float range = 0.0f;       // metres; 0: no limit
  bool falloff = true;      // point and spot: weaker with the square of the distance; if false,
                            // `intensity` arrives at every distance (NFF, AFF)
  float inner_cone = 0.0f;  // radians, half angles, spot only
  float outer_cone = 0.785398163f;
};

// Looks along its node's -Z, +Y up.
struct Camera {
  std::string name;
  bool orthographic = false;
  float yfov = 0.8f;  // radians, full vertical angle
  float ymag = 1.0f;  // orthographic: half height, metres
  float znear = 0.01f;
};

struct Node {
  std::string name;
  int32_t parent = -1;  // an earlier node, or -1
  vec3 translation{0.0f};
  quat rotation = glm::identity<quat>();
  vec3 scale{1.0f};
  bool has_matrix = false;  // then `matrix` counts, not translation, rotation, scale
  Affine matrix = identity_affine();
  int32_t mesh = -1;
  int32_t octree = -1;  // at most one of mesh and octree
  int32_t skin = -1;
  int32_t camera = -1;
  int32_t light = -1;
  std::vector<float> weights;  // morph weights; empty: the mesh's defaults
  bool visible = true;         // false hides the whole subtree
};

struct Skin {
  std::string name;
  std::vector<uint32_t> joints;      // node indices
  std::vector<Affine> inverse_bind;  // one a joint
};

// One thing that can be hit: a node with a mesh. Hit::object indexes Scene::objects.
struct SceneObject {
  uint32_t node = 0;
  uint32_t mesh = 0;
  int32_t skin = -1;
};

// One voxel object in the pictures: a node with an octree.
struct SceneVoxels {
  uint32_t node = 0;
  uint32_t octree = 0;
  int32_t skin = -1;  // -1: the octree has no joints
};

// What rays see that leave the scene, and what light comes from everywhere.
struct Environment {
  vec3 zenith{0.30f, 0.36f, 0.44f};  // linear radiance straight up
  vec3 horizon{0.44f, 0.46f, 0.48f};
  vec3 nadir{0.18f, 0.17f, 0.16f};
  std::optional<vec3> ambient{};  // if set, radiance that lights diffuse surfaces from everywhere,
                                  // instead of what rays see
};

inline constexpr double kHighestFps = 1e6;

struct Scene {
  std::string name;
  std::vector<Mesh> meshes;
  std::vector<Svo> octrees;         // SvoCell::material indexes `materials`
  std::vector<Material> materials;  // at least one if there is a mesh or an octree
  std::vector<Image8> images;
  std::vector<Node> nodes;  // parents before children
  std::vector<Skin> skins;
  std::vector<Camera> cameras;
  std::vector<Light> lights;
  std::vector<Clip> clips;
  std::vector<SceneObject> objects;  // in node order
  std::vector<SceneVoxels> voxels;   // in node order
  Environment environment;
  int32_t default_frames = 0;         // > 0: how many frames the scene is meant to have
  double default_fps = 0.0;           // > 0: the frame rate it is meant for, at most kHighestFps
  std::vector<std::string> warnings;  // from loading: what is unsupported, corrected or ignored
};

struct SceneCounts {
  uint64_t triangles = 0;  // over objects, each instance counted
  uint64_t vertices = 0;   // over objects, each instance counted
  uint32_t joints = 0;     // over skins
  uint32_t morphs = 0;     // over meshes and octrees
  uint64_t voxels = 0;     // over voxel objects, each instance counted
};
SceneCounts count(const Scene& scene);

// Fills objects and voxels from nodes; call after nodes, meshes and octrees are complete.
void list_objects(Scene& scene);

// Every invariant of the scene and its meshes. Empty text if all hold.
std::string validate(const Scene& scene);

}  // namespace sinew
