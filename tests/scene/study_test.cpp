// The study scenes: counts, closed surfaces, determinism, and what each promises.
#include "sinew/scene/study.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "scene/study_helpers.h"
#include "scene/surface_checks.h"
#include "sinew/base/parallel.h"
#include "sinew/scene/sample.h"

namespace sinew {
namespace {

Scene make(const std::string& spec) {
  Result<Scene> scene = make_study_scene(spec);
  EXPECT_TRUE(scene) << (scene ? "" : scene.error().message());
  return scene ? std::move(*scene) : Scene{};
}

const Mesh& mesh_named(const Scene& scene, const std::string& name) {
  const auto found = std::ranges::find(scene.meshes, name, &Mesh::name);
  EXPECT_NE(found, scene.meshes.end()) << name;
  return *found;
}

// FNV-1a over everything that a renderer reads.
class Hash {
 public:
  template <class T>
  void add(const std::vector<T>& values) {
    const auto* bytes = reinterpret_cast<const unsigned char*>(values.data());
    for (size_t i = 0; i < values.size() * sizeof(T); ++i) {
      state_ = (state_ ^ bytes[i]) * 1099511628211ull;
    }
  }
  uint64_t value() const { return state_; }

 private:
  uint64_t state_ = 14695981039346656037ull;
};

uint64_t hash_scene(const Scene& scene) {
  Hash hash;
  for (const Mesh& m : scene.meshes) {
    hash.add(m.positions);
    hash.add(m.triangles);
    hash.add(m.corners);
    hash.add(m.normals);
    hash.add(m.texcoords[0]);
    hash.add(m.colors);
    hash.add(m.joints);
    hash.add(m.weights);
    hash.add(m.morph_positions);
    hash.add(m.morph_normals);
    hash.add(m.key_positions);
  }
  for (const Image8& image : scene.images) hash.add(image.pixels);
  for (const Clip& clip : scene.clips) {
    for (const Channel& channel : clip.channels) {
      hash.add(channel.times);
      hash.add(channel.values);
    }
  }
  return hash.value();
}

// Specs small enough to be made many times.
const std::vector<std::string> kSmall{"creature,triangles=8000,texture=256",
                                      "twist,triangles=2000",
                                      "soup,triangles=500",
                                      "fracture,triangles=12000,pieces=20",
                                      "bodies,subdivisions=3",
                                      "bodies,subdivisions=3,motion=free",
                                      "cell24,triangles=10000",
                                      "cell24,triangles=10000,motion=keys",
                                      "cloth,triangles=3000,frames=12",
                                      "herd,count=3,triangles=2000,terrain=1000"};

TEST(Study, EverySceneIsValidAndComplete) {
  for (const std::string& spec : kSmall) {
    SCOPED_TRACE(spec);
    const Scene scene = make(spec);
    EXPECT_EQ(validate(scene), "");
    EXPECT_EQ(scene.name, "study:" + spec);
    EXPECT_GT(scene.default_frames, 0);
    EXPECT_GT(scene.default_fps, 0.0);
    EXPECT_FALSE(scene.clips.empty());
    EXPECT_FALSE(scene.cameras.empty());
    EXPECT_GE(scene.lights.size(), 2u);
    EXPECT_NEAR(scene.clips[0].end - scene.clips[0].start, scene.default_frames / scene.default_fps,
                1e-9);
    for (const Clip& clip : scene.clips) {
      for (const Channel& channel : clip.channels) {
        EXPECT_LE(channel.times.back(), static_cast<float>(clip.end));
      }
    }
  }
}

TEST(Study, PositionsStayFinite) {
  for (const std::string& spec : kSmall) {
    SCOPED_TRACE(spec);
    const Scene scene = make(spec);
    for (int clip = kRestPose; clip < static_cast<int>(scene.clips.size()); ++clip) {
      const double end = clip < 0 ? 0.0 : scene.clips[clip].end;
      for (int step = 0; step <= 7; ++step) {
        for (uint32_t object = 0; object < scene.objects.size(); ++object) {
          vec3 sum(0.0f);
          for (const vec3 p : positions_at(scene, clip, end * step / 7.0, object)) sum += abs(p);
          EXPECT_TRUE(std::isfinite(sum.x + sum.y + sum.z));
        }
      }
    }
  }
}

TEST(Study, SameSpecSameBitsForAnyThreadCount) {
  for (const std::string& spec : kSmall) {
    const uint64_t many = hash_scene(make(spec));
    const ThreadLimit one(1);
    EXPECT_EQ(hash_scene(make(spec)), many) << spec;
  }
}

TEST(Study, WeightsAreNormalised) {
  for (const std::string& spec : kSmall) {
    for (const Mesh& mesh : make(spec).meshes) {
      for (size_t v = 0; mesh.influences > 0 && v < mesh.positions.size(); ++v) {
        float sum = 0.0f;
        for (uint32_t k = 0; k < mesh.influences; ++k) {
          const float weight = mesh.weights[v * mesh.influences + k];
          EXPECT_GE(weight, 0.0f);
          sum += weight;
        }
        ASSERT_NEAR(sum, 1.0f, 1e-6f) << spec << ", vertex " << v;
      }
    }
  }
}

TEST(Study, ErrorsNameWhatThereIs) {
  const auto message = [](const char* spec) {
    const Result<Scene> scene = make_study_scene(spec);
    if (scene) return std::string("no error");
    EXPECT_EQ(scene.error().kind, ErrorKind::usage);
    return scene.error().message();
  };
  const auto expect = [&](const char* spec, const std::vector<std::string>& parts) {
    const std::string text = message(spec);
    for (const std::string& part : parts) {
      EXPECT_NE(text.find(part), std::string::npos) << spec << ": " << text;
    }
  };
  expect("", {"creature", "twist", "soup", "fracture", "bodies"});
  expect("creatures", {"creatures", "there are creature, twist, soup, fracture, bodies"});
  expect("twist,size=3", {"study:twist", "'size'", "triangles=256000"});
  expect("twist,triangles=12", {"triangles=12", "1000 to 4000000"});
  expect("twist,triangles=-5000", {"whole number"});
  expect("twist,triangles=2e4", {"whole number"});
  expect("twist,triangles=99999999999999999999", {"whole number"});
  expect("twist,triangles", {"key=value"});
  expect("twist,triangles=", {"key=value"});
  expect("twist,=5", {"key=value"});
  expect("twist,", {"comma"});
  expect("twist,triangles=2000,", {"key=value"});
  expect("twist,,triangles=2000", {"key=value"});
  expect("twist,triangles=2000,triangles=3000", {"twice"});
  expect("bodies,motion=rigid", {"morph, free"});
  expect("soup,key_seconds=nan", {"number from"});
  expect("soup,key_seconds=0", {"number from"});
  expect("soup,key_seconds=1s", {"number from"});
  expect("fracture,triangles=10000,pieces=2000", {"too few"});
  expect("cell24,motion=morph", {"free, keys"});
  expect("cell24,triangles=9999", {"10000 to 4000000"});
  expect("cloth,frames=1", {"2 to 1000"});
  expect("cloth,triangles=1000000,frames=1000", {"2 GiB"});
  expect("herd,count=0", {"1 to 1000"});
  expect("herd,terrain=20000001", {"1000 to 20000000"});
}

// The scene with a parameter at its fallback and all others small.
std::string mostly_small(const StudyInfo& info, const StudyParameter& parameter) {
  std::string spec(info.name);
  for (const StudyParameter& other : info.parameters) {
    if (&other == &parameter) continue;
    const char* small = other.name == "count" || other.name == "frames" ? "2" : "2000";
    spec.append(",").append(other.name).append("=").append(small);
  }
  return spec;
}

TEST(Study, EveryFallbackAndParameterIsAccepted) {
  ASSERT_EQ(study_scenes().size(), 8u);
  for (const StudyInfo& info : study_scenes()) {
    EXPECT_FALSE(info.summary.empty());
    for (const StudyParameter& p : info.parameters) EXPECT_FALSE(p.meaning.empty());
    if (info.name == "cloth" || info.name == "herd") {  // too large to be made whole
      for (const StudyParameter& p : info.parameters) make(mostly_small(info, p));
      continue;
    }
    std::string spec(info.name);
    for (const StudyParameter& p : info.parameters) {
      spec.append(",").append(p.name).append("=").append(p.fallback);
    }
    EXPECT_EQ(hash_scene(make(spec)), hash_scene(make(std::string(info.name)))) << spec;
  }
}

TEST(StudyTwist, IsOneClosedBodyOf256000Triangles) {
  const Scene scene = make("twist");
  const Mesh& bar = mesh_named(scene, "bar");
  EXPECT_EQ(bar.triangles.size(), 256000u);
  EXPECT_EQ(why_not_manifold(bar.triangles, bar.positions.size()), "");
  EXPECT_EQ(count_components(bar.triangles, bar.positions.size()), 1u);
  EXPECT_GT(signed_volume6(bar.positions, bar.triangles), 0.0);
  EXPECT_EQ(scene.default_frames, 50);
}

TEST(StudySoup, HasIndependentTrianglesAndFiveKeys) {
  const Scene scene = make("soup");
  const Mesh& art = mesh_named(scene, "art");
  EXPECT_EQ(art.triangles.size(), 65536u);
  EXPECT_EQ(art.positions.size(), 196608u);
  EXPECT_EQ(art.keys, 5u);
  std::vector<uint8_t> used(art.positions.size(), 0);
  for (const uvec3 t : art.triangles) {
    for (int k = 0; k < 3; ++k) ASSERT_EQ(used[t[k]]++, 0);
  }
  // At 1.5 s every vertex is half way between keys 1 and 2.
  const std::vector<vec3> half = positions_at(scene, 0, 1.5, object_of(scene, "art"));
  const size_t n = half.size();
  for (size_t v = 0; v < n; ++v) {
    const vec3 expected = 0.5f * (art.key_positions[n + v] + art.key_positions[2 * n + v]);
    ASSERT_LT(length(half[v] - expected), 1e-5f);
  }
  EXPECT_EQ(scene.clips[0].end, 4.0);
  EXPECT_EQ(make("soup,triangles=7,key_seconds=0.5").clips[0].end, 2.0);
}

TEST(StudyFracture, BreaksInto200ClosedPieces) {
  const Scene scene = make("fracture");
  const Mesh& shell = mesh_named(scene, "shell");
  EXPECT_EQ(shell.triangles.size(), 250880u);
  EXPECT_EQ(scene.skins[0].joints.size(), 201u);
  EXPECT_EQ(why_not_manifold(shell.triangles, shell.positions.size()), "");
  EXPECT_EQ(count_components(shell.triangles, shell.positions.size()), 200u);
  EXPECT_GT(signed_volume6(shell.positions, shell.triangles), 0.0);
  std::vector<uint8_t> seen(201, 0);
  for (const uvec3 t : shell.triangles) {
    const uint16_t joint = shell.joints[t.x];
    ASSERT_TRUE(joint == shell.joints[t.y] && joint == shell.joints[t.z]);
    seen[joint] = 1;
  }
  EXPECT_EQ(std::ranges::count(seen, 1), 200);
}

TEST(StudyFracture, StartsWholeFliesApartAndStaysAboveGround) {
  const Scene scene = make("fracture,triangles=30000,pieces=60");
  const uint32_t object = object_of(scene, "shell");
  const Mesh& shell = scene.meshes[scene.objects[object].mesh];
  EXPECT_EQ(shell.triangles.size(), 30000u);
  const std::vector<vec3> start = positions_at(scene, 0, 0.0, object);
  for (size_t v = 0; v < start.size(); ++v) {
    ASSERT_LT(length(start[v] - shell.positions[v]), 1e-5f);
  }
  // Whole: wherever a crack will run, the pieces on both sides have a vertex at the same place.
  float lowest = 0.0f, farthest = 0.0f;
  for (int frame = 0; frame <= 50; ++frame) {
    for (const vec3 p : positions_at(scene, 0, frame / 25.0, object)) {
      lowest = std::min(lowest, p.y);
      farthest = std::max(farthest, length(vec2(p.x, p.z)));
    }
  }
  EXPECT_GT(lowest, -0.015f);
  EXPECT_GT(farthest, 1.2f);
}

TEST(StudyBodies, HasTheCountsOfThePaper) {
  for (const char* spec : {"bodies", "bodies,motion=free"}) {
    const Scene scene = make(spec);
    EXPECT_EQ(count(scene).triangles, 737280u);
    EXPECT_EQ(scene.objects.size(), 9u);
    EXPECT_EQ(scene.default_frames, 280);
    for (const Mesh& mesh : scene.meshes) EXPECT_EQ(mesh.triangles.size(), 81920u);
    const Mesh& mesh = scene.meshes[0];
    EXPECT_EQ(mesh.positions.size(), 40962u);
    EXPECT_EQ(why_not_manifold(mesh.triangles, mesh.positions.size()), "");
    EXPECT_GT(signed_volume6(mesh.positions, mesh.triangles), 0.0);
  }
  EXPECT_EQ(make("bodies,bodies=64,subdivisions=2").objects.size(), 64u);
}

TEST(StudyBodies, FreeMotionIsTheMorphsMotion) {
  const Scene morph = make("bodies,subdivisions=4,bodies=11");
  const Scene free = make("bodies,subdivisions=4,bodies=11,motion=free");
  for (const double time : {0.0, 0.013, 3.3, 7.77, 11.2}) {
    for (uint32_t object = 0; object < 11; ++object) {
      const std::vector<vec3> a = positions_at(morph, 0, time, object);
      const std::vector<vec3> b = positions_at(free, 0, time, object);
      ASSERT_EQ(a.size(), b.size());
      for (size_t v = 0; v < a.size(); ++v) ASSERT_LT(length(a[v] - b[v]), 1e-5f);
    }
  }
}

// How many bodies have their middle in the picture, 4:3.
int bodies_in_view(const Scene& scene, double time) {
  ScenePose pose;
  sample(scene, 0, time, pose);
  const auto camera = std::ranges::find(scene.nodes, 0, &Node::camera);
  const Affine view = inverse_affine(pose.nodes[camera - scene.nodes.begin()]);
  const float top = std::tan(0.5f * scene.cameras[0].yfov);
  int count = 0;
  for (const SceneObject& object : scene.objects) {
    const vec3 p = transform_point(view, pose.nodes[object.node][3]);
    count += p.z < 0.0f && std::abs(p.y) < -p.z * top && std::abs(p.x) < -p.z * top * 4.0f / 3.0f;
  }
  return count;
}

TEST(StudyBodies, CameraSeesMostBodiesMostlyAndFewAtFrame200) {
  const Scene scene = make("bodies,subdivisions=2");
  int more_than_half = 0, all = 0;
  for (int frame = 0; frame < 280; ++frame) {
    const int seen = bodies_in_view(scene, frame / 25.0);
    more_than_half += seen > 4;
    all += seen == 9;
  }
  EXPECT_GT(more_than_half, 200);
  EXPECT_GT(all, 100);
  EXPECT_LT(more_than_half, 270);
  EXPECT_LE(bodies_in_view(scene, 199 / 25.0), 1);
  EXPECT_LE(bodies_in_view(scene, 200 / 25.0), 1);
}

}  // namespace
}  // namespace sinew
