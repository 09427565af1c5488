#include "sinew/io/vertex_cache.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "io/hostile.h"
#include "sinew/scene/sample.h"
#include "test_data.h"

namespace sinew {
namespace {

template <class T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

std::string header(int32_t version, int32_t points, float start, float rate, int32_t samples) {
  std::string bytes("POINTCACHE2\0", 12);
  append(bytes, version);
  append(bytes, points);
  append(bytes, start);
  append(bytes, rate);
  append(bytes, samples);
  return bytes;
}

constexpr char kBase[] =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nvn 0 0 1\nvt 0 0\nf 1/1/1 2/1/1 3/1/1\n";

// Sample i lifts the four points of kBase to z = i.
std::string make_pc2(int32_t samples, float rate = 2.0f) {
  std::string bytes = header(1, 4, 10.0f, rate, samples);
  for (int32_t i = 0; i < samples; ++i) {
    for (const vec2 p : {vec2(0, 0), vec2(1, 0), vec2(0, 1), vec2(5, 5)}) {
      append(bytes, vec3(p, static_cast<float>(i)));
    }
  }
  return bytes;
}

struct VertexCacheTest : testing::Test {
  TemporaryFolder folder;
  Result<Scene> load(const std::string& pc2, const LoadOptions& options = {}) {
    return load_vertex_cache(folder.write("base.obj", kBase), folder.write("a.pc2", pc2), options);
  }
};

using Pc2 = VertexCacheTest;

TEST_F(Pc2, SamplesBecomeKeysAndAClip) {
  const auto scene = load(make_pc2(4));
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(validate(*scene), "");
  EXPECT_TRUE(scene->warnings.empty());
  EXPECT_EQ(scene->meshes[0].keys, 4u);
  EXPECT_TRUE(scene->meshes[0].normals.empty()) << "they fit one pose only";
  ASSERT_EQ(scene->clips.size(), 1u);
  EXPECT_EQ(scene->clips[0].name, "cache");
  EXPECT_EQ(scene->clips[0].start, 0.0);
  EXPECT_FLOAT_EQ(static_cast<float>(scene->clips[0].end), 3 * 2.0f / 24.0f);
  EXPECT_EQ(scene->default_frames, 7);

  ScenePose pose;
  std::vector<vec3> positions(4);
  for (const float sample_at : {0.0f, 1.0f, 1.25f, 3.0f, 4.0f}) {
    sample(*scene, 0, sample_at * 2.0 / 24.0, pose);
    world_positions(*scene, pose, 0, positions);
    EXPECT_NEAR(positions[1].z, std::min(sample_at, 3.0f), 1e-5f);
    EXPECT_EQ(positions[3].x, 5.0f);
  }
}

TEST_F(Pc2, OneSampleIsEnough) {
  const auto scene = load(make_pc2(1));
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(validate(*scene), "");
  EXPECT_EQ(scene->clips[0].end, 0.0);
}

TEST_F(Pc2, TrailingBytesWarn) {
  const auto scene = load(make_pc2(2) + "xyz");
  ASSERT_TRUE(scene);
  ASSERT_EQ(scene->warnings.size(), 1u);
  EXPECT_EQ(scene->warnings[0], "3 bytes after the last sample: ignored");
}

TEST_F(Pc2, EveryTruncationIsAnError) {
  for_every_truncation(make_pc2(3), [&](const std::string& bytes) {
    const auto scene = load(bytes);
    ASSERT_FALSE(scene);
    EXPECT_EQ(scene.error().kind, ErrorKind::bad_input);
    EXPECT_EQ(scene.error().file, folder.path("a.pc2"));
  });
}

TEST_F(Pc2, RandomPatchesGiveAValidSceneOrAnError) {
  for_random_patches(make_pc2(3), 4000, 41, [&](const std::string& bytes) {
    const auto scene = load(bytes);
    if (scene) {
      EXPECT_EQ(validate(*scene), "");
    } else {
      EXPECT_EQ(scene.error().kind, ErrorKind::bad_input);
    }
  });
}

TEST_F(Pc2, NonsenseIsNamed) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  std::string not_finite = make_pc2(2);
  std::memcpy(not_finite.data() + 32 + 12 * (4 + 2) + 4, &kNan, 4);
  struct Case {
    std::string bytes;
    const char* problem;
  };
  const Case cases[] = {
      {"", "no PC2"},
      {std::string(100, 'x'), "no PC2"},
      {header(2, 4, 0, 1, 1) + std::string(48, '\0'), "version 2"},
      {header(1, 0, 0, 1, 1), "0 points"},
      {header(1, -4, 0, 1, -1) + std::string(48, '\0'), "-4 points"},
      {header(1, 0x7fffffff, 0, 1, 0x7fffffff) + std::string(48, '\0'), "cut off"},
      {header(1, 4, kNan, 1, 1) + std::string(48, '\0'), "frame range"},
      {header(1, 4, 0, 0, 1) + std::string(48, '\0'), "frame range"},
      {header(1, 4, 0, -1, 1) + std::string(48, '\0'), "frame range"},
      {header(1, 4, 0, 3e38f, 3) + std::string(144, '\0'), "sample rate"},
      {header(1, 4, 0, 1e-45f, 3) + std::string(144, '\0'), "sample rate"},
      {header(1, 3, 0, 1, 1) + std::string(36, '\0'), "3 points, but"},
      {not_finite, "sample 1: point 2 is not finite"},
  };
  for (const Case& c : cases) {
    const auto scene = load(c.bytes);
    ASSERT_FALSE(scene) << c.problem;
    EXPECT_EQ(scene.error().kind, ErrorKind::bad_input);
    EXPECT_NE(scene.error().message().find(c.problem), std::string::npos)
        << scene.error().message();
  }
  EXPECT_FALSE(load(make_pc2(3), {.memory_limit = 300}));
}

template <class T>
void append_turned(std::string& bytes, T value) {
  std::string turned;
  append(turned, value);
  bytes.append(turned.rbegin(), turned.rend());
}

// Sample i lifts the four points of kBase to z = i.
std::string make_mdd(const std::vector<float>& times) {
  std::string bytes;
  append_turned(bytes, static_cast<int32_t>(times.size()));
  append_turned(bytes, int32_t{4});
  for (const float time : times) append_turned(bytes, time);
  for (size_t i = 0; i < times.size(); ++i) {
    for (const vec2 p : {vec2(0, 0), vec2(1, 0), vec2(0, 1), vec2(5, 5)}) {
      append_turned(bytes, p.x);
      append_turned(bytes, p.y);
      append_turned(bytes, static_cast<float>(i));
    }
  }
  return bytes;
}

struct MddTest : testing::Test {
  TemporaryFolder folder;
  Result<Scene> load(const std::string& mdd, const LoadOptions& options = {}) {
    return load_vertex_cache(folder.write("base.obj", kBase), folder.write("a.mdd", mdd), options);
  }
};

using Mdd = MddTest;

TEST_F(Mdd, SamplesAreAtTheFilesOwnTimes) {
  const auto scene = load(make_mdd({0.5f, 1.0f, 3.0f}));
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_EQ(validate(*scene), "");
  EXPECT_TRUE(scene->warnings.empty());
  EXPECT_EQ(scene->meshes[0].keys, 3u);
  EXPECT_EQ(scene->clips[0].start, 0.5);
  EXPECT_EQ(scene->clips[0].end, 3.0);
  EXPECT_EQ(scene->default_frames, 61);
  ScenePose pose;
  std::vector<vec3> positions(4);
  for (const vec2 time_and_z : {vec2(0.5f, 0), vec2(0.75f, 0.5f), vec2(2.0f, 1.5f), vec2(9, 2)}) {
    sample(*scene, 0, time_and_z.x, pose);
    world_positions(*scene, pose, 0, positions);
    EXPECT_NEAR(positions[1].z, time_and_z.y, 1e-5f);
    EXPECT_EQ(positions[3].x, 5.0f);
  }
}

TEST_F(Mdd, TimesThatDoNotRiseAreReplaced) {
  const auto scene = load(make_mdd({0, 0, 0}) + "x");
  ASSERT_TRUE(scene) << scene.error().message();
  ASSERT_EQ(scene->warnings.size(), 2u);
  EXPECT_EQ(scene->warnings[0], "1 bytes after the last sample: ignored");
  EXPECT_EQ(scene->warnings[1],
            "the times of the samples do not rise: taken as 24 samples a second");
  EXPECT_FLOAT_EQ(static_cast<float>(scene->clips[0].end), 2.0f / 24.0f);
}

TEST_F(Mdd, BadFilesEndInErrorsOrValidScenes) {
  const std::string whole = make_mdd({0.0f, 0.1f, 0.2f});
  for_every_truncation(whole, [&](const std::string& bytes) {
    const auto scene = load(bytes);
    ASSERT_FALSE(scene);
    EXPECT_EQ(scene.error().kind, ErrorKind::bad_input);
    EXPECT_EQ(scene.error().file, folder.path("a.mdd"));
  });
  for_random_patches(whole, 2000, 43, [&](const std::string& bytes) {
    const auto scene = load(bytes);
    if (scene) {
      EXPECT_EQ(validate(*scene), "");
    } else {
      EXPECT_EQ(scene.error().kind, ErrorKind::bad_input);
    }
  });
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const auto no_time = load(make_mdd({0.0f, kNan}));
  ASSERT_FALSE(no_time);
  EXPECT_EQ(no_time.error().element, "sample 1");
  EXPECT_FALSE(load(whole, {.memory_limit = 300}));
  EXPECT_FALSE(load(std::string("\x7f\xff\xff\xff\x7f\xff\xff\xff", 8) + whole));
  EXPECT_FALSE(load(std::string("\xff\xff\xff\xff\x00\x00\x00\x04", 8) + whole));
}

TEST(Pc2Data, RealCachesHoldWhatTheirReadmeSays) {
  SINEW_DATA_OR_SKIP(data, "vertex-cache");
  const auto cloth =
      load_vertex_cache(data + "/cloth-drapes/base.obj", data + "/cloth-drapes/positions.pc2", {});
  ASSERT_TRUE(cloth) << cloth.error().message();
  EXPECT_EQ(validate(*cloth), "");
  EXPECT_EQ(cloth->meshes[0].keys, 9u);
  EXPECT_EQ(count(*cloth).triangles, 115'200u);
  EXPECT_EQ(count(*cloth).vertices, 58'081u);
  const auto face = load_vertex_cache(data + "/ict-facekit/generic_neutral_mesh.obj",
                                      data + "/ict-facekit/expressions.pc2", {});
  ASSERT_TRUE(face) << face.error().message();
  EXPECT_EQ(validate(*face), "");
  EXPECT_EQ(face->meshes[0].keys, 57u);
  EXPECT_EQ(count(*face).vertices, 26'719u);
}

}  // namespace
}  // namespace sinew
