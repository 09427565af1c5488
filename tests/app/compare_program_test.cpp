#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/program.h"
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
  EXPECT_EQ(run_sinew({"compare", p.same, p.folder.path("missing.png")}).exit_code, 3);
  EXPECT_EQ(run_sinew({"compare", p.folder.write("bad.png", "no"), p.same}).exit_code, 3);
}

}  // namespace
}  // namespace sinew
