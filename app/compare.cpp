// `sinew compare`: how much two pictures differ, and whether that is too much.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "app/json_text.h"
#include "app/progress.h"
#include "app/validators.h"
#include "sinew/io/image_file.h"
#include "sinew/io/output_file.h"

namespace sinew::app {
namespace {

constexpr const char* kExamples =
    "The exit code is 0 if they match, 5 if not.\n"
    "Without --psnr, --max-diff and --max-pixels the pictures match if no channel of any pixel\n"
    "differs by more than --tolerance. With them, only what they say counts.\n"
    "\n"
    "Examples:\n"
    "  sinew compare expected.png actual.png\n"
    "  sinew compare expected.png actual.png --psnr 40 --max-diff 0.1\n";

struct CompareJob {
  std::string first, second;
  std::optional<double> least_psnr;       // dB
  std::optional<double> most_difference;  // 0..1
  std::optional<uint64_t> most_pixels;
  int tolerance = 2;  // of 255
  bool json = false;
};

// Each limit that is exceeded, in words.
std::vector<std::string> mismatches(const CompareJob& job, const ImageDifference& difference) {
  std::vector<std::string> found;
  if (job.least_psnr && !(difference.psnr >= *job.least_psnr)) {
    found.push_back(fmt::format("PSNR {:.2f} dB is below {} dB", difference.psnr, *job.least_psnr));
  }
  if (job.most_difference && difference.largest > *job.most_difference) {
    found.push_back(fmt::format("the largest difference {:.4f} is above {}", difference.largest,
                                *job.most_difference));
  }
  const bool any_limit = job.least_psnr || job.most_difference || job.most_pixels;
  const uint64_t most_pixels = job.most_pixels.value_or(any_limit ? UINT64_MAX : 0);
  if (difference.pixels_over > most_pixels) {
    found.push_back(fmt::format("{} pixels differ by more than {} of 255", difference.pixels_over,
                                job.tolerance));
  }
  return found;
}

std::string as_json(const CompareJob& job, const ImageSize& size, const ImageDifference& difference,
                    bool match) {
  nlohmann::ordered_json document = {
      {"first", job.first},
      {"second", job.second},
      {"width", size.width},
      {"height", size.height},
      {"psnr", nullptr},  // JSON has no infinity
      {"mean", difference.mean},
      {"largest", difference.largest},
      {"pixels_over", difference.pixels_over},
      {"tolerance", job.tolerance},
      {"match", match},
  };
  if (std::isfinite(difference.psnr)) document["psnr"] = difference.psnr;
  return json_text(document);
}

std::string as_text(const CompareJob& job, const ImageSize& size,
                    const ImageDifference& difference) {
  return fmt::format(
      "psnr         {}\n"
      "mean         {:.6f}\n"
      "largest      {:.6f}\n"
      "pixels over  {} of {} (by more than {} of 255)\n",
      std::isfinite(difference.psnr) ? fmt::format("{:.2f} dB", difference.psnr) : "infinite",
      difference.mean, difference.largest, difference.pixels_over,
      uint64_t{size.width} * size.height, job.tolerance);
}

Result<int> compare(const CompareJob& job) {
  SINEW_TRY(const Image8 first, read_png(job.first));
  SINEW_TRY(const Image8 second, read_png(job.second));
  if (first.width != second.width || first.height != second.height) {
    print_error(fmt::format("the sizes differ: {} has {} x {} pixels, {} has {} x {}", job.first,
                            first.width, first.height, job.second, second.width, second.height));
    return kMismatch;
  }
  SINEW_TRY(const ImageDifference difference, compare_images(first, second, job.tolerance));
  const std::vector<std::string> found = mismatches(job, difference);
  const ImageSize size{first.width, first.height};
  SINEW_CHECKED(write_file("-", job.json ? as_json(job, size, difference, found.empty())
                                         : as_text(job, size, difference)));
  for (const std::string& mismatch : found) print_error("mismatch: " + mismatch);
  return found.empty() ? kOk : kMismatch;
}

}  // namespace

Run define_compare(CLI::App& app) {
  static CompareJob job;
  app.footer(kExamples);
  app.add_option("FIRST", job.first, "A .png")->required();
  app.add_option("SECOND", job.second, "A .png of the same size")->required();
  app.add_option("--psnr", job.least_psnr, "At least so many dB")->check(number_in(0.0, 1000.0));
  app.add_option("--max-diff", job.most_difference, "No channel differs by more than this, 0 to 1")
      ->check(number_in(0.0, 1.0));
  app.add_option("--max-pixels", job.most_pixels, "At most so many pixels over --tolerance");
  app.add_option("--tolerance", job.tolerance, "Of 255, per channel (default: 2)")
      ->check(number_in(0, 255));
  app.add_flag("--json", job.json, "Print JSON");
  return [] { return compare(job); };
}

}  // namespace sinew::app
