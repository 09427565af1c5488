// The program as a whole: what it says about itself, and its exit codes.
#include "app/program.h"
#include "app/help_format.h"

#include <gtest/gtest.h>

#include <sstream>

#include <algorithm>

namespace sinew {
namespace {

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Program, HelpAndVersionGoToStdout) {
  for (const char* word : {"--help", "--version"}) {
    const Outcome outcome = run_sinew({word});
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_TRUE(holds(outcome.out, "sinew"));
    EXPECT_EQ(outcome.err, "");
  }
  for (const char* command : {"info", "render", "compare", "scene", "optimize"}) {
    const Outcome outcome = run_sinew({command, "--help"});
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_TRUE(holds(outcome.out, "Examples:")) << command;
    std::istringstream lines(outcome.out);
    for (std::string line; std::getline(lines, line);)
      EXPECT_LE(line.size(), app::kHelpWidth) << line;
  }
}

TEST(Program, UsageErrorsAre2AndSayWhatToDo) {
  const struct {
    std::vector<std::string> arguments;
    const char* says;
  } cases[] = {
      {{}, "a command is missing"},
      {{"rendr"}, "did you mean render?"},
      {{"zebra"}, "'zebra' is not a command"},
      {{"--nonsense"}, "--nonsense"},
      {{"info"}, "INPUT"},
      {{"render", "a.obj"}, "--output"},
      {{"render", "a.obj", "-o", "a.png", "--sampels", "4"}, "did you mean --samples?"},
      {{"render", "a.obj", "-o", "a.png", "--samples", "0"}, "'0' is not a whole number from 1"},
      {{"render", "a.obj", "-o", "a.png", "--samples", "4097"}, "--samples"},
      {{"render", "a.obj", "-o", "a.png", "--samples", "1.5"}, "--samples"},
      {{"render", "a.obj", "-o", "a.png", "--exposure", "nan"}, "--exposure"},
      {{"render", "a.obj", "-o", "a.png", "--size", "0x10"}, "--size '0x10'"},
      {{"render", "a.obj", "-o", "a.png", "--size", "99999x10"}, "16384"},
      {{"render", "a.obj", "-o", "a.png", "--fps", "0"}, "--fps"},
      {{"render", "a.obj", "-o", "a.png", "--frames", "1-100:2"}, "write 1-100x2"},
      {{"render", "a.obj", "-o", "a.png", "--frames", "0"}, "frames count from 1"},
      {{"render", "a.obj", "-o", "a.png", "--frames", "1", "--time", "0"}, "--time"},
      {{"render", "a.obj", "-o", "a.jpg"}, "'jpg' files are not written"},
      {{"render", "a.obj", "-o", "a.webp", "--size", "16384x16"}, "16383"},
      {{"render", "a.obj", "-o", "a.png", "--voxelize", "body"}, "--mode mixed"},
      {{"render", "a.obj", "-o", "a.png", "--mode", "clouds"}, "unknown"},
      {{"render", "a.obj", "-o", "a.png", "--update", "sometimes"}, "unknown"},
      {{"render", "a.obj", "-o", "a.png", "--camera", "eye=1,2"}, "--camera"},
      {{"render", "a.obj", "-o", "a.png", "--memory-limit", "much"}, "--memory-limit"},
      {{"render", "a.obj", "-o", "a.png", "--size", "9999x9999", "--memory-limit", "1G"},
       "--memory-limit allows 1024 MB"},
      {{"render", "a.obj", "-o", "-", "--json", "-"}, "standard output"},
      {{"render", "study:nothing", "-o", "-", "--time", "0"}, "twist"},
      {{"render", "a.obj", "-o", "a.png", "--lossless"}, "always lossless"},
      {{"render", "a.obj", "-o", "a.exr", "--quality", "9"}, "always lossless"},
      {{"render", "a.obj", "-o", "a.webp", "--lossless", "--quality", "9"}, "leave one"},
      {{"render", "a.obj", "-o", "a.png", "--view", "heatmap", "--subsample", "2"}, "--view"},
      {{"render", "a.obj", "-o", "a.exr", "--layers", "depth", "--progressive"}, "layer color"},
      {{"compare", "a.png"}, "SECOND"},
      {{"compare", "a.png", "b.png", "--diff", "c.jpg"}, "c.jpg"},
      {{"compare", "a.png", "b.png", "--max-pixels", "-1"}, "--max-pixels"},
      {{"compare", "a.png", "b.png", "--psnr", "many"}, "--psnr"},
  };
  for (const auto& [arguments, says] : cases) {
    const Outcome outcome = run_sinew(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
    EXPECT_TRUE(holds(outcome.err, says)) << "expected '" << says << "' in: " << outcome.err;
    EXPECT_EQ(outcome.out, "");
  }
}

TEST(Program, BadInputIs3AndNamesTheFile) {
  TemporaryFolder folder;
  const std::string broken = folder.write("broken.glb", "glTF, or is it?");
  const std::string empty = folder.write("empty.obj", "");
  for (const std::string& input :
       {broken, empty, folder.path("missing.glb"), folder.path("walk_####.obj"),
        folder.write("readme.txt", "hello")}) {
    const Outcome outcome = run_sinew({"info", input});
    EXPECT_EQ(outcome.exit_code, 3) << input << ": " << outcome.err;
    EXPECT_EQ(outcome.out, "");
    const std::string stem = std::filesystem::path(input).stem().string().substr(0, 4);
    EXPECT_TRUE(holds(outcome.err, stem)) << outcome.err;
  }
}

TEST(Program, AFullStandardOutputIs4) {
  TemporaryFolder folder;
  const std::string obj = folder.write("a.obj", small_obj());
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{"--help"},
                                             {"info", obj},
                                             {"info", "study:"},
                                             {"render", obj, "-o", "-", "--size", "8x8"}}) {
    const Outcome outcome = Program(arguments, "/dev/full").wait();
    EXPECT_EQ(outcome.exit_code, 4) << arguments[0] << outcome.err;
  }
}

TEST(Program, EveryErrorIsOneSentenceOnStderr) {
  const Outcome outcome = run_sinew({"info", "missing.glb"});
  EXPECT_TRUE(outcome.err.starts_with("sinew: missing.glb")) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1);
}

}  // namespace
}  // namespace sinew
