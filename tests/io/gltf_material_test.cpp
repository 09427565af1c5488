// Materials, textures and images of small glTF files made here.
#include "gltf_builder.h"
#include "sinew/io/image_file.h"

namespace sinew {
namespace {

using nlohmann::json;

// A PNG of one colour.
std::string png(uint32_t width, uint32_t height, std::array<uint8_t, 4> color) {
  Image8 image{width, height, {}};
  for (uint32_t i = 0; i < width * height; ++i) {
    image.pixels.insert(image.pixels.end(), color.begin(), color.end());
  }
  const TemporaryFolder folder;
  EXPECT_TRUE(write_png(folder.path("a.png"), image));
  return slurp(folder.path("a.png"));
}

int add_image(GltfBuilder& b, const std::string& bytes) {
  const int view = b.view(std::vector<char>(bytes.begin(), bytes.end()));
  return b.add("images", {{"bufferView", view}, {"mimeType", "image/png"}});
}

// A triangle with one material.
GltfBuilder with_material(const json& material) {
  GltfBuilder b;
  b.add_triangle();
  b.json["meshes"][0]["primitives"][0]["material"] = b.add("materials", material);
  return b;
}

TEST(GltfMaterial, DefaultsAreThoseOfTheSpecification) {
  const Scene scene = load_or_fail(with_material(json::object()));
  ASSERT_EQ(scene.materials.size(), 1u);
  const Material& m = scene.materials[0];
  EXPECT_EQ(m.base_color, vec4(1.0f));
  EXPECT_EQ(m.metallic, 1.0f);
  EXPECT_EQ(m.roughness, 1.0f);
  EXPECT_EQ(m.emissive, vec3(0.0f));
  EXPECT_EQ(m.alpha_mode, AlphaMode::opaque);
  EXPECT_EQ(m.alpha_cutoff, 0.5f);
  EXPECT_FALSE(m.double_sided);
  EXPECT_FALSE(m.unlit);
  EXPECT_EQ(m.base_color_texture.image, -1);
}

TEST(GltfMaterial, EveryNumberIsRead) {
  GltfBuilder b =
      with_material({{"name", "paint"},
                     {"pbrMetallicRoughness",
                      {{"baseColorFactor", {0.1, 0.2, 0.3, 0.4}},
                       {"metallicFactor", 0.5},
                       {"roughnessFactor", 0.6}}},
                     {"emissiveFactor", {0.5, 0.25, 1.0}},
                     {"alphaMode", "MASK"},
                     {"alphaCutoff", 0.7},
                     {"doubleSided", true},
                     {"extensions",
                      {{"KHR_materials_unlit", json::object()},
                       {"KHR_materials_emissive_strength", {{"emissiveStrength", 4.0}}}}}});
  const Material m = load_or_fail(b).materials.at(0);
  EXPECT_EQ(m.name, "paint");
  EXPECT_EQ(m.base_color, vec4(0.1f, 0.2f, 0.3f, 0.4f));
  EXPECT_EQ(m.metallic, 0.5f);
  EXPECT_EQ(m.roughness, 0.6f);
  EXPECT_EQ(m.emissive, vec3(2.0f, 1.0f, 4.0f));
  EXPECT_EQ(m.alpha_mode, AlphaMode::mask);
  EXPECT_EQ(m.alpha_cutoff, 0.7f);
  EXPECT_TRUE(m.double_sided);
  EXPECT_TRUE(m.unlit);
  b.json["materials"][0]["alphaMode"] = "BLEND";
  EXPECT_EQ(load_or_fail(b).materials.at(0).alpha_mode, AlphaMode::blend);
  b.json["materials"][0]["alphaMode"] = "GLASS";
  expect_contains(load_error(b), "material 0: \"alphaMode\" is \"GLASS\"");
}

TEST(GltfMaterial, ReflectanceAndTransmissionAreRead) {
  GltfBuilder b =
      with_material({{"extensions",
                      {{"KHR_materials_ior", {{"ior", 1.25}}},
                       {"KHR_materials_specular",
                        {{"specularFactor", 0.5}, {"specularColorFactor", {2.0, 1.0, 0.25}}}},
                       {"KHR_materials_transmission", {{"transmissionFactor", 0.75}}},
                       {"KHR_materials_volume",
                        {{"thicknessFactor", 0.01},
                         {"attenuationDistance", 3.0},
                         {"attenuationColor", {0.5, 0.25, 0.125}}}}}}});
  b.json["extensionsUsed"] = {"KHR_materials_ior", "KHR_materials_specular",
                              "KHR_materials_transmission", "KHR_materials_volume"};
  const Scene scene = load_or_fail(b);
  EXPECT_TRUE(scene.warnings.empty());
  const Material m = scene.materials.at(0);
  EXPECT_EQ(m.ior, 1.25f);
  EXPECT_EQ(m.specular, 0.5f);
  EXPECT_EQ(m.specular_color, vec3(2.0f, 1.0f, 0.25f));
  EXPECT_EQ(m.transmission, 0.75f);
  EXPECT_FALSE(m.thin);
  EXPECT_EQ(m.attenuation_distance, 3.0f);
  EXPECT_EQ(m.attenuation_color, vec3(0.5f, 0.25f, 0.125f));

  json& extensions = b.json["materials"][0]["extensions"];
  extensions["KHR_materials_volume"]["thicknessFactor"] = 0.0;
  EXPECT_TRUE(load_or_fail(b).materials.at(0).thin);
  extensions["KHR_materials_specular"]["specularTexture"] = {{"index", 0}};
  expect_contains(load_or_fail(b).warnings.at(0), "textures of KHR_materials_specular");
}

TEST(GltfMaterial, ReflectanceOutsideItsRangeIsClamped) {
  const auto read = [](const char* name, const json& values) {
    return load_or_fail(with_material({{"extensions", {{name, values}}}})).materials.at(0);
  };
  EXPECT_GT(read("KHR_materials_ior", {{"ior", 0}}).ior, 100.0f);  // stands for a mirror
  EXPECT_EQ(read("KHR_materials_ior", {{"ior", 0.5}}).ior, 1.0f);
  EXPECT_EQ(read("KHR_materials_specular", {{"specularFactor", -1}}).specular, 0.0f);
  EXPECT_EQ(read("KHR_materials_transmission", {{"transmissionFactor", 7}}).transmission, 1.0f);
  EXPECT_EQ(read("KHR_materials_volume", {{"attenuationDistance", -2}}).attenuation_distance, 0.0f);
  EXPECT_EQ(read("KHR_materials_transmission", json::object()).transmission, 0.0f);
  EXPECT_TRUE(read("KHR_materials_volume", json::object()).thin);
}

TEST(GltfMaterial, TexturesSamplersAndTransforms) {
  GltfBuilder b = with_material(
      {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 1}, {"texCoord", 1}}}}},
       {"normalTexture", {{"index", 0}, {"scale", 0.5}}},
       {"occlusionTexture", {{"index", 1}, {"strength", 0.25}}},
       {"emissiveTexture",
        {{"index", 0},
         {"extensions",
          {{"KHR_texture_transform",
            {{"offset", {0.1, 0.2}}, {"rotation", 0.3}, {"scale", {2, 3}}, {"texCoord", 1}}}}}}}});
  add_image(b, "never decoded, for no texture uses it");
  add_image(b, png(2, 1, {255, 0, 0, 255}));
  add_image(b, png(1, 3, {0, 255, 0, 128}));
  b.add("samplers", {{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}, {"minFilter", 9987}});
  b.add("textures", {{"source", 1}, {"sampler", 0}});
  b.add("textures", {{"source", 2}});
  const Scene scene = load_or_fail(b);
  ASSERT_EQ(scene.images.size(), 2u);
  const Material& m = scene.materials.at(0);
  const Image8& base = scene.images.at(m.base_color_texture.image);
  EXPECT_EQ(base.height, 3u);
  EXPECT_EQ(base.at(0, 0)[3], 128);
  EXPECT_EQ(m.base_color_texture.texcoord, 1u);
  EXPECT_EQ(m.base_color_texture.wrap_s, Wrap::repeat);
  EXPECT_FALSE(m.base_color_texture.nearest);
  EXPECT_EQ(scene.images.at(m.normal_texture.image).width, 2u);
  EXPECT_EQ(m.normal_texture.wrap_s, Wrap::clamp);
  EXPECT_EQ(m.normal_texture.wrap_t, Wrap::mirror);
  EXPECT_TRUE(m.normal_texture.nearest);
  EXPECT_EQ(m.normal_scale, 0.5f);
  EXPECT_EQ(m.occlusion_texture.image, m.base_color_texture.image);
  EXPECT_EQ(m.occlusion_strength, 0.25f);
  EXPECT_EQ(m.emissive_texture.offset, vec2(0.1f, 0.2f));
  EXPECT_EQ(m.emissive_texture.rotation, 0.3f);
  EXPECT_EQ(m.emissive_texture.scale, vec2(2, 3));
  EXPECT_EQ(m.emissive_texture.texcoord, 1u);

  b.json["samplers"][0]["wrapS"] = 1;
  expect_contains(load_error(b), "sampler 0: \"wrapS\" 1 is not a wrapping mode");
  b.json["materials"][0]["normalTexture"]["index"] = 2;
  expect_contains(load_error(b), "material 0: \"index\" is 2, but the file has only 2");
}

TEST(GltfMaterial, WhatCannotBeShownIsNamed) {
  GltfBuilder b = with_material(
      {{"normalTexture", {{"index", 0}}}, {"emissiveTexture", {{"index", 1}, {"texCoord", 2}}}});
  add_image(b, png(1, 1, {0, 0, 0, 0}));
  b.add("textures", {{"extensions", {{"KHR_texture_basisu", {{"source", 0}}}}}});
  b.add("textures", {{"source", 0}});
  const Scene scene = load_or_fail(b);
  EXPECT_TRUE(scene.images.empty());
  ASSERT_EQ(scene.warnings.size(), 2u);
  expect_contains(scene.warnings[0], "texture 0: has no image in a supported format");
  expect_contains(scene.warnings[1], "material 0: a texture uses TEXCOORD_2 or higher");
}

TEST(GltfMaterial, ImagesInFilesAndUris) {
  GltfBuilder b =
      with_material({{"normalTexture", {{"index", 0}}}, {"emissiveTexture", {{"index", 1}}}});
  const std::string bytes = png(2, 2, {1, 2, 3, 4});
  b.add("images", {{"uri", "tex/my%20image.png"}});
  b.add("images", {{"uri", "data:image/png;base64," + GltfBuilder::base64(bytes)}});
  b.add("textures", {{"source", 0}});
  b.add("textures", {{"source", 1}});
  const TemporaryFolder folder;
  const std::string path = folder.write("a.gltf", b.gltf());
  const Result<Scene> missing = load_gltf(path);
  ASSERT_FALSE(missing);
  expect_contains(missing.error().message(), "a.gltf: image 0: cannot read \"tex/my image.png\"");
  folder.write("tex/my image.png", bytes);
  const Result<Scene> scene = load_gltf(path);
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(scene->images.at(0).pixels, scene->images.at(1).pixels);
  folder.write("tex/my image.png", bytes.substr(0, 40));
  const Result<Scene> damaged = load_gltf(path);
  ASSERT_FALSE(damaged);
  EXPECT_EQ(damaged.error().element, "image 0");
}

TEST(GltfMaterial, SpecularGlossinessBecomesMetallicRoughness) {
  const auto converted = [](const json& extension) {
    return load_or_fail(with_material(
                            {{"extensions", {{"KHR_materials_pbrSpecularGlossiness", extension}}}}))
        .materials.at(0);
  };
  // A specular colour of 4% is a plain non-metal: the diffuse colour stays.
  const Material plastic = converted({{"diffuseFactor", {0.5, 0.25, 0.125, 0.75}},
                                      {"specularFactor", {0.04, 0.04, 0.04}},
                                      {"glossinessFactor", 0.75}});
  EXPECT_NEAR(plastic.base_color.r, 0.5f, 1e-5f);
  EXPECT_NEAR(plastic.base_color.b, 0.125f, 1e-5f);
  EXPECT_EQ(plastic.base_color.a, 0.75f);
  EXPECT_NEAR(plastic.metallic, 0.0f, 1e-5f);
  EXPECT_FLOAT_EQ(plastic.roughness, 0.25f);
  // No diffuse but a strong specular colour is a metal of that colour.
  const Material gold =
      converted({{"diffuseFactor", {0, 0, 0, 1}}, {"specularFactor", {1.0, 0.8, 0.3}}});
  EXPECT_NEAR(gold.metallic, 1.0f, 1e-5f);
  EXPECT_NEAR(gold.base_color.g, 0.8f, 1e-5f);
  EXPECT_FLOAT_EQ(gold.roughness, 0.0f);
}

TEST(GltfMaterial, SpecularGlossinessTexturesAreConvertedByPixel) {
  GltfBuilder b = with_material({{"extensions",
                                  {{"KHR_materials_pbrSpecularGlossiness",
                                    {{"diffuseTexture", {{"index", 0}}},
                                     {"specularGlossinessTexture", {{"index", 1}}},
                                     {"glossinessFactor", 0.5}}}}}});
  add_image(b, png(4, 2, {200, 100, 50, 90}));
  add_image(b, png(1, 1, {0, 0, 0, 102}));  // no specular: a non-metal; glossiness 0.4 * 0.5
  b.add("textures", {{"source", 0}});
  b.add("textures", {{"source", 1}});
  const Scene scene = load_or_fail(b);
  const Material& m = scene.materials.at(0);
  const Image8& base = scene.images.at(m.base_color_texture.image);
  const Image8& surface = scene.images.at(m.metallic_roughness_texture.image);
  EXPECT_EQ(base.width, 4u);
  EXPECT_EQ(surface.height, 2u);
  EXPECT_EQ(base.at(3, 1)[3], 90);
  // Without specular, 1 / 0.96 more is left for diffuse: 200 of 255 in sRGB becomes 203.4.
  EXPECT_NEAR(base.at(3, 1)[0], 203, 1);
  EXPECT_EQ(surface.at(3, 1)[1], 204);  // roughness 0.8
  EXPECT_EQ(surface.at(3, 1)[2], 0);
}

}  // namespace
}  // namespace sinew
