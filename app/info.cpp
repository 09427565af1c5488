// `sinew info`: what a file or a study scene holds.
#include <CLI/CLI.hpp>

#include "app/command.h"
#include "app/scene_info.h"
#include "sinew/io/load.h"
#include "sinew/io/output_file.h"

namespace sinew::app {
namespace {

constexpr const char* kExamples =
    "Examples:\n"
    "  sinew info walk.glb\n"
    "  sinew info walk.glb --json | jq .clips\n"
    "  sinew info study:              lists the study scenes and their parameters\n"
    "  sinew info study:creature\n";

struct InfoJob {
  std::string input;
  bool json = false;
  LoadOptions load;
};

Result<int> info(const InfoJob& job) {
  if (job.input == "study:") {
    SINEW_CHECKED(write_file("-", job.json ? study_list_json() : study_list_text()));
    return kOk;
  }
  SINEW_TRY(const Scene scene, load(job.input, job.load));
  SINEW_CHECKED(write_file(
      "-", job.json ? scene_info_json(scene, job.input) : scene_info_text(scene, job.input)));
  return kOk;
}

}  // namespace

Run define_info(CLI::App& app) {
  static InfoJob job;
  app.footer(kExamples);
  app.add_option("INPUT", job.input, "As for `sinew render`, or study: for the list")->required();
  app.add_flag("--json", job.json, "Print JSON");
  app.add_flag("--strict", job.load.strict,
               "Fail if the file holds something that is not supported");
  return [] { return info(job); };
}

}  // namespace sinew::app
