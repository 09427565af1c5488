// AFF files that are cut off, damaged or meant to harm.
#include <gtest/gtest.h>

#include <filesystem>

#include "io/hostile.h"
#include "sinew/io/aff/aff.h"
#include "sinew/io/load.h"

namespace sinew {
namespace {

// Every statement there is, in few bytes.
const std::string kEverything =
    "v from 0 0 5 at 0 0 0 up 0 1 0 angle 45 hither 1 resolution 4 3\n"
    "b 0 0 1 am 1 1 1 d 2 l 1 2 3 la lamp 1 2 3 1 1 1\n"
    "f 1 1 1 .5 .5 9 .5 1.5 fm 1 1 1 1 1 1 0 0 0 9 0 0 # c\n"
    "s 0 0 0 1 c 0 0 0 1 0 0 1 0 p 3 0 0 0 1 0 0 0 1 0\n"
    "pp 3 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1 i 0 b.aff\n"
    "tt t.ppm 0 0 0 0 1 1 0 0 1 1 0 1 0 1 0\n"
    "ttp t.ppm 0 0 0 0 0 1 0 1 1 0 0 0 0 1 1 1 0 1 0 0 0 1 1 0\n"
    "tpa 2 0 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1 1 0 0 0 0 0 1 1 0 2 0 0 1 0 1 0 0 0 1\n"
    "x n { xs 1 2 1 0 0 1 90 0 0 0 { m vertices 3 0 0 0 1 0 0 0 1 0 normals 1 0 0 1\n"
    "texturecoords 1 t.ppm 0 0 triangles 1 0 1 2 0 0 0 0 0 0 } } a 0 1 9\n"
    "k n { transl 4 0 0 0 0 0 0 0 1 0 0 0 0 0 0 2 7 0 0 .5 0 .5 3 7 0 0 0 0 0\n"
    "rot 4 0 0 1 0 90 0 0 0 1 0 1 0 90 0 0 0 2 1 0 0 9 0 0 0 3 0 1 0 90 0 0 0\n"
    "scale 4 0 1 1 1 0 0 0 1 1 1 1 0 0 0 2 3 3 3 0 0 0 3 3 3 3 0 0 0 visibility 1 0 1 }\n";

const std::string kPpm = std::string("P6 1 1 255\n") + "abc";

struct AffHostileTest : testing::Test {
  TemporaryFolder folder;
  AffHostileTest() {
    folder.write("aff/b.aff", "s 1 0 0 1\n");
    folder.write("TextureFiles/t.ppm", kPpm);
  }
  Result<Scene> load(const std::string& text, const LoadOptions& options = {}) {
    return sinew::load(folder.write("aff/top.aff", text), options);
  }
  void expect_sound(const Result<Scene>& scene) {
    if (scene) {
      EXPECT_EQ(validate(*scene), "");
      return;
    }
    EXPECT_EQ(scene.error().kind, ErrorKind::bad_input) << scene.error().message();
    EXPECT_FALSE(scene.error().problem.empty());
    EXPECT_FALSE(scene.error().file.empty());
  }
  void expect_error(const std::string& text, const std::string& part) {
    const Result<Scene> scene = load(text);
    ASSERT_FALSE(scene) << text;
    expect_sound(scene);
    EXPECT_NE(scene.error().message().find(part), std::string::npos) << scene.error().message();
  }
};

using AffHostile = AffHostileTest;

TEST_F(AffHostile, TheWholeFileIsSound) {
  const Result<Scene> scene = load(kEverything);
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(validate(*scene), "");
  EXPECT_TRUE(scene->warnings.empty()) << scene->warnings[0];
  EXPECT_EQ(scene->meshes.size(), 4u);
}

TEST_F(AffHostile, TruncationsOfEveryLength) {
  for_every_truncation(kEverything, [&](const std::string& text) { expect_sound(load(text)); });
}

TEST_F(AffHostile, ChangedBytes) {
  for_random_patches(kEverything, 1000, 5,
                     [&](const std::string& text) { expect_sound(load(text)); });
}

TEST_F(AffHostile, TruncatedAndChangedTextures) {
  const std::string use = "tt u.ppm 0 0 0 0 1 1 0 0 1 1 0 1 0 1 0\n";
  const auto read = [&](const std::string& bytes) {
    folder.write("TextureFiles/u.ppm", bytes);
    expect_sound(load(use));
  };
  for_every_truncation(kPpm, read);
  for_random_patches(kPpm, 300, 6, read);
}

TEST_F(AffHostile, IncludesThatDoNotEnd) {
  expect_error("i 0 top.aff", "includes itself");
  folder.write("aff/c.aff", "i 0 d.aff");
  folder.write("aff/d.aff", "\n i 0 c.aff");
  const Result<Scene> cycle = load("i 0 c.aff");
  ASSERT_FALSE(cycle);
  EXPECT_NE(cycle.error().file.find("d.aff"), std::string::npos);
  EXPECT_EQ(cycle.error().element, "line 2");

  for (int i = 0; i < 40; ++i) {
    folder.write("aff/deep" + std::to_string(i) + ".aff",
                 "i 0 deep" + std::to_string(i + 1) + ".aff");
  }
  expect_error("i 0 deep0.aff", "deep");
}

TEST_F(AffHostile, IncludesThatMultiply) {
  for (int i = 0; i < 20; ++i) {
    std::string text;
    for (int k = 0; k < 10; ++k) text += "i 0 wide" + std::to_string(i + 1) + ".aff\n";
    folder.write("aff/wide" + std::to_string(i) + ".aff", text);
  }
  folder.write("aff/wide20.aff", "# nothing\n");
  expect_error("i 0 wide0.aff", "files are included");
  folder.write("aff/wide4.aff", "s 0 0 0 1\n");
  const Result<Scene> scene = load("i 0 wide0.aff", {.memory_limit = 20 << 20});
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().problem.find("memory limit"), std::string::npos);
}

TEST_F(AffHostile, FilesThatAreMissingOrLieElsewhere) {
  expect_error("i 0 missing.aff", "missing");
  folder.write("other.aff", "s 0 0 0 1\n");
  expect_error("i 0 ../other.aff", "outside");
  expect_error("i 0 /etc/passwd", "outside");
  std::filesystem::create_symlink(folder.path("other.aff"), folder.path("aff/link.aff"));
  expect_error("i 0 link.aff", "outside");
  EXPECT_FALSE(load_aff(folder.path("aff/none.aff"), {}, {}));
  EXPECT_FALSE(load_aff(folder.path("aff"), {}, {}));
}

TEST_F(AffHostile, AbsurdCountsAndNumbers) {
  expect_error("p 4000000000 0 0 0", "claims");
  expect_error("p -3", "claims");
  expect_error("p 2 0 0 0 0 0 0", "2 corners");
  expect_error("p 1.5", "whole number");
  expect_error("m vertices 900000000 0 0 0", "more than the rest of the file");
  expect_error("m vertices 1 0 0 0 triangles 1 0 0 1", "vertex 1 is asked for where 1 exist");
  expect_error("m vertices 1 0 0 0 triangles 1 0 0 -1", "vertex -1");
  expect_error("tpa 1000000000 0", "claims");
  expect_error("tpa 2 1 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1 1 0 0 0 0 0 1 1 0 2 0 0 1 0 1 0 0 0 1",
               "do not increase");
  expect_error("s 0 0 0 nan", "number");
  expect_error("s 0 0 0 1e999", "finite");
  expect_error("s 0 0 0 0", "radius 0");
  expect_error("c 1 1 1 1 1 1 1 2", "one point");
  expect_error("xs 1e30 1 1 0 0 1 0 0 0 0 { xs 1e30 1 1 0 0 1 0 0 0 0 { s 0 0 0 1 } }",
               "positions");
  expect_error("a 0 1 100000000", "frames");
  expect_error("a 1 0 10", "before it starts");
  expect_error("a 0 1e-300 1000", "frames a second");
  expect_error("xs 1 1 1 0 0 0 90 0 0 0 { }", "without direction");
  expect_error("v from 0 0 0 at 0 0 0 up 0 1 0 angle 45 hither 1 resolution 1 1", "no direction");
  expect_error("v from 0 0 0 at 0 0 1 up 0 1 0 angle 180 hither 1 resolution 1 1", "180 degrees");
}

TEST_F(AffHostile, KeyframesThatMakeNoSense) {
  expect_error("k n { transl 3 0 0 0 0 0 0 0 1 0 0 0 0 0 0 2 7 0 0 0 0 0 }", "3 keys");
  expect_error("k n { warp 4 }", "\"warp\"");
  expect_error("k n { visibility 1 0 1 visibility 1 0 1 }", "two sets");
  expect_error("k n { visibility 2 1 1 0 1 }", "back in time");
  expect_error("k n { visibility 0 }", "at least 1");
  expect_error("k n { transl 4 0 0 0 0 0 0 0 0 0 0 0 0 0 0 1e-30 1e30 0 0 0 0 0 1 0 0 0 0 0 0 }",
               "leaves the range");
  expect_error("k n {", "ends where");
  expect_error("k { visibility 1 0 1 }", "name of a transform");
}

TEST_F(AffHostile, BracesThatDoNotMatch) {
  expect_error("}", "not open");
  expect_error("\nx n {\n s 0 0 0 1", "braces of line 2");
  folder.write("aff/close.aff", "}");
  expect_error("x n { i 0 close.aff }", "not open");
  std::string deep;
  for (int i = 0; i < 3000; ++i) deep += "xs 1 1 1 0 0 1 0 0 0 0 {";
  expect_error(deep, "too deep");
  expect_error("hello", "no statement");
  expect_error(std::string("\x01\xff\x00z", 4), "no statement");
}

TEST_F(AffHostile, KeysThatMoveTooMuch) {
  std::string text;
  for (int i = 0; i < 2000; ++i) text += "x n { }\n";
  text += "k n { transl 2000\n";
  for (int i = 0; i < 2000; ++i) text += std::to_string(i) + " 0 0 0 0 0 0\n";
  const Result<Scene> scene = load(text + "}", {.memory_limit = 100 << 20});
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message().find("keyframes \"n\""), std::string::npos);
}

// Each key that turns sharply becomes up to 256 of the channel.
TEST_F(AffHostile, RotationsThatTakeTooMuch) {
  std::string text = "x n { s 0 0 0 1 }\nk n { rot 3000\n";
  for (int i = 0; i < 3000; ++i) {
    text += std::to_string(i) + (i % 2 == 0 ? " 1 0 0 3 0 0 0\n" : " 0 1 1 179 0 0 0\n");
  }
  EXPECT_TRUE(load(text + "}"));
  const Result<Scene> scene = load(text + "}", {.memory_limit = 4 << 20});
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().problem.find("3000 keys"), std::string::npos);
}

TEST_F(AffHostile, WarningsDoNotPileUp) {
  std::string text;
  for (int i = 0; i < 1000; ++i) text += "k n" + std::to_string(i) + " { visibility 1 0 1 }\n";
  const Result<Scene> scene = load(text);
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_LE(scene->warnings.size(), 200u);
  text.clear();
  for (int i = 0; i < 1000; ++i) {
    text += "tt " + std::to_string(i) + ".ppm 0 0 0 0 1 1 0 0 1 1 0 1 0 1 0\n";
  }
  expect_error(text, "missing");
}

TEST_F(AffHostile, TheMemoryLimitHolds) {
  std::string text;
  for (int i = 0; i < 1000; ++i) text += "s 0 0 0 1\n";
  EXPECT_TRUE(load(text));
  const Result<Scene> scene = load(text, {.memory_limit = 1 << 20});
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().problem.find("memory limit"), std::string::npos);
  EXPECT_FALSE(load(text, {.memory_limit = 100}));
}

TEST_F(AffHostile, ImagesAndTrianglesShareTheMemoryLimit) {
  folder.write("TextureFiles/u.ppm", "P6 512 512 255\n" + std::string(3 * 512 * 512, 'x'));
  const std::string image = "tt u.ppm 0 0 0 0 1 1 0 0 1 1 0 1 0 1 0\n";  // 1 MiB
  std::string spheres;                                                   // about 3 MB
  for (int i = 0; i < 20; ++i) spheres += "s 0 0 0 1\n";
  const LoadOptions limit{.memory_limit = 3'800'000};
  EXPECT_TRUE(load(image, limit));
  EXPECT_TRUE(load(spheres, limit));
  EXPECT_FALSE(load(image + spheres, limit));
  EXPECT_FALSE(load(spheres + image, limit));
}

}  // namespace
}  // namespace sinew
