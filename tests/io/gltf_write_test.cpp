// What a saved glTF file says, element by element, and how saving fails.
#include <nlohmann/json.hpp>

#include "io/everything_scene.h"
#include "io/gltf_builder.h"
#include "io/round_trip.h"
#include "scene/small_scenes.h"
#include "sinew/io/gltf/affine.h"
#include "sinew/io/gltf/write_asset.h"
#include "sinew/io/load.h"
#include "sinew/io/save.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// The JSON of a scene saved as .gltf.
json saved_json(const Scene& scene, SaveReport* report = nullptr) {
  const TemporaryFolder folder;
  const Result<SaveReport> saved = save_gltf(scene, folder.path("a.gltf"));
  if (!saved) {
    ADD_FAILURE() << saved.error().message();
    return {};
  }
  if (report) *report = *saved;
  return json::parse(slurp(folder.path("a.gltf")));
}

void expect_equal(const TextureRef& a, const TextureRef& b) {
  EXPECT_EQ(a.image, b.image);
  if (a.image < 0) return;
  EXPECT_EQ(a.texcoord, b.texcoord);
  EXPECT_EQ(a.wrap_s, b.wrap_s);
  EXPECT_EQ(a.wrap_t, b.wrap_t);
  EXPECT_EQ(a.nearest, b.nearest);
  EXPECT_EQ(a.offset, b.offset);
  EXPECT_EQ(a.rotation, b.rotation);
  EXPECT_EQ(a.scale, b.scale);
}

void expect_equal(const Material& a, const Material& b) {
  EXPECT_EQ(a.base_color, b.base_color);
  EXPECT_EQ(a.metallic, b.metallic);
  EXPECT_EQ(a.roughness, b.roughness);
  EXPECT_EQ(a.normal_scale, b.normal_scale);
  EXPECT_EQ(a.occlusion_strength, b.occlusion_strength);
  EXPECT_EQ(a.emissive, b.emissive);
  EXPECT_EQ(a.alpha_mode, b.alpha_mode);
  EXPECT_EQ(a.alpha_cutoff, b.alpha_cutoff);
  EXPECT_EQ(a.double_sided, b.double_sided);
  EXPECT_EQ(a.unlit, b.unlit);
  EXPECT_EQ(a.ior, b.ior);
  EXPECT_EQ(a.specular, b.specular);
  EXPECT_EQ(a.specular_color, b.specular_color);
  EXPECT_EQ(a.transmission, b.transmission);
  EXPECT_EQ(a.thin, b.thin);
  EXPECT_EQ(a.attenuation_color, b.attenuation_color);
  EXPECT_EQ(a.attenuation_distance, b.attenuation_distance);
  expect_equal(a.base_color_texture, b.base_color_texture);
  expect_equal(a.metallic_roughness_texture, b.metallic_roughness_texture);
  expect_equal(a.normal_texture, b.normal_texture);
  expect_equal(a.occlusion_texture, b.occlusion_texture);
  expect_equal(a.emissive_texture, b.emissive_texture);
  expect_equal(a.transmission_texture, b.transmission_texture);
}

// Those of a scene that all are used in order, so their indices stay.
TEST(GltfWrite, MaterialsAndImagesComeBack) {
  const Scene scene = test::everything_scene();
  const TemporaryFolder folder;
  const Scene loaded = test::save_and_load(scene, folder);
  ASSERT_EQ(loaded.materials.size(), scene.materials.size());
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    SCOPED_TRACE(i);
    expect_equal(scene.materials[i], loaded.materials[i]);
  }
  EXPECT_EQ(loaded.materials[0].name, "gl\xc3\xa4sern \xef\xbf\xbd");  // U+FFFD for the bad byte
  ASSERT_EQ(loaded.images.size(), 2u);
  for (size_t i = 0; i < 2; ++i) EXPECT_EQ(loaded.images[i].pixels, scene.images[i].pixels);
}

TEST(GltfWrite, LightsCamerasAndSurroundingsComeBack) {
  const Scene scene = test::everything_scene();
  const TemporaryFolder folder;
  const Scene loaded = test::save_and_load(scene, folder);
  ASSERT_EQ(loaded.lights.size(), scene.lights.size());
  for (size_t i = 0; i < scene.lights.size(); ++i) {
    const Light &a = scene.lights[i], &b = loaded.lights[i];
    EXPECT_EQ(a.type, b.type);
    EXPECT_EQ(a.color * a.intensity, b.color * b.intensity) << a.name;
    EXPECT_EQ(a.range, b.range);
    EXPECT_EQ(a.falloff, b.falloff);
    if (a.type != LightType::spot) continue;
    EXPECT_EQ(a.outer_cone, b.outer_cone);
    EXPECT_NEAR(a.inner_cone, b.inner_cone, 1e-6);
  }
  ASSERT_EQ(loaded.cameras.size(), 2u);
  EXPECT_EQ(loaded.cameras[0].yfov, 0.8f);
  EXPECT_TRUE(loaded.cameras[1].orthographic);
  EXPECT_EQ(loaded.cameras[1].ymag, 5.0f);
  EXPECT_EQ(loaded.environment.zenith, scene.environment.zenith);
  EXPECT_EQ(loaded.environment.ambient, scene.environment.ambient);
  EXPECT_EQ(loaded.default_fps, 12.0);
  EXPECT_EQ(loaded.default_frames, 30);
  EXPECT_EQ(loaded.name, "everything");
}

// Half a metre beside the middle of the triangle: (0.5, 0.5, 0) less (0.5, 0.5, 0.5).
TEST(GltfWrite, LightWithoutFalloffIsAsBrightInTheMiddle) {
  Scene scene = test::scene_of({test::triangle_mesh()});
  scene.lights.push_back({"even", LightType::point, vec3(1), 8.0f, 0, false, 0, 0.7f});
  scene.nodes.push_back(test::node(-1, {0.5f, 0.5f, 0.5f}));
  scene.nodes.back().light = 0;
  SaveReport report;
  const json file = saved_json(scene, &report);
  EXPECT_EQ(file["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"], 2.0);
  ASSERT_EQ(report.warnings.size(), 1u);
  expect_contains(report.warnings[0], "light 'even': shines equally at all distances");
}

TEST(GltfWrite, MeshAttributesComeBack) {
  const Scene scene = test::everything_scene();
  const TemporaryFolder folder;
  const Scene loaded = test::save_and_load(scene, folder);
  const auto find = [](const Scene& in, const std::string& name) -> const Mesh& {
    return *std::ranges::find(in.meshes, name, &Mesh::name);
  };
  const Mesh& morphed = find(loaded, "morphed");
  EXPECT_EQ(morphed.morph_names, find(scene, "morphed").morph_names);
  EXPECT_EQ(morphed.morph_positions, find(scene, "morphed").morph_positions);
  EXPECT_EQ(morphed.morph_normals, find(scene, "morphed").morph_normals);
  EXPECT_EQ(morphed.tangents, find(scene, "morphed").tangents);
  EXPECT_EQ(find(loaded, "skinned").influences, 5u);  // one joint was named twice
  // The cache's vertices are points again, its attributes those of corners.
  const Mesh &cached = find(loaded, "cached"), &before = find(scene, "cached");
  EXPECT_EQ(cached.positions, before.positions);
  EXPECT_EQ(cached.key_positions, before.key_positions);
  ASSERT_EQ(cached.corners.size(), before.corners.size());
  for (const std::string name : {"seams", "cached"}) {
    SCOPED_TRACE(name);
    const Mesh &a = find(scene, name), &b = find(loaded, name);
    size_t t = 0;  // triangles come part by part
    for (uint32_t part = 0; part < a.parts.size(); ++part) {
      for (size_t i = 0; i < a.triangles.size(); ++i) {
        if (a.triangle_part[i] != part) continue;
        const uvec3 from = a.corner_of(static_cast<uint32_t>(i));
        const uvec3 to = b.corner_of(static_cast<uint32_t>(t++));
        for (int k = 0; k < 3; ++k) {
          EXPECT_EQ(a.texcoords[0][from[k]], b.texcoords[0][to[k]]);
          EXPECT_EQ(a.texcoords[1][from[k]], b.texcoords[1][to[k]]);
          EXPECT_EQ(glm::clamp(a.colors[from[k]], 0.0f, 1.0f), b.colors[to[k]]);
        }
      }
    }
  }
}

TEST(GltfWrite, PlainMeshKeepsItsVerticesAndSharesThem) {
  Mesh mesh = test::triangle_mesh();
  mesh.positions.push_back({1, 1, 0});
  mesh.triangles.push_back({1, 3, 2});
  mesh.triangle_part = {1, 0};
  mesh.parts = {{0, false}, {0, false}};
  const Scene scene = test::scene_of({mesh});
  const json primitives = saved_json(scene)["meshes"][0]["primitives"];
  ASSERT_EQ(primitives.size(), 2u);
  EXPECT_EQ(primitives[0]["attributes"], primitives[1]["attributes"]);
  const TemporaryFolder folder;
  EXPECT_EQ(test::save_and_load(scene, folder).meshes[0].positions, mesh.positions);
}

TEST(GltfWrite, WarnsOfWhatGltfCannotSay) {
  SaveReport report;
  saved_json(test::everything_scene(), &report);
  std::string all;
  for (const std::string& warning : report.warnings) all += warning + "\n";
  expect_contains(all, "mesh 'seams' and 1 more: has vertex colours beyond 0..1");
  expect_contains(all, "clip 'all at once': begins at -0.5 s; moved to begin at 0");
  expect_contains(all, "other programs show the caches' meshes at rest");
  saved_json(test::scene_of({test::triangle_mesh()}), &report);
  EXPECT_TRUE(report.warnings.empty());
}

TEST(GltfWrite, EmptySceneIsAFile) {
  const TemporaryFolder folder;
  const Scene loaded = test::save_and_load(Scene(), folder);
  EXPECT_TRUE(loaded.nodes.empty());
  Scene bare = test::scene_of({Mesh()});  // a mesh without triangles
  EXPECT_TRUE(test::save_and_load(bare, folder).objects.empty());
}

TEST(GltfWrite, FailuresLeaveEverythingAsItWas) {
  const Scene scene = test::scene_of({test::cached_mesh()});
  TemporaryFolder folder;
  folder.write("a.glb", "old");
  folder.write("a_cache.pc2", "old");
  fs::create_directory(folder.path("folder.glb"));
  const auto expect_failure = [&](const Scene& what, const std::string& path, ErrorKind kind,
                                  const char* problem) {
    const size_t files = folder.file_count();
    const Result<SaveReport> result = save_gltf(what, path);
    ASSERT_FALSE(result) << path;
    EXPECT_EQ(result.error().kind, kind);
    expect_contains(result.error().message(), problem);
    EXPECT_EQ(folder.file_count(), files);
    EXPECT_EQ(slurp(folder.path("a.glb")), "old");
    EXPECT_EQ(slurp(folder.path("a_cache.pc2")), "old");
  };
  expect_failure(scene, folder.path("a.obj"), ErrorKind::usage, "no name of a glTF file");
  expect_failure(scene, "-", ErrorKind::usage, "cannot hold the vertex caches");
  expect_failure(scene, folder.path("no/a.glb"), ErrorKind::output, "folder does not exist");
  expect_failure(scene, folder.path("folder.glb"), ErrorKind::output, "is a folder");
  Scene broken = scene;
  broken.meshes[0].positions[1].x = std::numeric_limits<float>::quiet_NaN();
  expect_failure(broken, folder.path("a.glb"), ErrorKind::bad_input, "not finite");
  if (!fs::exists("/dev/full")) return;
  fs::remove(folder.path("a.glb"));
  fs::create_symlink("/dev/full", folder.path("a.glb"));
  const Result<SaveReport> full = save_gltf(scene, folder.path("a.glb"));
  ASSERT_FALSE(full);
  expect_contains(full.error().message(), "the disk is full");
  EXPECT_EQ(slurp(folder.path("a_cache.pc2")), "old");
}

TEST(GltfWrite, FilesBeyondFourGibibytesAreRefused) {
  gltf::AssetWriter asset;
  const auto zero = [](size_t) { return vec4(0.0f); };
  for (int i = 0; i < 2; ++i) {
    asset.add_elements<vec4>(1u << 27, gltf::ViewUse::vertices, gltf::Limits::omitted, zero);
  }
  const Result<void> result = asset.check_size(asset.finish(""), "huge.glb");
  ASSERT_FALSE(result);
  expect_contains(result.error().message(), "huge.glb: would have 42949");
}

TEST(GltfWrite, AnyMatrixIsARotationInATransform) {
  Random random(7);
  for (int i = 0; i < 2000; ++i) {
    SCOPED_TRACE("seed 7, matrix " + std::to_string(i));
    Affine m(0.0f);
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 3; ++row) m[column][row] = random.uniform(-2.0f, 2.0f);
    }
    for (int column = 0; column < i % 4; ++column) m[column] = vec3(0.0f);  // flat, a line, a point
    if (i % 5 == 0) m[1] = m[0];
    const gltf::TransformPair pair = gltf::decompose_any(m);
    const Affine back = compose(trs(pair.outer.translation, pair.outer.rotation, pair.outer.scale),
                                trs(vec3(0.0f), pair.inner, vec3(1.0f)));
    for (int column = 0; column < 4; ++column) EXPECT_LE(length(back[column] - m[column]), 3e-6f);
  }
}

// A triangle with a vertex cache, and what may be wrong with that.
TEST(GltfWrite, DamagedCachesAreRefused) {
  const TemporaryFolder folder;
  const Scene scene = test::scene_of({test::cached_mesh()});
  ASSERT_TRUE(save_gltf(scene, folder.path("a.gltf")));
  const json good = json::parse(slurp(folder.path("a.gltf")));
  const std::string cache = slurp(folder.path("a_cache.pc2"));
  const auto problem_with = [&](const json& file, const std::string& bytes) {
    folder.write("a_cache.pc2", bytes);
    const Result<Scene> result = load(folder.write("a.gltf", file.dump()));
    if (result) return std::string("(loaded)");
    EXPECT_EQ(result.error().kind, ErrorKind::bad_input);
    return result.error().message();
  };
  EXPECT_EQ(problem_with(good, cache), "(loaded)");
  for_every_truncation(cache, [&](const std::string& bytes) {
    expect_contains(problem_with(good, bytes), "mesh 0: its vertex cache \"a_cache.pc2\"");
  });
  json bad = good;
  json& uri = bad["meshes"][0]["extras"]["sinew_vertex_cache"]["uri"];
  uri = "../a_cache.pc2";
  expect_contains(problem_with(bad, cache), "is not a file within the asset's folder");
  uri = "http://a/b.pc2";
  expect_contains(problem_with(bad, cache), "only files in the asset's folder are read");
  uri = "none.pc2";
  expect_contains(problem_with(bad, cache), "does not exist");
  uri = 7;
  expect_contains(problem_with(bad, cache), "\"uri\" is not a text");
  std::string other = cache;
  other[16] = 2;  // points
  expect_contains(problem_with(good, other), "has 3 vertices, but its vertex cache 2");
  bad = good;
  bad["meshes"][0]["extras"] = "anything";
  EXPECT_EQ(problem_with(bad, cache), "(loaded)");
}

// Our own extras in a file that is not as we write them.
TEST(GltfWrite, DamagedExtrasAreRefused) {
  const TemporaryFolder folder;
  ASSERT_TRUE(save_gltf(test::everything_scene(), folder.path("a.gltf")));
  const json good = json::parse(slurp(folder.path("a.gltf")));
  const auto problem_with = [&](const char* where, const json& value) {
    json file = good;
    file[json::json_pointer(where)] = value;
    const Result<Scene> result = load(folder.write("a.gltf", file.dump()));
    return result ? std::string("(loaded)") : result.error().message();
  };
  const json& extras = good["animations"][0]["extras"];
  ASSERT_EQ(extras["sinew_cache_keys"].size(), 2u);  // the cached mesh, the vertex program
  const std::string keys = "/animations/0/extras/sinew_cache_keys";
  const auto expect_problem = [&](const std::string& where, const json& value,
                                  const char* problem) {
    expect_contains(problem_with(where.c_str(), value), problem);
  };
  expect_problem(keys, 7, "\"sinew_cache_keys\" is not an array");
  expect_problem(keys + "/0/node", 100000, "\"node\" is 100000, but the file has only");
  expect_problem(keys + "/0/times", {0, 1, 1}, "needs rising times");
  expect_problem(keys + "/0/values", {0, 1}, "needs rising times and as many values");
  expect_problem(keys + "/0/interpolation", "SMOOTH", "not STEP, LINEAR or CUBICSPLINE");
  expect_problem("/animations/0/extras/sinew_start", 100.0, "runs from 100 to");
  expect_problem("/scenes/0/extras/sinew_fps", -1, "its frame rate makes no sense");
  expect_problem("/scenes/0/extras/sinew_frames", 1.5, "\"sinew_frames\" is not a whole number");
  expect_problem("/scenes/0/extras/sinew_environment", 1, "is not an object");
  expect_problem("/nodes/0/mesh", 0, "is marked to show and hide one node, but is more");
  expect_problem("/nodes/0/children", json::array(),
                 "is marked to show and hide one node, but is more");

  const json cached = good["meshes"][3]["primitives"][0]["attributes"];
  ASSERT_TRUE(cached.contains("_SINEW_POINT"));
  const std::string points = "/accessors/" + std::to_string(cached["_SINEW_POINT"].get<int>());
  expect_problem(points + "/type", "VEC3", "has the wrong type for \"_SINEW_POINT\"");
  json file = good;
  file["accessors"][cached["_SINEW_POINT"].get<size_t>()].erase("bufferView");
  file["accessors"][cached["_SINEW_POINT"].get<size_t>()]["count"] = 1;
  const Result<Scene> fewer = load(folder.write("a.gltf", file.dump()));
  ASSERT_FALSE(fewer);
  expect_contains(fewer.error().message(), "has 1 elements for");
}

TEST(GltfWrite, RandomlyDamagedFilesAreHandled) {
  const TemporaryFolder folder;
  ASSERT_TRUE(save_gltf(test::everything_scene(), folder.path("a.glb")));
  for_random_patches(slurp(folder.path("a.glb")), 200, 11, [&](const std::string& bytes) {
    const Result<Scene> scene = load(folder.write("b.glb", bytes));
    if (scene) {
      EXPECT_EQ(validate(*scene), "");
    }
  });
}

}  // namespace
}  // namespace sinew
