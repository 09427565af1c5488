#include "bench/larsson_command.h"

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "app/json_text.h"
#include "app/validators.h"
#include "bench/larsson_tables.h"
#include "sinew/io/output_file.h"

namespace sinew::app {
namespace {

struct Job {
  bench::LarssonOptions options;
  std::string json, first_visit = "node";
  int table = 1;
};

larsson::FirstVisit policy(const std::string& name) {
  if (name == "levels") return larsson::FirstVisit::levels;
  return name == "subtree" ? larsson::FirstVisit::subtree : larsson::FirstVisit::node;
}

Result<int> print_table(Job job) {
  if (!job.json.empty()) SINEW_CHECKED(check_writable(job.json));
  job.options.larsson.first_visit = policy(job.first_visit);
  SINEW_TRY(const nlohmann::json report, job.table == 1 ? bench::larsson_table_1(job.options)
                                                        : bench::larsson_table_2(job.options));
  if (job.json != "-") SINEW_CHECKED(write_file("-", bench::larsson_text(report)));
  if (!job.json.empty()) SINEW_CHECKED(write_file(job.json, json_text(report)));
  return kOk;
}

}  // namespace

LarssonCommand define_larsson(CLI::App& bench) {
  const auto job = std::make_shared<Job>();
  bench::LarssonOptions& o = job->options;
  CLI::App* const command = bench.add_subcommand(
      "larsson", "The two tables of Larsson and Akenine-Moller 2003: their updates and ours");
  command->footer(
      "Up: the update, without making the vertices. Rt: all ray queries of a picture, without\n"
      "shading: primary rays, shadow rays to both lights, one reflection, and its shadow rays.\n"
      "All methods answer the same rays. Theirs have one thread. Sinew's lazy method does what "
      "its\n"
      "hybrid one does, for the vertices are given.\n\n"
      "Examples:\n"
      "  sinew bench larsson --table 1 --json report.json\n"
      "  sinew bench larsson --table 2 --museum scene_museum/aff/museum5.aff\n");
  CLI::App& c = *command;
  c.add_option("--table", job->table, "1: deforming bodies; 2: BART's Museum (default: 1)")
      ->check(whole_number_in(1, 2));
  c.add_option("--museum", o.museum, "BART's museum5.aff, for table 2 (default: " + o.museum + ")");
  c.add_option("--width", o.width, "Pixels (default: 640)")->check(whole_number_in(16, 8192));
  c.add_option("--height", o.height, "Pixels (default: 480)")->check(whole_number_in(16, 8192));
  c.add_option("--frames", o.frames, "How many frames of the animation (default: 28)")
      ->check(whole_number_in(1, 1000));
  c.add_option("--repeats", o.repeats, "Of subsampled frames; medians count (default: 3)")
      ->check(whole_number_in(1, 1000));
  c.add_option("--threads", o.threads, "Of our second rows (default: 2)")
      ->check(whole_number_in(1, 256));
  c.add_option("--first-visit", job->first_visit,
               "What their hybrid method makes where a ray comes first (default: node)")
      ->check(CLI::IsMember({"node", "levels", "subtree"}));
  c.add_option("--levels", o.larsson.visit_levels, "How many, of --first-visit levels (default: 2)")
      ->check(whole_number_in(1, 16));
  c.add_option("--depth", o.larsson.depth,
               "Where their hybrid update begins (default: half the height of the tree)")
      ->check(whole_number_in(0, 64));
  c.add_option("--json", job->json, "Write the report; - for stdout, without the table");
  return {[command] { return command->parsed(); }, [job] { return print_table(*job); }};
}

}  // namespace sinew::app
