#include "app/frames.h"

#include <gtest/gtest.h>

#include "sinew/scene/sample.h"

namespace sinew::app {
namespace {

using Frames = std::vector<int>;

TEST(Frames, SinglesRangesStepsAndLists) {
  EXPECT_EQ(*parse_frames("7"), Frames({7}));
  EXPECT_EQ(*parse_frames("1-4"), Frames({1, 2, 3, 4}));
  EXPECT_EQ(*parse_frames("1,3,5-7"), Frames({1, 3, 5, 6, 7}));
  EXPECT_EQ(*parse_frames("1-10x3"), Frames({1, 4, 7, 10}));
  EXPECT_EQ(*parse_frames("5-5"), Frames({5}));
  EXPECT_EQ(*parse_frames("1-3x100"), Frames({1}));
}

TEST(Frames, ComeInOrderAndOnce) {
  EXPECT_EQ(*parse_frames("9,1-3,2-4"), Frames({1, 2, 3, 4, 9}));
}

TEST(Frames, OtherSpellingsAreNamedWithTheRightOne) {
  const auto remedy = [](const char* text) { return parse_frames(text).error().remedy; };
  EXPECT_EQ(remedy("1-100:2"), "write 1-100x2");
  EXPECT_EQ(remedy("1-100/2"), "write 1-100x2");
  EXPECT_EQ(remedy("1..100"), "write 1-100");
  EXPECT_EQ(remedy("1:100"), "write 1-100");
  EXPECT_EQ(remedy("100-1"), "write 1-100");
  EXPECT_EQ(remedy("3-"), "write 3-100");
  EXPECT_EQ(remedy("1-9x"), "write 1-9x2");
  EXPECT_NE(parse_frames("1-100:2").error().element.find("1-100:2"), std::string::npos);
}

TEST(Frames, NonsenseIsAUsageError) {
  for (const char* text : {"",
                           ",",
                           "1,",
                           ",1",
                           "a",
                           "1a",
                           "0",
                           "0-3",
                           "-1",
                           "1-2-3",
                           "1-9x0",
                           " 1",
                           "1 ",
                           "1.5",
                           "+1",
                           "1--2",
                           "99999999999999999999",
                           "1-99999999999",
                           "1-2000000",
                           "0x10",
                           "1-3x-1"}) {
    const auto frames = parse_frames(text);
    ASSERT_FALSE(frames.has_value()) << "'" << text << "'";
    EXPECT_EQ(frames.error().kind, ErrorKind::usage) << text;
    EXPECT_FALSE(frames.error().problem.empty()) << text;
  }
}

Scene scene_of(double start, double end) {
  Scene scene;
  scene.clips.push_back({"clip", start, end, {}});
  return scene;
}

TEST(Timeline, FramesCoverTheClipOnce) {
  const Timeline timeline = timeline_of(scene_of(0.5, 2.5), 0);
  EXPECT_EQ(timeline.fps, 24.0);
  EXPECT_EQ(timeline.frames, 48);
  EXPECT_EQ(frame_time(timeline, 1), 0.5);
  EXPECT_EQ(frame_time(timeline, 25), 1.5);
  EXPECT_LT(frame_time(timeline, timeline.frames), timeline.end);
}

TEST(Timeline, LengthsThatAreNearlyWholeAreWhole) {
  EXPECT_EQ(timeline_of(scene_of(0.0, 0.1 + 0.2), 0, 10.0).frames, 3);
  EXPECT_EQ(timeline_of(scene_of(0.0, 0.31), 0, 10.0).frames, 4);
  EXPECT_EQ(timeline_of(scene_of(1.0, 1.0), 0).frames, 1);
}

TEST(Timeline, TheScenesOwnRateAndLengthCountUnlessOverridden) {
  Scene scene = scene_of(0.0, 2.0);
  scene.default_fps = 25.0;
  scene.default_frames = 20;
  EXPECT_EQ(timeline_of(scene, 0).frames, 20);
  EXPECT_EQ(timeline_of(scene, 0).fps, 25.0);
  EXPECT_EQ(timeline_of(scene, 0, 10.0).fps, 10.0);
  EXPECT_EQ(timeline_of(scene, 0, 10.0).frames, 20);
  EXPECT_EQ(timeline_of(scene, 0, 30.0).frames, 60);
}

TEST(Timeline, AStaticSceneHasOneFrame) {
  EXPECT_EQ(timeline_of(scene_of(0.0, 2.0), kRestPose).frames, 1);
}

}  // namespace
}  // namespace sinew::app
