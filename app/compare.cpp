// `sinew compare`: how much two pictures differ, and whether that is too much.
#include "app/compare.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "app/interrupt.h"
#include "app/json_text.h"
#include "app/output_name.h"
#include "app/progress.h"
#include "app/validators.h"
#include "sinew/io/output_file.h"

namespace sinew::app {
namespace {

constexpr const char* kExamples =
    "The exit code is 0 if they match, 5 if not. Without --max-flip, --psnr, --max-diff and\n"
    "--max-pixels the pictures match if no channel of any pixel differs by more than\n"
    "--tolerance. With them, only what they say counts.\n"
    "FLIP (Andersson et al. 2020) says how large a difference looks: 0 none, 1 the largest.\n"
    "Pictures of .exr files are tone-mapped first, as `sinew render` does it. A --layer of\n"
    "them is compared by its values, in its own unit.\n"
    "\n"
    "Examples:\n"
    "  sinew compare expected.png actual.png\n"
    "  sinew compare expected.png actual.png --max-flip 0.01 --diff errors.png\n"
    "  sinew compare expected.exr actual.exr --layer depth --max-diff 0.001\n";

std::string size_text(const ImageSize& size) {
  return fmt::format("{} x {}", size.width, size.height);
}

// Each limit that is exceeded, in words.
std::vector<std::string> mismatches(const CompareJob& job, const Comparison& result) {
  if (!result.same_size()) {
    return {fmt::format("{} has {} pixels, {} has {}", job.first, size_text(result.first_size),
                        job.second, size_text(result.second_size))};
  }
  std::vector<std::string> found;
  if (job.most_flip && !(*result.flip <= *job.most_flip)) {
    found.push_back(fmt::format("FLIP {:.5f} is above {}", *result.flip, *job.most_flip));
  }
  if (job.least_psnr && !(*result.psnr >= *job.least_psnr)) {
    found.push_back(fmt::format("PSNR {:.2f} dB is below {} dB", *result.psnr, *job.least_psnr));
  }
  if (job.most_difference && !(result.largest <= *job.most_difference)) {
    found.push_back(fmt::format("the largest difference {:.6g} is above {}", result.largest,
                                *job.most_difference));
  }
  const bool any_limit = job.most_flip || job.least_psnr || job.most_difference || job.most_pixels;
  const uint64_t most_pixels = job.most_pixels.value_or(any_limit ? UINT64_MAX : 0);
  if (result.pixels_over > most_pixels) {
    found.push_back(fmt::format("{} pixels differ by more than {}{}", result.pixels_over,
                                job.tolerance_or_default(), job.of_layer() ? "" : " of 255"));
  }
  return found;
}

std::string as_json(const CompareJob& job, const Comparison& result,
                    const std::vector<std::string>& found) {
  // JSON has no infinity: null stands for it, and for what layers or pictures of two sizes have not
  // got.
  const auto number = [&](std::optional<double> value) {
    return value && std::isfinite(*value) && result.same_size() ? nlohmann::ordered_json(*value)
                                                                : nullptr;
  };
  const nlohmann::ordered_json document = {
      {"first", job.first},
      {"second", job.second},
      {"layer", job.layer.empty() ? "color" : job.layer},
      {"width", result.first_size.width},
      {"height", result.first_size.height},
      {"flip", number(result.flip)},
      {"largest_flip", number(result.largest_flip)},
      {"psnr", number(result.psnr)},
      {"mean", number(result.mean)},
      {"largest", number(result.largest)},
      {"pixels_over", result.pixels_over},
      {"tolerance", job.tolerance_or_default()},
      {"match", found.empty()},
      {"mismatches", found},
  };
  return json_text(document);
}

std::string as_text(const CompareJob& job, const Comparison& result) {
  std::string text;
  if (!result.same_size()) return text;
  if (result.flip) {
    text += fmt::format("flip         {:.6f} (mean), {:.6f} (largest)\n", *result.flip,
                        *result.largest_flip);
  }
  if (result.psnr) {
    text += fmt::format("psnr         {}\n", std::isfinite(*result.psnr)
                                                 ? fmt::format("{:.2f} dB", *result.psnr)
                                                 : "infinite");
  }
  text += fmt::format("mean         {:.6g}\nlargest      {:.6g}\n", result.mean, result.largest);
  text += fmt::format("pixels over  {} of {} (by more than {}{})\n", result.pixels_over,
                      uint64_t{result.first_size.width} * result.first_size.height,
                      job.tolerance_or_default(), job.of_layer() ? "" : " of 255");
  return text;
}

Result<void> check(const CompareJob& job) {
  if (job.of_layer() && (job.least_psnr || job.most_flip)) {
    return fail({ErrorKind::usage, "", "", "FLIP and PSNR are for pictures, not for a --layer",
                 "use --max-diff or --max-pixels"});
  }
  if (!job.of_layer() && job.tolerance &&
      (*job.tolerance > 255.0 || *job.tolerance != std::floor(*job.tolerance))) {
    return fail({ErrorKind::usage, "", "",
                 "the --tolerance of pictures is a whole number of 0 to 255",
                 "write --tolerance 2"});
  }
  if (job.difference.empty()) return {};
  SINEW_TRY(const OutputName difference, parse_output_name(job.difference));
  if (difference.format != OutputFormat::png || difference.has_counter()) {
    return fail({ErrorKind::usage, "", "", "--diff makes one .png file", "write --diff diff.png"});
  }
  return check_writable(job.difference);
}

Result<int> compare(const CompareJob& job) {
  SINEW_CHECKED(check(job));
  SINEW_TRY(const Comparison result, job.of_layer() ? compare_layers(job) : compare_pictures(job));
  const std::vector<std::string> found = mismatches(job, result);
  if (!job.difference.empty() && result.same_size()) {
    const Uninterrupted writing;
    SINEW_CHECKED(write_png(job.difference, result.difference));
  }
  SINEW_CHECKED(write_file("-", job.json ? as_json(job, result, found) : as_text(job, result)));
  for (const std::string& mismatch : found) print_error("mismatch: " + mismatch);
  return found.empty() ? kOk : kMismatch;
}

}  // namespace

Run define_compare(CLI::App& app) {
  static CompareJob job;
  app.footer(kExamples);
  app.add_option("FIRST", job.first, "A .png, .jpg or .exr")->required();
  app.add_option("SECOND", job.second, "Another of the same size")->required();
  app.add_option("--layer", job.layer, "Of .exr files: depth, normal, object ... (default: color)");
  app.add_option("--max-flip", job.most_flip, "The mean FLIP error is at most this, 0 to 1")
      ->check(number_in(0.0, 1.0));
  app.add_option("--psnr,--min-psnr", job.least_psnr, "At least so many dB")
      ->check(number_in(0.0, 1000.0));
  app.add_option("--max-diff", job.most_difference,
                 "No channel differs by more than this: 0 to 1, or in the layer's unit")
      ->check(number_in(0.0, 1e30));
  app.add_option("--max-pixels", job.most_pixels, "At most so many pixels over --tolerance")
      ->check(whole_number_in(0, UINT64_MAX));
  app.add_option("--tolerance", job.tolerance,
                 "Per channel: of 255 (default: 2), or in the layer's unit (default: 0)")
      ->check(number_in(0.0, 1e30));
  app.add_option("--ppd", job.pixels_per_degree,
                 "Of FLIP: pixels in a degree of what the viewer sees (default: 67)")
      ->check(number_in(1.0, 1000.0));
  app.add_option("--exposure", job.exposure, "Of .exr pictures, in stops (default: 0)")
      ->check(number_in(-32.0, 32.0));
  app.add_option("--diff", job.difference,
                 "Write a .png of the FLIP errors (of a layer: the differences), dark to bright");
  app.add_flag("--json", job.json, "Print JSON");
  return [] { return compare(job); };
}

}  // namespace sinew::app
