// `sinew optimize`: makes the trees that suit a whole animation, for `sinew render --tree`.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <memory>

#include "app/camera_choice.h"
#include "app/command.h"
#include "app/hide.h"
#include "app/interrupt.h"
#include "app/json_text.h"
#include "app/progress.h"
#include "app/validators.h"
#include "app/values.h"
#include "sinew/base/parallel.h"
#include "sinew/io/load.h"
#include "sinew/io/output_file.h"
#include "sinew/world/animation_trees.h"
#include "sinew/world/world.h"

namespace sinew::app {
namespace {

constexpr const char* kExamples =
    "One tree a body is made for its whole animation; where one cannot serve all of it, several,\n"
    "each for a part (--segments). Costs are what a random ray pays (surface area heuristic).\n"
    "\n"
    "Examples:\n"
    "  sinew optimize study:fracture -o fracture.tree\n"
    "  sinew render study:fracture --tree fracture.tree -o fracture.webp\n"
    "  sinew optimize museum.aff -o museum.tree --segments auto --json report.json\n"
    "  sinew optimize character.glb -o character.tree --clip all\n";

constexpr uint32_t kMostSegments = 4;  // of --segments auto
constexpr float kAspect = 4.0f / 3.0f;

struct OptimizeJob {
  std::string input, output, json;
  LoadOptions load;
  std::vector<std::string> hide;
  AnimationTreeOptions trees;
  std::string segments = "1", budget, choice = "uniform", camera;
  double view_share = 0.5;
  int threads = 0;
};

Result<void> read_segments(OptimizeJob& job) {
  if (job.segments == "auto") {
    job.trees.most_segments = kMostSegments;
    return {};
  }
  const std::optional<uint64_t> count = parse_whole(job.segments);
  if (!count || *count == 0 || *count > 1000) {
    return fail({ErrorKind::usage, "", fmt::format("--segments '{}'", job.segments),
                 "that is no number of segments", "write auto, or 1 to 1000"});
  }
  job.trees.most_segments = static_cast<uint32_t>(*count);
  return {};
}

// Only names that end in .tree are written, so that no model is lost to a slip.
Result<void> check_outputs(const OptimizeJob& job) {
  if (job.output == "-" && job.json == "-") {
    return fail({ErrorKind::usage, "", "", "trees and report cannot both go to standard output",
                 "give --json a file name"});
  }
  if (job.output != "-" && std::filesystem::path(job.output).extension() != ".tree") {
    return fail({ErrorKind::usage, job.output, "", "is no name of a file of trees",
                 "name the output .tree"});
  }
  SINEW_CHECKED(check_writable(job.output));
  if (!job.json.empty()) SINEW_CHECKED(check_writable(job.json));
  return {};
}

Result<void> read_options(OptimizeJob& job) {
  SINEW_CHECKED(read_segments(job));
  if (!job.budget.empty()) {
    SINEW_TRY(job.trees.byte_budget, parse_bytes(job.budget, "--budget"));
  }
  if (job.choice != "uniform" && job.choice != "medoids") {
    return fail({ErrorKind::usage, "", fmt::format("--choice '{}'", job.choice),
                 "there is no such choice", "write uniform or medoids"});
  }
  job.trees.choice = job.choice == "medoids" ? FrameChoice::medoids : FrameChoice::uniform;
  return {};
}

// The camera that the trees should suit, if one is asked for.
Result<void> choose_view(OptimizeJob& job, const Scene& scene) {
  if (job.camera.empty()) return {};
  SINEW_TRY(const CameraChoice choice, parse_camera(job.camera));
  const std::string& name = job.trees.clip;
  SINEW_TRY(const int clip, find_clip(scene, name == "all" ? "" : name));
  SINEW_TRY(const FrameCamera camera, FrameCamera::choose(choice, scene, clip, kAspect));
  job.trees.view_share = static_cast<float>(job.view_share);
  job.trees.view = [camera, &scene](const ScenePose& pose) {
    return clip_from_world(camera.view(scene, pose), kAspect);
  };
  return {};
}

// As long as a column.
std::string shortened(const std::string& name) {
  return fmt::format("{:.24}", name) == name ? name : fmt::format("{:.21}...", name);
}

std::string table_of(const AnimationTrees& made) {
  std::string text = fmt::format("{:<24} {:>9} {:>6} {:>8} {:>8} {:>8} {:>8} {:>7}\n", "body",
                                 "triangles", "trees", "cost", "highest", "middle", "rebuild", "s");
  for (const BodyTreeReport& body : made.bodies) {
    const std::string rebuild =
        body.rebuild_cost > 0.0 ? fmt::format("{:.1f}", body.rebuild_cost) : "-";
    text += fmt::format("{:<24} {:>9} {:>6} {:>8.1f} {:>8.1f} {:>8.1f} {:>8} {:>7.2f}\n",
                        shortened(body.name), body.triangles, body.segments, body.cost,
                        body.highest_cost, body.middle_frame_cost, rebuild, body.seconds);
  }
  return text +
         "cost: average over the animation; highest: in its dearest frame; middle: of a tree "
         "for\n"
         "the clip's middle alone; rebuild: of a new tree for every frame\n";
}

// Whose trees do not keep the limit, and what could be done about it.
std::string advice_of(const OptimizeJob& job, const AnimationTrees& made) {
  const uint32_t most = job.trees.most_segments;
  std::string text;
  for (const BodyTreeReport& body : made.bodies) {
    if (!(body.cost > job.trees.cost_limit * body.rebuild_cost) || body.rebuild_cost <= 0.0) {
      continue;
    }
    const std::string remedy = most == 1              ? "try --segments auto"
                               : !job.budget.empty()  ? "try a larger --budget"
                               : body.segments < most ? "more trees would gain little"
                                                      : fmt::format("try --segments {}", 2 * most);
    text += fmt::format("{}: {:.2f} times as dear as new trees, above the limit of {}: {}\n",
                        shortened(body.name), body.cost / body.rebuild_cost, job.trees.cost_limit,
                        remedy);
  }
  return text;
}

std::string json_of(const OptimizeJob& job, const AnimationTrees& made, size_t bytes,
                    double seconds) {
  const auto measured = [](double cost) {
    return cost > 0.0 ? nlohmann::ordered_json(cost) : nlohmann::ordered_json();
  };
  nlohmann::ordered_json bodies = nlohmann::ordered_json::array();
  for (size_t b = 0; b < made.bodies.size(); ++b) {
    const BodyTreeReport& body = made.bodies[b];
    nlohmann::ordered_json begins = nlohmann::ordered_json::array();
    for (const TimedTree& tree : made.trees.bodies[b]) begins.push_back(tree.begin);
    bodies.push_back({{"name", body.name},
                      {"triangles", body.triangles},
                      {"deforms", body.deforms},
                      {"frames", body.frames},
                      {"begins_s", begins},
                      {"cost", body.cost},
                      {"highest_cost", body.highest_cost},
                      {"middle_frame_cost", body.middle_frame_cost},
                      {"rebuild_cost", measured(body.rebuild_cost)},
                      {"seconds", body.seconds}});
  }
  return json_text({{"input", job.input},
                    {"output", job.output},
                    {"bytes", bytes},
                    {"seconds", seconds},
                    {"bodies", bodies}});
}

Result<int> optimize_scene(OptimizeJob job) {
  SINEW_CHECKED(read_options(job));
  SINEW_CHECKED(check_outputs(job));
  const auto start = std::chrono::steady_clock::now();
  const auto elapsed_s = [start] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  const ThreadLimit threads(job.threads);
  SINEW_TRY(Scene scene, load(job.input, job.load));
  SINEW_CHECKED(hide_objects(scene, job.hide));
  print_warnings(scene.warnings);
  SINEW_CHECKED(choose_view(job, scene));
  std::optional<StatusLine> line(std::in_place);
  job.trees.on_step = [&](const TreeProgress& progress) {
    line->show(fmt::format("body {} of {}, {}: {} subtrees moved, {}", progress.body + 1,
                           progress.bodies, shortened(progress.name), progress.step.moved,
                           format_duration(elapsed_s())));
    return true;
  };
  SINEW_TRY(const AnimationTrees made, optimize_trees(scene, job.trees));
  line.reset();
  const std::vector<uint8_t> bytes = encode_trees(made.trees);
  const Uninterrupted writing;
  SINEW_CHECKED(write_file(job.output, std::span<const uint8_t>(bytes)));
  if (!job.json.empty()) {
    SINEW_CHECKED(write_file(job.json, json_of(job, made, bytes.size(), elapsed_s())));
  }
  if (job.output != "-" && job.json != "-")
    SINEW_CHECKED(write_file("-", table_of(made) + advice_of(job, made)));
  return kOk;
}

void define_choice(CLI::App& app, OptimizeJob& job) {
  AnimationTreeOptions& trees = job.trees;
  app.add_option("--clip", trees.clip,
                 "Name or index; all: one tree for the poses of all clips (default: the first)");
  app.add_option("--frames", trees.frames,
                 fmt::format("Frames that stand for each part (default: {})", trees.frames))
      ->check(whole_number_in(1, 64));
  app.add_option("--choice", job.choice,
                 "Which frames: uniform (evenly spread) or medoids (those that stand for the "
                 "others best) (default: uniform)");
  app.add_option("--exponent", trees.exponent,
                 "How much more the dearest frames count: 0, 2, 4 ... (default: 0, the average)")
      ->check(whole_number_in(0, 16));
  app.add_option("--segments", job.segments,
                 fmt::format("Parts of the clip with a tree each, at most: the fewest that keep "
                             "the limit are made; auto: {} (default: 1)",
                             kMostSegments));
  app.add_option("--cost-limit", trees.cost_limit,
                 "What rays may cost on average, against a new tree a frame (default: 1.15)")
      ->check(number_in(1.0, 1000.0));
  app.add_option("--budget", job.budget, "Memory for all trees: 64M, 1G ... (default: no limit)");
}

}  // namespace

Run define_optimize(CLI::App& app) {
  const auto job = std::make_shared<OptimizeJob>();
  app.footer(kExamples);
  app.add_option("INPUT", job->input, "As for `sinew render`")->required();
  app.add_option("-o,--output", job->output, "A .tree file, or - for standard output")->required();
  define_choice(app, *job);
  CLI::Option* camera = app.add_option(
      "--camera", job->camera,
      "Suit this camera's rays more, as for `sinew render` (default: rays from anywhere)");
  app.add_option("--camera-share", job->view_share,
                 "How much of the cost is that of the camera's rays, 0 to 1 (default: 0.5)")
      ->check(number_in(0.0, 1.0))
      ->needs(camera);
  app.add_flag("--derived", job->trees.derived_boxes,
               "Suit the boxes that `render --update lazy` traces");
  app.add_option("--hide", job->hide, "As for `sinew render`; hide the same there");
  app.add_option("--threads", job->threads, "At most so many (default: 0, all)")
      ->check(whole_number_in(0, 4096));
  app.add_option("--json", job->json, "Write a report; - for standard output");
  app.add_flag("--strict", job->load.strict,
               "Fail if the file holds something that is not supported");
  return [job] { return optimize_scene(*job); };
}

}  // namespace sinew::app
