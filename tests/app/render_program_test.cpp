#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/program.h"
#include "sinew/io/image_exr.h"
#include "sinew/io/image_file.h"
#include "test_data.h"

namespace sinew {
namespace {

constexpr const char* kTwist = "study:twist,triangles=2000";

// `sinew render`, tiny and quiet, with more options after it.
std::vector<std::string> render_words(const std::string& input, const std::string& output,
                                      const std::vector<std::string>& more = {}) {
  std::vector<std::string> words = {"render", input, "-o", output, "--size", "64x48"};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

Outcome render(const std::string& input, const std::string& output,
               const std::vector<std::string>& more = {}) {
  return run_sinew(render_words(input, output, more));
}

// Pixels that are not as the one in the corner, where only background is.
int covered(const Image8& image) {
  int count = 0;
  for (uint32_t y = 0; y < image.height; ++y) {
    for (uint32_t x = 0; x < image.width; ++x) {
      count += !std::equal(image.at(x, y), image.at(x, y) + 4, image.at(0, 0));
    }
  }
  return count;
}

TEST(Render, HiddenObjectsAreLeftOut) {
  const std::string bodies = "study:bodies,subdivisions=2";
  TemporaryFolder folder;
  const auto draw = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> options = {"--time", "1", "--background", "ff00ff"};
    options.insert(options.end(), more.begin(), more.end());
    const Outcome outcome = render(bodies, folder.path(name), options);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return covered(*read_png(folder.path(name)));
  };
  const int all = draw("all.png", {});
  EXPECT_GT(all, 0);
  EXPECT_EQ(draw("none.png", {"--hide", "*"}), 0);
  const Outcome unknown = render(bodies, folder.path("b.png"), {"--hide", "axe"});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.err.find("'axe' fits no object"), std::string::npos) << unknown.err;
}

TEST(Render, AStaticSceneIsOnePicture) {
  TemporaryFolder folder;
  const std::string obj = folder.write("a.obj", small_obj());
  const Outcome outcome =
      render(obj, folder.path("a.png"), {"--background", "ff00ff", "--camera", "orbit=30,20"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  const auto image = read_png(folder.path("a.png"));
  ASSERT_TRUE(image.has_value());
  EXPECT_EQ(image->width, 64u);
  EXPECT_EQ(image->height, 48u);
  EXPECT_EQ(image->at(0, 0)[0], 255);
  EXPECT_EQ(image->at(0, 0)[1], 0);
  EXPECT_EQ(image->at(0, 0)[2], 255);
  EXPECT_GT(covered(*image), 64 * 48 / 10);
}

TEST(Render, TransparentBackgroundsHaveNoAlpha) {
  TemporaryFolder folder;
  const std::string obj = folder.write("a.obj", small_obj());
  ASSERT_EQ(render(obj, folder.path("a.png"), {"--transparent"}).exit_code, 0);
  const auto image = read_png(folder.path("a.png"));
  EXPECT_EQ(image->at(0, 0)[3], 0);
  EXPECT_EQ(image->at(32, 24)[3], 255);
}

TEST(Render, ASequenceHasExactlyTheFramesAskedFor) {
  TemporaryFolder folder;
  const Outcome outcome = render(kTwist, folder.path("out_####.png"), {"--frames", "1-9x4,2"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(folder.file_count(), 4u);
  for (const char* name : {"out_0001.png", "out_0002.png", "out_0005.png", "out_0009.png"}) {
    EXPECT_TRUE(read_png(folder.path(name)).has_value()) << name;
  }
  EXPECT_NE(slurp(folder.path("out_0001.png")), slurp(folder.path("out_0009.png")));
}

TEST(Render, FrameNShowsItsTime) {
  TemporaryFolder folder;
  ASSERT_EQ(render(kTwist, folder.path("f.png"), {"--frames", "26", "--fps", "10"}).exit_code, 0);
  ASSERT_EQ(render(kTwist, folder.path("t.png"), {"--time", "2.5"}).exit_code, 0);
  const auto by_frame = read_png(folder.path("f.png")), by_time = read_png(folder.path("t.png"));
  EXPECT_EQ(by_frame->pixels, by_time->pixels);
}

TEST(Render, MetadataSayWhatAPictureShows) {
  TemporaryFolder folder;
  ASSERT_EQ(render(kTwist, folder.path("a_#.png"), {"--frames", "3"}).exit_code, 0);
  const std::string bytes = slurp(folder.path("a_3.png"));
  for (const std::string& part :
       {std::string("Software\0sinew ", 15), std::string("Source\0study:twist", 18),
        std::string("Frame\0"
                    "3",
                    7),
        std::string("Clip\0Twist", 10)}) {
    EXPECT_NE(bytes.find(part), std::string::npos) << part.c_str();
  }
}

TEST(Render, JsonHoldsEveryFrame) {
  TemporaryFolder folder;
  const Outcome outcome = render(kTwist, folder.path("a.webp"),
                                 {"--frames", "1-3", "--json", folder.path("a.json"), "--ao", "2"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(slurp(folder.path("a.json")));
  for (const char* key : {"version", "kernel_target", "input", "width", "height", "warnings"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  ASSERT_EQ(json["frames"].size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    const auto& frame = json["frames"][i];
    EXPECT_EQ(frame["frame"], i + 1);
    EXPECT_NEAR(frame["time_s"].get<double>(), static_cast<double>(i) / json["fps"].get<double>(),
                1e-9);
    EXPECT_EQ(frame["rays"]["primary"], 64 * 48);
    EXPECT_GT(frame["rays"]["shadow"], 0);
    EXPECT_GT(frame["rays"]["ao"], 0);
    EXPECT_TRUE(frame["rays"]["reflection"].is_number());
    EXPECT_GT(frame["mrays_per_s"], 0.0);
    EXPECT_GE(frame["total_ms"].get<double>(),
              frame["update_ms"].get<double>() + frame["trace_ms"].get<double>());
    EXPECT_GE(frame["shade_ms"], 0.0);
    EXPECT_GT(frame["update"]["treelets"], 0);
    EXPECT_LE(frame["update"]["treelets_made"], frame["update"]["treelets"]);
    EXPECT_EQ(frame.size(), 9u);
  }
}

TEST(Render, ExrHoldsPictureAndLayers) {
  TemporaryFolder folder;
  ASSERT_EQ(render(kTwist, folder.path("a_#.exr"), {"--frames", "1-2"}).exit_code, 0);
  ASSERT_EQ(render(kTwist, folder.path("a.png"), {"--frames", "2"}).exit_code, 0);
  EXPECT_EQ(folder.file_count(), 3u);
  const auto image = read_exr(folder.path("a_2.exr"));
  ASSERT_TRUE(image.has_value()) << image.error().message();
  EXPECT_EQ(image->planes.size(), 11u);
  EXPECT_TRUE(image->attributes.world_to_camera && image->attributes.world_to_ndc);
  const ImageMetadata& texts = image->attributes.texts;
  EXPECT_NE(
      std::find(texts.begin(), texts.end(), std::pair<std::string, std::string>("Frame", "2")),
      texts.end());
  // The same picture once it is finished, but for what half precision rounds.
  EXPECT_EQ(run_sinew({"compare", folder.path("a_2.exr"), folder.path("a.png")}).exit_code, 0);
}

TEST(Render, OnlyTheLayersAskedForAreWritten) {
  TemporaryFolder folder;
  const std::string path = folder.path("a.exr"), json = folder.path("a.json");
  ASSERT_EQ(
      render(kTwist, path, {"--time", "1", "--layers", "depth,object", "--json", json}).exit_code,
      0);
  const auto image = read_exr(path);
  ASSERT_EQ(image->planes.size(), 2u);
  EXPECT_NE(image->find("depth.Z"), nullptr);
  EXPECT_NE(image->find("object.id"), nullptr);
  EXPECT_EQ(nlohmann::json::parse(slurp(json))["frames"][0]["rays"]["primary"], 0) << "no light";
}

TEST(Render, ViewsAreStatedInNumbers) {
  TemporaryFolder folder;
  const std::string png = folder.path("a.png"), json = folder.path("a.json");
  const auto frame_of = [&](const std::string& view) {
    const Outcome outcome = render(kTwist, png, {"--time", "1", "--view", view, "--json", json});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return nlohmann::json::parse(slurp(json))["frames"][0];
  };
  const auto steps = frame_of("heatmap")["steps"];
  EXPECT_GT(steps["mean"], 1.0);
  EXPECT_GT(steps["largest"], steps["mean"]);
  EXPECT_GE(steps["scale"], 10);
  EXPECT_NE(slurp(png).find("TraversalSteps"), std::string::npos);
  EXPECT_EQ(frame_of("heatmap=77")["steps"]["scale"], 77);
  EXPECT_EQ(frame_of("boxes=0")["boxes"], 1);
  EXPECT_GT(frame_of("boxes=2")["boxes"], 8);
  for (const char* view : {"normals", "depth", "objects"}) {
    EXPECT_GT(frame_of(view).size(), 0u);
    EXPECT_GT(covered(*read_png(png)), 100) << view;
  }
}

TEST(Render, ViewsAndLayersThatMakeNoSenseAre2) {
  TemporaryFolder folder;
  const std::string png = folder.path("a.png"), exr = folder.path("a.exr");
  const std::vector<std::vector<std::string>> cases = {
      render_words(kTwist, png, {"--view", "boxes"}),
      render_words(kTwist, png, {"--view", "boxes=-1"}),
      render_words(kTwist, png, {"--view", "boxes=1.5"}),
      render_words(kTwist, png, {"--view", "heatmap=0"}),
      render_words(kTwist, png, {"--view", "normals=1"}),
      render_words(kTwist, png, {"--view", "heat"}),
      render_words(kTwist, png, {"--layers", "depth"}),
      render_words(kTwist, exr, {"--layers", "depth,,normal"}),
      render_words(kTwist, exr, {"--layers", "z"}),
      render_words(kTwist, exr, {"--view", "depth"}),
      render_words(kTwist, exr, {"--background", "ff0000"}),
      render_words(kTwist, folder.path("a_#.mp4")),
      render_words(kTwist, folder.path("a.mp4"), {"--transparent"}),
      render_words(kTwist, folder.path("a.mp4"), {"--lossless"}),
      render_words(kTwist, "-", {"--format", "mp4"}),
  };
  for (const auto& words : cases) {
    const Outcome outcome = run_sinew(words);
    EXPECT_EQ(outcome.exit_code, 2) << testing::PrintToString(words) << outcome.err;
  }
  EXPECT_EQ(folder.file_count(), 0u);
}

TEST(Render, Mp4IsAMovie) {
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0) GTEST_SKIP() << "no ffmpeg";
  TemporaryFolder folder;
  const Outcome outcome = render(kTwist, folder.path("a.mp4"), {"--frames", "1-3"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(folder.file_count(), 1u);
  EXPECT_EQ(slurp(folder.path("a.mp4")).substr(4, 4), "ftyp");
}

TEST(Render, PicturesGoToStandardOutput) {
  TemporaryFolder folder;
  const Outcome outcome = render(kTwist, "-", {"--time", "1"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(read_png(folder.write("a.png", outcome.out)).has_value());
  const Outcome movie = render(kTwist, "-", {"--frames", "1-2", "--format", "webp"});
  ASSERT_EQ(movie.exit_code, 0) << movie.err;
  EXPECT_EQ(movie.out.substr(0, 4), "RIFF");
  EXPECT_EQ(movie.out.substr(8, 4), "WEBP");
}

TEST(Render, SamePictureForAnyThreadCount) {
  TemporaryFolder folder;
  const std::vector<std::string> heavy = {"--time", "1", "--samples", "3", "--ao", "3"};
  for (const char* threads : {"1", "2", "5"}) {
    std::vector<std::string> more = heavy;
    more.insert(more.end(), {"--threads", threads});
    ASSERT_EQ(render(kTwist, folder.path(std::string(threads) + ".png"), more).exit_code, 0);
  }
  EXPECT_EQ(slurp(folder.path("1.png")), slurp(folder.path("2.png")));
  EXPECT_EQ(slurp(folder.path("1.png")), slurp(folder.path("5.png")));
}

TEST(Render, ContactSheetShowsTheFrames) {
  TemporaryFolder folder;
  ASSERT_EQ(render(kTwist, folder.path("a.webp"),
                   {"--frames", "1-4", "--contact-sheet", folder.path("sheet.png")})
                .exit_code,
            0);
  const auto sheet = read_png(folder.path("sheet.png"));
  ASSERT_TRUE(sheet.has_value());
  EXPECT_GT(sheet->width, 2u * 64);
  EXPECT_GT(sheet->height, 2u * 48);
  EXPECT_EQ(folder.file_count(), 2u);
}

TEST(Render, SkipExistingDrawsOnlyWhatIsMissing) {
  TemporaryFolder folder;
  folder.write("a_2.png", "mine");
  const std::vector<std::string> more = {"--frames", "1-3", "--skip-existing", "--json",
                                         folder.path("a.json")};
  ASSERT_EQ(render(kTwist, folder.path("a_#.png"), more).exit_code, 0);
  EXPECT_EQ(slurp(folder.path("a_2.png")), "mine");
  EXPECT_EQ(nlohmann::json::parse(slurp(folder.path("a.json")))["frames"].size(), 2u);
  EXPECT_EQ(render(kTwist, folder.path("a_#.png"), more).exit_code, 0);
}

TEST(Render, ManyFramesNeedACounterOrAMovie) {
  TemporaryFolder folder;
  const Outcome outcome = render(kTwist, folder.path("a.png"));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("out_####.png"), std::string::npos) << outcome.err;
  EXPECT_EQ(folder.file_count(), 0u);
}

TEST(Render, UnknownClipsAreListed) {
  TemporaryFolder folder;
  const Outcome outcome = render(kTwist, folder.path("a.webp"), {"--clip", "Tango"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("Twist"), std::string::npos) << outcome.err;
  EXPECT_EQ(folder.file_count(), 0u);
}

TEST(Render, UnwritableOutputsAre4BeforeAnyWork) {
  TemporaryFolder folder;
  const std::string obj = folder.write("a.obj", small_obj());
  const std::string nowhere = folder.path("nowhere/a.png");
  const std::vector<std::vector<std::string>> cases = {
      render_words("missing.glb", nowhere),
      render_words("missing.glb", folder.path("a.obj/b.png")),
      render_words("missing.glb", folder.path("a.png"), {"--json", folder.path("no/a.json")}),
      render_words("missing.glb", folder.path("a.png"), {"--contact-sheet", nowhere}),
  };
  for (const auto& words : cases) {
    const Outcome outcome = run_sinew(words);
    EXPECT_EQ(outcome.exit_code, 4) << outcome.err;
    EXPECT_EQ(folder.file_count(), 1u);
  }
}

TEST(Render, AFullDiskIs4) {
  TemporaryFolder folder;
  const std::string obj = folder.write("a.obj", small_obj());
  EXPECT_EQ(render(obj, "/dev/full", {"--format", "png"}).exit_code, 4);
}

TEST(Render, FramesAfterTheEndWarn) {
  TemporaryFolder folder;
  const Outcome outcome = render(kTwist, folder.path("a.png"), {"--frames", "100000"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_NE(outcome.err.find("stands still"), std::string::npos) << outcome.err;
}

TEST(Render, ProgressIsJsonOnRequestAndElseSilent) {
  TemporaryFolder folder;
  const std::string out = folder.path("a_#.png");
  const Outcome json = render(kTwist, out, {"--frames", "1-2", "--progress", "json"});
  const std::string first = json.err.substr(0, json.err.find('\n'));
  EXPECT_EQ(nlohmann::json::parse(first)["of"], 2) << json.err;
  EXPECT_EQ(render(kTwist, out, {"--frames", "1-2", "--progress", "none"}).err, "");
}

// Starts an endless render, waits for its first frames, sends the signal.
Outcome interrupt(const std::string& output, int signal) {
  Program program(render_words(kTwist, output, {"--frames", "1-1000000", "--progress=json"}));
  for (int i = 0; i < 600 && program.err_so_far().find("\"done\": 2") == std::string::npos; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  program.send(signal);
  return program.wait();
}

TEST(Render, ASignalLeavesNoUnfinishedMovie) {
  for (const char* name : {"a.webp", "a.mp4"}) {
    if (name[2] == 'm' && std::system("ffmpeg -version > /dev/null 2>&1") != 0) continue;
    TemporaryFolder folder;
    const Outcome outcome = interrupt(folder.path(name), SIGTERM);
    EXPECT_EQ(outcome.exit_code, 143) << outcome.err;
    EXPECT_NE(outcome.err.find("interrupted after"), std::string::npos) << outcome.err;
    EXPECT_EQ(folder.file_count(), 0u) << name;
  }
}

TEST(Render, ASignalLeavesWholeFrames) {
  TemporaryFolder folder;
  EXPECT_EQ(interrupt(folder.path("a_#.png"), SIGINT).exit_code, 130);
  EXPECT_GE(folder.file_count(), 2u);
  for (const auto& file : std::filesystem::directory_iterator(folder.path(""))) {
    EXPECT_TRUE(read_png(file.path().string()).has_value()) << file.path();
  }
}

TEST(Render, EveryKindOfSharedDataGivesAPicture) {
  SINEW_DATA_OR_SKIP(cloth, "vertex-cache/cloth-drapes");
  SINEW_DATA_OR_SKIP(robot, "skinned/robot-expressive/RobotExpressive.glb");
  SINEW_DATA_OR_SKIP(fox, "khronos-gltf/Fox/glTF-Binary/Fox.glb");
  for (const std::string& input : {robot, fox, cloth + "/base.obj+" + cloth + "/positions.pc2"}) {
    TemporaryFolder folder;
    const Outcome outcome = render(input, folder.path("a.png"), {"--frames", "3"});
    ASSERT_EQ(outcome.exit_code, 0) << input << ": " << outcome.err;
    EXPECT_GT(covered(*read_png(folder.path("a.png"))), 100) << input;
  }
}

}  // namespace
}  // namespace sinew
