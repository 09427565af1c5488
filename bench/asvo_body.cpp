#include "bench/asvo_body.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/copies.h"
#include "bench/measure.h"
#include "sinew/io/load.h"
#include "sinew/render/voxels/voxel_looks.h"
#include "sinew/svo/make/rims.h"

namespace sinew::bench {
namespace {

constexpr float kYfov = 0.6f;

// Where each skin's joints begin in the octree's.
std::vector<uint32_t> first_joints(const Scene& scene) {
  std::vector<uint32_t> out{0};
  for (const Skin& skin : scene.skins) {
    out.push_back(out.back() + static_cast<uint32_t>(skin.joints.size()));
  }
  return out;
}

void add_surface(const Mesh& mesh, uint32_t first_joint, bool skinned, AsvoBody& body) {
  const auto first = static_cast<uint32_t>(body.rest.size());
  body.rest.insert(body.rest.end(), mesh.positions.begin(), mesh.positions.end());
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    body.faces.push_back(mesh.triangles[t] + first);
    body.materials.push_back(static_cast<uint16_t>(mesh.material_of(t)));
  }
  if (!skinned) return;
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    for (uint32_t k = 0; k < body.influences; ++k) {
      const bool used = k < mesh.influences;
      body.joints.push_back(
          used ? static_cast<uint16_t>(mesh.joints[v * mesh.influences + k] + first_joint)
               : uint16_t{0});
      body.weights.push_back(used ? mesh.weights[v * mesh.influences + k] : 0.0f);
    }
  }
}

// Leaves only skinned objects in the scene, and takes their surfaces.
void take_surface(bool turns, AsvoBody& body) {
  Scene& scene = body.triangles;
  for (const SceneObject& object : scene.objects) {
    const Mesh& mesh = scene.meshes[object.mesh];
    if (object.skin < 0 || !mesh.skinnable()) {
      scene.nodes[object.node].mesh = -1;
    } else if (!turns) {
      body.influences = std::max(body.influences, mesh.influences);
    }
  }
  list_objects(scene);
  const std::vector<uint32_t> first = first_joints(scene);
  for (const SceneObject& object : scene.objects) {
    add_surface(scene.meshes[object.mesh], first[static_cast<size_t>(object.skin)], !turns, body);
  }
  body.joint_count = turns ? 0 : first.back();
}

// The same scene with one skin, of all joints, and one octree.
void make_voxel_scene(AsvoBody& body) {
  Scene& scene = body.voxels;
  scene = body.triangles;
  scene.meshes.clear();
  for (Node& node : scene.nodes) {
    if (node.mesh < 0) continue;
    node.mesh = -1;
    node.skin = -1;
  }
  Skin all;
  for (const Skin& skin : scene.skins) {
    all.joints.insert(all.joints.end(), skin.joints.begin(), skin.joints.end());
    all.inverse_bind.insert(all.inverse_bind.end(), skin.inverse_bind.begin(),
                            skin.inverse_bind.end());
  }
  Node node;
  node.name = "voxels";
  node.octree = 0;
  node.skin = body.turns ? -1 : 0;
  scene.nodes.push_back(std::move(node));
  scene.skins.assign(1, std::move(all));
  scene.octrees.resize(1);
}

}  // namespace

// Looks of the body's surface: those of the meshes that it is made of.
class BodyLooks {
 public:
  BodyLooks(const Scene& scene, float voxel) : textures_(scene) {
    uint32_t first = 0;
    for (const SceneObject& object : scene.objects) {
      textures_.prepare(scene.meshes[object.mesh], voxel);
    }
    for (const SceneObject& object : scene.objects) {
      const Mesh& mesh = scene.meshes[object.mesh];
      first_.push_back(first);
      looks_.emplace_back(scene, mesh, textures_);
      first += static_cast<uint32_t>(mesh.triangles.size());
    }
  }
  BodyLooks(const BodyLooks&) = delete;
  BodyLooks& operator=(const BodyLooks&) = delete;

  void operator()(const SurfaceBatch& batch) const {
    const auto after = std::ranges::upper_bound(first_, batch.triangle);
    const auto mesh = static_cast<size_t>(after - first_.begin()) - 1;
    SurfaceBatch own = batch;
    own.triangle -= first_[mesh];
    looks_[mesh](own);
  }

 private:
  LookTextures textures_;
  std::vector<uint32_t> first_;  // triangle of each mesh
  std::vector<MeshLooks> looks_;
};

Motion AsvoBody::motion() const {
  if (joint_count == 0) return RigidMotion{rest};
  return SkinMotion{rest, influences, joints, weights, joint_count};
}

Result<AsvoBody> open_asvo_body(const AsvoBodyChoice& choice, uint32_t resolution) {
  AsvoBody body;
  body.name = choice.name;
  body.turns = choice.turns;
  SINEW_TRY(body.triangles, load(choice.input));
  for (Node& node : body.triangles.nodes) {
    if (std::ranges::find(kPigManStrays, std::string_view(node.name)) != kPigManStrays.end()) {
      node.mesh = -1;
    }
  }
  list_objects(body.triangles);
  take_surface(choice.turns, body);
  make_voxel_scene(body);
  SINEW_CHECKED(voxelise(body, resolution));
  return body;
}

Result<VoxelSurface> voxelise_at(const AsvoBody& body, std::span<const vec3> positions,
                                 const VoxelGrid& grid) {
  const BodyLooks looks(body.triangles, grid.voxel);
  const std::vector<uint8_t> rims = rim_triangles(positions, body.faces);
  return voxelize(positions, body.faces, grid, looks, {.rims = rims});
}

Result<void> voxelise(AsvoBody& body, uint32_t resolution) {
  SINEW_TRY(const VoxelGrid grid,
            grid_of_resolution(surface_box(body.rest, body.faces), resolution));
  Error failed;
  bool good = false;
  body.voxelise_ms = milliseconds([&] {
    auto surface = voxelise_at(body, body.rest, grid);
    good = surface.has_value();
    if (good) {
      body.surface = std::move(*surface);
    } else {
      failed = surface.error();
    }
  });
  if (!good) return fail(failed);
  body.make_ms = milliseconds([&] {
    auto svo = make_svo(body.surface, body.source());
    good = svo.has_value();
    if (good) {
      body.voxels.octrees[0] = std::move(*svo);
    } else {
      failed = svo.error();
    }
  });
  if (!good) return fail(failed);
  body.voxels.octrees[0].name = body.name;
  list_objects(body.voxels);
  return {};
}

void pose_at(const AsvoBody& body, int clip, double u, AsvoPose& out) {
  const Scene& scene = body.triangles;
  double time = 0.0;
  if (scene.clips.empty() || body.turns) {
    clip = kRestPose;
  } else {
    const Clip& playing = scene.clips[static_cast<size_t>(clip)];
    time = playing.start + u * (playing.end - playing.start);
  }
  sample(scene, clip, time, out.scene);
  sample(body.voxels, clip, time, out.drawn);
  out.pose = Pose{};
  out.joints.clear();
  if (body.turns) {
    const float angle = 6.2831853f * static_cast<float>(u);
    out.pose.placement = trs(vec3(0.0f), glm::angleAxis(angle, vec3(0.0f, 1.0f, 0.0f)), vec3(1.0f));
  } else {
    out.joints.assign(out.drawn.voxels[0].joints.begin(), out.drawn.voxels[0].joints.end());
    out.pose.joints = out.joints;
  }
}

namespace {

struct Bone {
  vec3 begin{0.0f}, end{0.0f};  // at rest
  float length() const { return glm::distance(begin, end); }
};

// The joints of the octree that hang on `joint`, itself included.
std::vector<uint8_t> descendants(const Scene& scene, const Skin& skin, uint32_t joint) {
  std::vector<uint8_t> below(scene.nodes.size(), 0);
  for (size_t n = 0; n < scene.nodes.size(); ++n) {
    const int32_t parent = scene.nodes[n].parent;
    below[n] = n == skin.joints[joint] || (parent >= 0 && below[static_cast<size_t>(parent)]);
  }
  std::vector<uint8_t> out;
  for (const uint32_t node : skin.joints) out.push_back(below[node]);
  return out;
}

// From the joint to the first joint that hangs on it; of no length if there is none.
Bone bone_of(const Scene& scene, const Skin& skin, uint32_t joint) {
  const auto place = [&](uint32_t j) { return inverse_affine(skin.inverse_bind[j])[3]; };
  for (uint32_t j = 0; j < skin.joints.size(); ++j) {
    if (scene.nodes[skin.joints[j]].parent == static_cast<int32_t>(skin.joints[joint])) {
      return {place(joint), place(j)};
    }
  }
  return {place(joint), place(joint)};
}

}  // namespace

uint32_t bone_to_stretch(const AsvoBody& body) {
  const Skin& skin = body.voxels.skins[0];
  std::vector<double> weight(skin.joints.size(), 0.0);
  for (size_t i = 0; i < body.weights.size(); ++i) weight[body.joints[i]] += body.weights[i];
  const double least = 0.01 * static_cast<double>(body.rest.size());
  uint32_t best = 0;
  float longest = -1.0f;
  for (uint32_t j = 0; j < skin.joints.size(); ++j) {
    const float length = bone_of(body.voxels, skin, j).length();
    if (weight[j] < least || length <= longest) continue;
    best = j;
    longest = length;
  }
  return best;
}

void stretch_bone(const AsvoBody& body, uint32_t joint, float factor, AsvoPose& pose) {
  const Skin& skin = body.voxels.skins[0];
  const Bone bone = bone_of(body.voxels, skin, joint);
  if (!(bone.length() > 0.0f)) return;
  const vec3 along = (bone.end - bone.begin) / bone.length();
  // p -> p + (factor - 1) (p - begin) . along * along
  Affine longer = identity_affine();
  for (int k = 0; k < 3; ++k) longer[k] += (factor - 1.0f) * along[k] * along;
  longer[3] = -(factor - 1.0f) * dot(bone.begin, along) * along;
  const Affine here = pose.joints[joint];
  const vec3 moved =
      transform_point(here, transform_point(longer, bone.end)) - transform_point(here, bone.end);
  const std::vector<uint8_t> below = descendants(body.voxels, skin, joint);
  for (size_t j = 0; j < below.size(); ++j) {
    if (below[j] && j != joint) pose.joints[j][3] += moved;
  }
  pose.joints[joint] = compose(here, longer);
  pose.pose.joints = pose.joints;
}

CameraView body_camera(const Box& box, float share) {
  const vec3 direction = normalize(vec3(0.25f, 0.2f, 1.0f));
  const vec3 center = box.center();
  const auto extent_at = [&](float distance) {
    const CameraView camera =
        look_at(center + distance * direction, center, vec3(0.0f, 1.0f, 0.0f), kYfov);
    const mat4 clip = clip_from_world(camera, 1.0f);
    float reach = 0.0f;
    for (int i = 0; i < 8; ++i) {
      const vec3 p(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y,
                   i & 4 ? box.max.z : box.min.z);
      const vec4 at = clip * vec4(p, 1.0f);
      if (!(at.w > 0.0f)) return 1e9f;
      reach = std::max({reach, std::abs(at.x / at.w), std::abs(at.y / at.w)});
    }
    return reach;
  };
  float near = 0.0f, far = length(box.extent()) * 100.0f / share;
  for (int i = 0; i < 60; ++i) {
    const float middle = 0.5f * (near + far);
    (extent_at(middle) > share ? near : far) = middle;
  }
  return look_at(center + far * direction, center, vec3(0.0f, 1.0f, 0.0f), kYfov);
}

Box body_box(const AsvoBody& body, const AsvoPose& pose) {
  std::vector<vec3> moved(body.rest.size());
  positions(body.motion(), pose.pose, 0, moved);
  Box out;
  for (const uvec3 face : body.faces) {
    for (int k = 0; k < 3; ++k) {
      out.extend(transform_point(pose.pose.placement, moved[face[k]]));
    }
  }
  return out;
}

}  // namespace sinew::bench
