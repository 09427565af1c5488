// Bad glTF files: every truncation, random patches, every JSON value replaced by hostile ones. Each
// must end in a clear error or in a valid scene.
#include "gltf_builder.h"
#include "sinew/io/image_file.h"

namespace sinew {
namespace {

using nlohmann::json;

constexpr LoadOptions kLimited{.memory_limit = uint64_t{64} << 20};

std::string small_png() {
  const TemporaryFolder folder;
  EXPECT_TRUE(write_png(folder.path("a.png"), Image8{2, 2, std::vector<uint8_t>(16, 100)}));
  return slurp(folder.path("a.png"));
}

void add_materials(GltfBuilder& b) {
  const std::string bytes = small_png();
  const int view = b.view(std::vector<char>(bytes.begin(), bytes.end()));
  b.add("images", {{"bufferView", view}, {"mimeType", "image/png"}});
  b.add("samplers", {{"wrapS", 33071}, {"magFilter", 9728}});
  b.add("textures", {{"source", 0}, {"sampler", 0}});
  const json texture = {{"index", 0},
                        {"texCoord", 0},
                        {"extensions", {{"KHR_texture_transform", {{"offset", {0.5, 0.5}}}}}}};
  b.add("materials", {{"pbrMetallicRoughness",
                       {{"baseColorFactor", {1, 1, 1, 1}}, {"baseColorTexture", texture}}},
                      {"normalTexture", texture},
                      {"alphaMode", "MASK"}});
  b.add("materials", {{"extensions",
                       {{"KHR_materials_pbrSpecularGlossiness",
                         {{"diffuseTexture", texture}, {"glossinessFactor", 0.5}}}}}});
}

int add_skinned_mesh(GltfBuilder& b) {
  std::vector<float> weights(12, 0.25f);
  const int deltas = b.accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  b.json["accessors"][deltas]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", b.view<uint8_t>({1})}, {"componentType", 5121}}},
      {"values", {{"bufferView", b.view<float>({1, 2, 3})}}}};
  const json attributes = {
      {"POSITION", b.triangle_positions()},
      {"NORMAL", b.accessor<int8_t>({0, 0, 127, 0, 0, 127, 0, 0, 127}, "VEC3", true)},
      {"TEXCOORD_0", b.accessor<float>({0, 0, 1, 0, 0, 1}, "VEC2")},
      {"COLOR_0", b.accessor<uint8_t>(std::vector<uint8_t>(12, 200), "VEC4", true)},
      {"JOINTS_0", b.accessor<uint8_t>({0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1}, "VEC4")},
      {"WEIGHTS_0", b.accessor(weights, "VEC4")}};
  const json target = {{"POSITION", deltas}};
  const int node = b.add_mesh_node({{"attributes", attributes},
                                    {"indices", b.accessor<uint16_t>({0, 1, 2}, "SCALAR")},
                                    {"targets", {target, target}},
                                    {"material", 0},
                                    {"mode", 4}});
  b.json["meshes"][0]["weights"] = {0.5, 0.5};
  b.json["meshes"][0]["extras"]["targetNames"] = {"a", "b", "c"};
  return node;
}

void add_animation(GltfBuilder& b, int mesh_node, int joint) {
  const int times = b.accessor<float>({0, 1}, "SCALAR");
  const json samplers = {
      {{"input", times}, {"output", b.accessor<float>({0, 0, 0, 1, 0, 0, 1, 0}, "VEC4")}},
      {{"input", times},
       {"output", b.accessor<float>(std::vector<float>(12, 0.5f), "SCALAR")},
       {"interpolation", "CUBICSPLINE"}}};
  const json channels = {{{"sampler", 0}, {"target", {{"node", joint}, {"path", "rotation"}}}},
                         {{"sampler", 1}, {"target", {{"node", mesh_node}, {"path", "weights"}}}}};
  b.add("animations", {{"name", "go"}, {"samplers", samplers}, {"channels", channels}});
}

// A small asset that uses most of what the loader knows.
GltfBuilder kitchen_sink() {
  GltfBuilder b;
  add_materials(b);
  const int mesh_node = add_skinned_mesh(b);
  const int joint =
      b.add("nodes", {{"name", "hip"}, {"translation", {0, 1, 0}}, {"children", {2}}});
  b.add("nodes", {{"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}, {"camera", 0}});
  const int meadow = b.add_mesh_node(
      {{"attributes", {{"POSITION", b.triangle_positions()}}}, {"material", 1}, {"mode", 5}});
  b.json["nodes"][meadow]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", b.accessor<float>({1, 0, 0, 2, 0, 0}, "VEC3")}};
  b.json["nodes"][meadow]["extensions"]["KHR_lights_punctual"]["light"] = 0;
  b.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "spot"}, {"intensity", 2}}};
  b.add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 0.7}, {"znear", 0.1}}}});
  const std::vector<float> identity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  std::vector<float> matrices = identity;
  matrices.insert(matrices.end(), identity.begin(), identity.end());
  b.json["nodes"][mesh_node]["skin"] = b.add(
      "skins", {{"joints", {joint, 2}}, {"inverseBindMatrices", b.accessor(matrices, "MAT4")}});
  b.json["scenes"][0]["nodes"] = {mesh_node, joint, meadow};
  add_animation(b, mesh_node, joint);
  return b;
}

// Loads bytes and checks that either outcome is a proper one. Returns whether it loaded.
class HostileLoader {
 public:
  bool operator()(const std::string& bytes) const {
    // A new file each time: some file systems write a file that was cut short to disk at once.
    std::filesystem::remove(folder_.path("bad.glb"));
    const Result<Scene> scene = load_gltf(folder_.write("bad.glb", bytes), kLimited);
    if (scene) {
      EXPECT_EQ(validate(*scene), "");
      return true;
    }
    EXPECT_FALSE(scene.error().problem.empty());
    EXPECT_FALSE(scene.error().file.empty());
    EXPECT_EQ(scene.error().kind, ErrorKind::bad_input) << scene.error().message();
    return false;
  }

 private:
  TemporaryFolder folder_;
};

TEST(GltfHostile, TheKitchenSinkItselfLoads) {
  const Scene scene = load_or_fail(kitchen_sink());
  EXPECT_EQ(scene.warnings, std::vector<std::string>());
  EXPECT_EQ(scene.objects.size(), 3u);
  EXPECT_EQ(scene.clips.at(0).channels.size(), 2u);
}

TEST(GltfHostile, EveryTruncationIsAnError) {
  const HostileLoader load;
  for (const std::string& whole : {kitchen_sink().glb(), kitchen_sink().gltf()}) {
    for_every_truncation(whole, [&](const std::string& bytes) { EXPECT_FALSE(load(bytes)); });
  }
}

TEST(GltfHostile, RandomPatches) {
  const HostileLoader load;
  int loaded = 0;
  for_random_patches(kitchen_sink().glb(), 5000, 20240311,
                     [&](const std::string& bytes) { loaded += load(bytes); });
  for_random_patches(kitchen_sink().gltf(), 2000, 77,
                     [&](const std::string& bytes) { loaded += load(bytes); });
  EXPECT_GT(loaded, 100);  // some patches only change numbers: those scenes were validated
}

TEST(GltfHostile, EveryValueReplaced) {
  const HostileLoader load;
  const GltfBuilder sink = kitchen_sink();
  const std::vector<json> hostile = {nullptr,
                                     true,
                                     -1,
                                     0,
                                     1,
                                     255,
                                     2147483648u,
                                     4294967295u,
                                     18446744073709551615u,
                                     1e39,
                                     -1e300,
                                     0.5,
                                     "",
                                     "x",
                                     json::array(),
                                     json::object(),
                                     json::array({-1}),
                                     json::array({0, 0})};
  std::vector<json::json_pointer> places;
  const json flat = sink.json.flatten();
  for (const auto& item : flat.items()) {
    // The value itself and, shared with its neighbours, what holds it.
    for (json::json_pointer p(item.key()); !p.empty(); p.pop_back()) {
      if (std::find(places.begin(), places.end(), p) == places.end()) places.push_back(p);
    }
  }
  for (const json::json_pointer& place : places) {
    for (const json& value : hostile) {
      SCOPED_TRACE(place.to_string() + " = " + value.dump());
      GltfBuilder changed = sink;
      changed.json[place] = value;
      load(changed.glb());
    }
  }
}

TEST(GltfHostile, EveryMemberRemoved) {
  const HostileLoader load;
  const GltfBuilder sink = kitchen_sink();
  const json flat = sink.json.flatten();
  for (const auto& item : flat.items()) {
    for (json::json_pointer p(item.key()); !p.empty(); p.pop_back()) {
      SCOPED_TRACE("without " + p.to_string());
      GltfBuilder changed = sink;
      json& holder = changed.json[p.parent_pointer()];
      if (!holder.is_object()) continue;
      holder.erase(p.back());
      load(changed.glb());
    }
  }
}

TEST(GltfHostile, DeepNestingIsAnErrorNotAnOverflow) {
  const HostileLoader load;
  for (const size_t depth : {size_t{300}, size_t{1000000}}) {
    EXPECT_FALSE(load(R"({"asset":{"version":"2.0"},"extras":)" + std::string(depth, '[') +
                      std::string(depth, ']') + "}"));
    EXPECT_FALSE(load(std::string(depth, '[')));
    EXPECT_FALSE(load(std::string(depth, '{')));
  }
}

TEST(GltfHostile, ALongChainOfNodesLoads) {
  GltfBuilder b;
  constexpr int kLength = 20000;
  for (int i = 0; i < kLength; ++i) {
    b.add("nodes", i + 1 < kLength ? json{{"children", {i + 1}}} : json::object());
  }
  EXPECT_EQ(load_or_fail(b).nodes.size(), size_t{kLength});
}

TEST(GltfHostile, RandomBytesAreNotGltf) {
  const HostileLoader load;
  Random random(5);
  for (int i = 0; i < 200; ++i) {
    std::string bytes(random.next() % 200, '\0');
    for (char& c : bytes) c = static_cast<char>(random.next() >> 24);
    EXPECT_FALSE(load(bytes));
    EXPECT_FALSE(load("glTF" + GltfBuilder::u32(2) + GltfBuilder::u32(100) + bytes));
  }
}

}  // namespace
}  // namespace sinew
