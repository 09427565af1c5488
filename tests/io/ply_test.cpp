#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "io/hostile.h"
#include "sinew/io/image_file.h"
#include "sinew/io/load.h"
#include "sinew/io/ply/parse.h"

namespace sinew {
namespace {

// Writes bodies in the form that the header says.
class PlyWriter {
 public:
  enum Form { ascii, little, big };
  explicit PlyWriter(Form form) : form_(form) {
    static constexpr std::array kNames = {"ascii", "binary_little_endian", "binary_big_endian"};
    text_ = fmt::format("ply\nformat {} 1.0\ncomment made by a test\n", kNames[form]);
  }
  PlyWriter& header(const std::string& line) {
    text_ += line + "\n";
    return *this;
  }
  template <class T>
  PlyWriter& add(T value) {
    if (form_ == ascii) {
      text_ += fmt::format("{} ", value);
      return *this;
    }
    std::string bytes(reinterpret_cast<const char*>(&value), sizeof(T));
    if (form_ == big) std::reverse(bytes.begin(), bytes.end());
    text_ += bytes;
    return *this;
  }
  const std::string& text() const { return text_; }

 private:
  Form form_;
  std::string text_;
};

// A unit square as a quad, with everything a vertex can have in an unusual order and types, and
// with properties and elements that mean nothing to us.
std::string square(PlyWriter::Form form) {
  PlyWriter w(form);
  w.header("obj_info scanned").header("element vertex 4").header("property uchar red");
  w.header("property uchar green").header("property uchar blue").header("property double z");
  w.header("property list uchar short memory")
      .header("property short x")
      .header("property float y");
  w.header("property float nx").header("property float ny").header("property float nz");
  w.header("property float s").header("property double t");
  w.header("element camera 1").header("property float view");
  w.header("element face 2").header("property uchar flags");
  w.header("property list ushort int vertex_indices").header("end_header");
  for (int i = 0; i < 4; ++i) {
    const int x = i == 1 || i == 2, y = i / 2;
    w.add(uint8_t{255}).add(uint8_t{0}).add(static_cast<uint8_t>(50 * i)).add(0.5);
    w.add(static_cast<uint8_t>(i));
    for (int k = 0; k < i; ++k) w.add(static_cast<int16_t>(-k));
    w.add(static_cast<int16_t>(x)).add(static_cast<float>(y));
    w.add(0.0f).add(0.0f).add(2.0f).add(static_cast<float>(x)).add(static_cast<double>(y));
  }
  w.add(1.0f);
  w.add(uint8_t{7}).add(uint16_t{4});
  for (int i = 0; i < 4; ++i) w.add(int32_t{i});
  w.add(uint8_t{7}).add(uint16_t{2}).add(int32_t{0}).add(int32_t{1});
  return w.text();
}

struct PlyTest : testing::Test {
  TemporaryFolder folder;
  Result<Scene> read(const std::string& bytes, const LoadOptions& options = {}) const {
    return load(folder.write("a.ply", bytes), options);
  }
  Scene expect_scene(const std::string& bytes) const {
    auto scene = read(bytes);
    EXPECT_TRUE(scene) << scene.error().message();
    if (!scene) return {};
    EXPECT_EQ(validate(*scene), "");
    return std::move(*scene);
  }
  void expect_error(const std::string& bytes, const std::string& part,
                    const LoadOptions& options = {}) const {
    const auto scene = read(bytes, options);
    ASSERT_FALSE(scene) << part;
    EXPECT_EQ(scene.error().kind, ErrorKind::bad_input);
    EXPECT_EQ(scene.error().file, folder.path("a.ply"));
    EXPECT_NE(scene.error().message().find(part), std::string::npos) << scene.error().message();
  }
};

using Ply = PlyTest;

const std::string kStart = "ply\nformat ascii 1.0\n";
const std::string kXyz = "property float x\nproperty float y\nproperty float z\n";
const std::string kFaces = "property list uchar int vertex_index\nend_header\n";

// Three vertices of a triangle and the given faces.
std::string with_faces(int count, const std::string& faces) {
  return kStart + "element vertex 3\n" + kXyz + fmt::format("element face {}\n", count) + kFaces +
         "0 0 0\n1 0 0\n0 1 0\n" + faces;
}

TEST_F(Ply, EveryFormHoldsTheSameMesh) {
  for (const auto form : {PlyWriter::ascii, PlyWriter::little, PlyWriter::big}) {
    SCOPED_TRACE(form);
    const Scene scene = expect_scene(square(form));
    ASSERT_EQ(scene.meshes.size(), 1u);
    const Mesh& mesh = scene.meshes[0];
    EXPECT_EQ(scene.name, "a");
    EXPECT_EQ(mesh.positions,
              (std::vector<vec3>{{0, 0, 0.5f}, {1, 0, 0.5f}, {1, 1, 0.5f}, {0, 1, 0.5f}}));
    EXPECT_EQ(mesh.triangles, (std::vector<uvec3>{{0, 1, 2}, {0, 2, 3}}));
    EXPECT_TRUE(mesh.corners.empty());
    EXPECT_EQ(mesh.normals, std::vector<vec3>(4, vec3(0, 0, 1)));
    EXPECT_EQ(mesh.texcoords[0], (std::vector<vec2>{{0, 1}, {1, 1}, {1, 0}, {0, 0}}));
    ASSERT_EQ(mesh.colors.size(), 4u);
    EXPECT_EQ(mesh.colors[3].x, 1.0f);
    EXPECT_EQ(mesh.colors[3].y, 0.0f);
    EXPECT_NEAR(mesh.colors[3].z, 0.3050f, 1e-3f);  // 150 of 255 in sRGB
    EXPECT_EQ(scene.warnings, (std::vector<std::string>{
                                  "properties of \"vertex\" are not supported: memory: ignored",
                                  "properties of \"camera\" are not supported: view: ignored",
                                  "properties of \"face\" are not supported: flags: ignored",
                                  "1 faces have fewer than 3 corners: left out"}));
    expect_error(square(form), "not supported: memory", {.strict = true});
  }
}

TEST_F(Ply, FloatColoursAndLineEnds) {
  for (const std::string end : {"\n", "\r\n", "\r"}) {
    std::string text =
        "ply\nformat ascii 1.0\nelement vertex 3\n" + kXyz +
        "property float red\nproperty float green\nproperty float blue\nproperty float alpha\n"
        "element face 1\n" +
        kFaces + "0 0 0 1 0.5 0 1\n1 0 0 2 0 0 1\n0 1 0 0 0 0 1\n3 0 1 2";
    for (size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += end.size()) {
      text.replace(at, 1, end);
    }
    const Scene scene = expect_scene(text);
    EXPECT_TRUE(scene.warnings.empty());
    ASSERT_EQ(scene.meshes[0].colors.size(), 3u);
    EXPECT_NEAR(scene.meshes[0].colors[0].y, 0.2140f, 1e-3f);
    EXPECT_EQ(scene.meshes[0].colors[1].x, 1.0f);
  }
}

TEST_F(Ply, TextureCoordinatesAtCornersAndATexture) {
  ASSERT_TRUE(write_png(folder.path("skin.png"), Image8{2, 2, std::vector<uint8_t>(16, 100)}));
  const std::string text = kStart + "comment TextureFile skin.png\nelement vertex 3\n" + kXyz +
                           "element face 2\nproperty list uchar float texcoord\n" + kFaces +
                           "0 0 0\n1 0 0\n0 1 0\n6 0 0 1 0 0 1 3 0 1 2\n0 3 0 2 1\n";
  const Scene scene = expect_scene(text);
  EXPECT_TRUE(scene.warnings.empty());
  const Mesh& mesh = scene.meshes[0];
  ASSERT_EQ(mesh.corners.size(), 2u);
  EXPECT_EQ(mesh.texcoords[0][mesh.corners[0].z], vec2(0, 0));
  ASSERT_EQ(scene.images.size(), 1u);
  EXPECT_EQ(scene.materials[0].base_color_texture.image, 0);

  std::string outside = text;
  outside.replace(outside.find("skin.png"), 8, "../x.png");
  expect_error(outside, "outside the asset's folder");
  std::string few = text;
  few.replace(few.find("6 0 0 1 0 0 1"), 13, "4 0 0 1 0");
  expect_error(few, "face 0: has 2 texture coordinates for");
}

TEST_F(Ply, Strips) {
  const std::string text = kStart + "element vertex 5\n" + kXyz +
                           "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
                           "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n11 0 1 2 3 -1 2 2 2 3 4 -1\n";
  EXPECT_EQ(expect_scene(text).meshes[0].triangles,
            (std::vector<uvec3>{{0, 1, 2}, {2, 1, 3}, {2, 3, 4}}));
}

TEST_F(Ply, FacesMayStandBeforeVerticesAndNormalsBeLost) {
  const std::string text = kStart +
                           "element face 1\nproperty list uchar uint vertex_indices\n"
                           "element vertex 3\n" +
                           kXyz +
                           "property float nx\nproperty float ny\nproperty float nz\nend_header\n"
                           "3 0 1 2\n0 0 0 nan nan nan\n1 0 0 0 0 0\n0 1 0 0 1 0\n";
  const Scene scene = expect_scene(text);
  EXPECT_EQ(scene.warnings.size(), 1u);
  const Mesh& mesh = scene.meshes[0];
  EXPECT_EQ(mesh.normals[mesh.corner_of(0).x], vec3(0, 0, 1));
  EXPECT_EQ(mesh.normals[mesh.corner_of(0).z], vec3(0, 1, 0));
}

TEST_F(Ply, SequencesAndCacheBases) {
  folder.write("w1.ply", with_faces(1, "3 0 1 2"));
  folder.write("w2.ply", with_faces(1, "3 0 1 2"));
  const auto scene = load(folder.path("w#.ply"));
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(scene->meshes[0].keys, 2u);
  std::string cache("POINTCACHE2\0\1\0\0\0\3\0\0\0\0\0\0\0\0\0\x80\x3f\1\0\0\0", 32);
  folder.write("c.pc2", cache + std::string(36, '\0'));
  const auto cached = load(folder.path("w1.ply") + "+c.pc2");
  ASSERT_TRUE(cached) << cached.error().message();
  EXPECT_EQ(cached->meshes[0].keys, 1u);
}

TEST_F(Ply, ErrorsSayWhatAndWhere) {
  const std::string end = "end_header\n";
  const struct {
    std::string text, problem;
  } cases[] = {
      {"", "is no PLY file"},
      {"plyx", "is no PLY file"},
      {"ply\n", "no end_header"},
      {"ply\nend_header\n", "line 2: the header names no format"},
      {"ply\nformat binary 1.0\n", "line 2: the format \"binary\""},
      {"ply\nformat ascii 2.0\n", "version \"2.0\""},
      {kStart + "property float x\n", "before the first element"},
      {kStart + "element vertex -1\n", "line 3: an element needs a name and a count"},
      {kStart + "element vertex 99999999999999999999\n", "needs a name and a count"},
      {kStart + "element a 1\nelement a 1\n", "\"a\" stands twice"},
      {kStart + "element a 1\nproperty half x\n", "\"half\" is not a type"},
      {kStart + "element a 1\nproperty list float int x\n", "must be an integer"},
      {kStart + "elephant\n", "\"elephant\""},
      {kStart + end, "holds no mesh"},
      {kStart + "element vertex 1\n" + end, "vertices need the properties x"},
      {kStart + "element vertex 1\n" + kXyz + end + "0 0 0\n", "is a point cloud"},
      {kStart + "element vertex 1\n" + kXyz + end + "0 zero 0\n",
       "vertex 0: \"zero\" is not a number"},
      {kStart + "element vertex 1\n" + kXyz + end + "0 nan 0\n", "is not finite"},
      {kStart + "element vertex 1\n" + kXyz + end + "0 1e99 0\n", "is not finite"},
      {kStart + "element vertex 18446744073709551615\n" + kXyz + end + "0 0 0\n", "cannot hold"},
      {with_faces(0, ""), "is a point cloud"},
      {with_faces(1, "2 0 1"), "no face of three"},
      {with_faces(1, "3 0 1 3"), "triangle 0: vertex 3 does not exist: there are 3"},
      {with_faces(1, "3 0 1 -1"), "face 0: -1 is not a vertex"},
      {with_faces(1, "3 0 1 0.5"), "face 0: 0.5 is not a vertex"},
      {with_faces(1, "-1 0 1 0"), "cannot have -1 entries"},
      {with_faces(1, "200 0 1 0"), "cannot have 200 entries"},
      {with_faces(2, "3 0 1 2\n3 0 1"), "cut off"},
      {with_faces(1000000000, "3 0 1 2\n"), "element face: the file is cut off"},
  };
  for (const auto& c : cases) expect_error(c.text, c.problem);
  expect_error(square(PlyWriter::little), "memory limit", {.memory_limit = 700});
}

TEST_F(Ply, AnElementWithoutPropertiesCostsNothing) {
  const Scene scene =
      expect_scene(kStart + "element nothing 18446744073709551615\nelement vertex 3\n" + kXyz +
                   "element face 1\n" + kFaces + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2");
  EXPECT_EQ(scene.meshes[0].triangles.size(), 1u);
}

void check_result(const Result<Scene>& scene) {
  if (scene) {
    EXPECT_EQ(validate(*scene), "");
  } else {
    EXPECT_EQ(scene.error().kind, ErrorKind::bad_input);
    EXPECT_FALSE(scene.error().problem.empty());
  }
}

TEST_F(Ply, TruncationsAreErrors) {
  for (const auto form : {PlyWriter::ascii, PlyWriter::little, PlyWriter::big}) {
    const std::string whole = square(form);
    for_every_truncation(whole, [&](const std::string& bytes) {
      const auto scene = read(bytes);
      // The last face of the text has no effect, and text may lose its last blank or digit.
      if (form == PlyWriter::ascii && bytes.size() + 2 >= whole.size()) return;
      EXPECT_FALSE(scene);
      check_result(scene);
    });
  }
}

TEST_F(Ply, RandomPatchesGiveAValidSceneOrAnError) {
  for (const auto form : {PlyWriter::ascii, PlyWriter::little, PlyWriter::big}) {
    for_random_patches(square(form), 1500, 17, [&](const std::string& bytes) {
      check_result(read(bytes, {.memory_limit = uint64_t{1} << 20}));
    });
  }
}

}  // namespace
}  // namespace sinew
