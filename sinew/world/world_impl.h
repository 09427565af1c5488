// What a World holds. Internal to sinew/world.
#pragma once

#include <span>
#include <vector>

#include "sinew/bvh/wide.h"
#include "sinew/world/world.h"

namespace sinew {

struct Body {
  std::span<const uvec3> triangles;
  Motion motion;
  Bvh8Layout layout;
  Bvh8 bvh;  // of rigid bodies, shared by all their objects
  bool deforms = false;
};

struct Object {
  BodyId body = 0;
  ObjectDesc desc;
  bool alive = true;
  bool dirty = false;  // its pose counts from the next commit
  Pose pose;           // spans are valid only while dirty

  // As of the last commit:
  bool present = false;
  bool in_place = true;  // placement is the identity
  Affine placement = identity_affine();
  Affine to_object = identity_affine();
  Box box;   // world space
  Bvh8 bvh;  // of deforming bodies
  std::vector<vec3> positions;
};

struct World::Impl {
  std::vector<Body> bodies;
  std::vector<Object> objects;
  UpdateStats stats;

  // Rebuilt by every commit:
  std::vector<Instance> instances;
  std::vector<Box> boxes;  // one an instance
  std::vector<Node8> top;
  Box box;
  std::vector<ObjectId> moved;

  // Of prepared worlds:
  const Scene* scene = nullptr;
  int clip = kRestPose;
  ScenePose pose;

  Object& object(ObjectId id);
  std::span<const vec3> positions_of(const Object& object) const;
  void update_object(Object& object);
  Box padded(const Object& object) const;
  void build_instances();
  SceneView view() const;
};

}  // namespace sinew
