#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/program.h"
#include "sinew/io/image_exr.h"
#include "sinew/io/image_file.h"

namespace sinew {
namespace {

// 10 x 10 grey pixels; `changed` of them are brighter by `by`.
std::string picture(const TemporaryFolder& folder, const char* name, int changed, int by) {
  Image8 image{10, 10, std::vector<uint8_t>(400, 100)};
  for (int i = 0; i < changed; ++i) image.pixels[4 * i] = static_cast<uint8_t>(100 + by);
  EXPECT_TRUE(write_png(folder.path(name), image).has_value());
  return folder.path(name);
}

struct Pictures {
  TemporaryFolder folder;
  std::string same = picture(folder, "same.png", 0, 0);
  std::string again = picture(folder, "again.png", 0, 0);
  std::string near = picture(folder, "near.png", 5, 2);
  std::string far = picture(folder, "far.png", 5, 51);
};

TEST(Compare, EqualPicturesMatch) {
  const Pictures p;
  const Outcome outcome = run_sinew({"compare", p.same, p.again, "--json"});
  EXPECT_EQ(outcome.exit_code, 0);
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_TRUE(json["match"].get<bool>());
  EXPECT_TRUE(json["psnr"].is_null());
  EXPECT_EQ(json["pixels_over"], 0);
  EXPECT_EQ(json["width"], 10);
}

TEST(Compare, ToleranceDecidesUnlessAnotherLimitIsGiven) {
  const Pictures p;
  EXPECT_EQ(run_sinew({"compare", p.same, p.near}).exit_code, 0);
  EXPECT_EQ(run_sinew({"compare", p.same, p.near, "--tolerance", "1"}).exit_code, 5);
  EXPECT_EQ(run_sinew({"compare", p.same, p.far}).exit_code, 5);
  EXPECT_EQ(run_sinew({"compare", p.same, p.far, "--psnr", "20"}).exit_code, 0);
  EXPECT_EQ(run_sinew({"compare", p.same, p.far, "--psnr", "60"}).exit_code, 5);
  EXPECT_EQ(run_sinew({"compare", p.same, p.far, "--max-diff", "0.25"}).exit_code, 0);
  EXPECT_EQ(run_sinew({"compare", p.same, p.far, "--max-diff", "0.15"}).exit_code, 5);
  EXPECT_EQ(run_sinew({"compare", p.same, p.far, "--max-pixels", "5"}).exit_code, 0);
  EXPECT_EQ(run_sinew({"compare", p.same, p.far, "--max-pixels", "4"}).exit_code, 5);
}

TEST(Compare, NumbersAreThoseOfTheFormula) {
  const Pictures p;
  const auto json = nlohmann::json::parse(run_sinew({"compare", p.same, p.far, "--json"}).out);
  // Five of 300 samples differ by 51 of 255.
  EXPECT_NEAR(json["mean"].get<double>(), 5 * 0.2 / 300, 1e-9);
  EXPECT_NEAR(json["largest"].get<double>(), 0.2, 1e-9);
  EXPECT_NEAR(json["psnr"].get<double>(), -10 * std::log10(5 * 0.04 / 300), 1e-6);
  EXPECT_EQ(json["pixels_over"], 5);
  EXPECT_FALSE(json["match"].get<bool>());
}

TEST(Compare, DifferentSizesAre5AndUnreadableFilesAre3) {
  const Pictures p;
  const std::string small = p.folder.path("small.png");
  ASSERT_TRUE(write_png(small, Image8{2, 1, std::vector<uint8_t>(8, 0)}).has_value());
  const Outcome outcome = run_sinew({"compare", p.same, small});
  EXPECT_EQ(outcome.exit_code, 5);
  EXPECT_NE(outcome.err.find("2 x 1"), std::string::npos) << outcome.err;
  const auto json = nlohmann::json::parse(run_sinew({"compare", p.same, small, "--json"}).out);
  EXPECT_FALSE(json["match"].get<bool>());
  EXPECT_EQ(json["mismatches"].size(), 1u);
  EXPECT_TRUE(json["flip"].is_null());
  EXPECT_EQ(run_sinew({"compare", p.same, p.folder.path("missing.png")}).exit_code, 3);
  EXPECT_EQ(run_sinew({"compare", p.folder.write("bad.png", "no"), p.same}).exit_code, 3);
}

TEST(Compare, FlipDecidesIfAsked) {
  const Pictures p;
  const auto json = nlohmann::json::parse(run_sinew({"compare", p.same, p.far, "--json"}).out);
  const double flip = json["flip"];
  EXPECT_GT(flip, 0.01);
  EXPECT_LT(flip, json["largest_flip"].get<double>());
  const auto exit_code = [&](double limit) {
    return run_sinew({"compare", p.same, p.far, "--max-flip", std::to_string(limit)}).exit_code;
  };
  EXPECT_EQ(exit_code(flip + 1e-5), 0);
  EXPECT_EQ(exit_code(flip - 1e-5), 5);
  const auto coarse = run_sinew({"compare", p.same, p.far, "--json", "--ppd", "10"});
  EXPECT_NE(nlohmann::json::parse(coarse.out)["flip"].get<double>(), flip);
}

TEST(Compare, TheDifferenceIsAPicture) {
  const Pictures p;
  const std::string diff = p.folder.path("diff.png");
  EXPECT_EQ(run_sinew({"compare", p.same, p.far, "--diff", diff}).exit_code, 5);
  const auto image = read_png(diff);
  ASSERT_TRUE(image.has_value());
  EXPECT_EQ(image->width, 10u);
  EXPECT_GT(image->at(2, 0)[0], image->at(2, 9)[0]);
  EXPECT_EQ(run_sinew({"compare", p.same, p.far, "--diff", p.folder.path("no/a.png")}).exit_code,
            4);
}

// 4 x 2 pixels of one colour, a depth of which one pixel is `depth`, and nothing behind the last.
std::string exr(const TemporaryFolder& folder, const char* name, float depth, float red = 0.25f) {
  std::vector<float> colors(8, red), depths(8, 1.0f);
  depths[3] = depth;
  depths[7] = INFINITY;
  const std::vector<ExrChannel> channels = {{"R", ExrType::half, colors.data()},
                                            {"G", ExrType::half, colors.data()},
                                            {"B", ExrType::half, colors.data()},
                                            {"depth.Z", ExrType::float32, depths.data()}};
  EXPECT_TRUE(write_exr(folder.path(name), {4, 2}, channels));
  return folder.path(name);
}

TEST(Compare, LayersAreComparedByTheirValues) {
  const TemporaryFolder folder;
  const std::string a = exr(folder, "a.exr", 1.0f), b = exr(folder, "b.exr", 1.5f);
  EXPECT_EQ(run_sinew({"compare", a, b}).exit_code, 0) << "the colours are the same";
  const Outcome outcome = run_sinew({"compare", a, b, "--layer", "depth", "--json"});
  EXPECT_EQ(outcome.exit_code, 5);
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["largest"], 0.5);
  EXPECT_EQ(json["mean"], 0.5 / 8);
  EXPECT_EQ(json["pixels_over"], 1);
  EXPECT_TRUE(json["flip"].is_null());
  const auto exit_code = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"compare", a, b, "--layer", "depth"};
    words.insert(words.end(), more.begin(), more.end());
    return run_sinew(words).exit_code;
  };
  EXPECT_EQ(exit_code({"--tolerance", "0.5"}), 0);
  EXPECT_EQ(exit_code({"--tolerance", "0.4"}), 5);
  EXPECT_EQ(exit_code({"--max-diff", "0.5"}), 0);
  EXPECT_EQ(exit_code({"--max-diff", "0.4"}), 5);
  EXPECT_EQ(exit_code({"--max-flip", "0.5"}), 2);
  const Outcome unknown = run_sinew({"compare", a, b, "--layer", "dept"});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.err.find("depth.Z"), std::string::npos) << unknown.err;
}

TEST(Compare, LinearPicturesAreFinishedFirst) {
  const TemporaryFolder folder;
  const std::string dim = exr(folder, "dim.exr", 1.0f), bright = exr(folder, "b.exr", 1.0f, 0.5f);
  EXPECT_EQ(run_sinew({"compare", dim, bright}).exit_code, 5);
  // 0.25 in linear light is 137 in sRGB; the display transform leaves it alone.
  const std::string png = folder.path("dim.png");
  Image8 image{4, 2, std::vector<uint8_t>(32, 137)};
  for (size_t i = 3; i < 32; i += 4) image.pixels[i] = 255;
  ASSERT_TRUE(write_png(png, image));
  EXPECT_EQ(run_sinew({"compare", dim, png, "--tolerance", "0"}).exit_code, 0);
  EXPECT_EQ(run_sinew({"compare", dim, png, "--exposure", "1"}).exit_code, 5);
}

}  // namespace
}  // namespace sinew
