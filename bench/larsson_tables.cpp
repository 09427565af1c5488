#include "bench/larsson_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>

#include "bench/larsson_engines.h"
#include "bench/larsson_scene.h"
#include "bench/measure.h"
#include "sinew/base/parallel.h"
#include "sinew/bvh/trace/traverse.h"

namespace sinew::bench {
namespace {

constexpr std::array<uint32_t, 3> kSteps = {1, 5, 10};  // a ray for each step x step pixels
constexpr uint32_t kCheapestFrame = 200;                // of L's first experiment
constexpr size_t kBottomUp = 0, kHybrid = 1;            // places among the contenders

// An engine with a number of threads; several contenders may share an engine.
struct Contender {
  std::string name;
  int threads = 1;
  TableEngine* engine = nullptr;
};

struct Contest {
  std::vector<std::unique_ptr<TableEngine>> engines;
  std::vector<Contender> contenders;
  std::unique_ptr<TableEngine> reference;  // says what to trace and what is right; not timed

  void add(std::unique_ptr<TableEngine> engine, std::string name, int threads = 1) {
    contenders.push_back({name, 1, engine.get()});
    if (threads > 1) contenders.push_back({std::move(name), threads, engine.get()});
    engines.push_back(std::move(engine));
  }
};

Result<Contest> make_contest(const TableScene& scene, const LarssonOptions& options) {
  Contest out;
  const std::span<const BodyInput> bodies = scene.bodies();
  out.add(make_larsson_engine(bodies, LarssonUpdate::bottom_up, options.larsson), "L bottom-up");
  out.add(make_larsson_engine(bodies, LarssonUpdate::hybrid, options.larsson), "L hybrid");
  // Not `automatic`: it learns from the frames before, of which these tables leave most out.
  for (const UpdateMode mode : {UpdateMode::full, UpdateMode::hybrid, UpdateMode::lazy}) {
    SINEW_TRY(auto engine, make_sinew_engine(bodies, mode));
    out.add(std::move(engine), std::string("sinew ") + name_of(mode), options.threads);
  }
  SINEW_TRY(out.reference, make_sinew_engine(bodies, UpdateMode::full));
  return out;
}

struct Answers {
  std::vector<Hit> primary, reflection;
  std::vector<uint8_t> shadow, reflection_shadow;

  void resize(const TableRays& rays) {
    primary.resize(rays.primary.size());
    reflection.resize(rays.reflection.size());
    shadow.resize(rays.shadow.size());
    reflection_shadow.resize(rays.reflection_shadow.size());
  }
};

// How many rays two engines answer differently.
struct Differences {
  size_t hits = 0;     // of closest-hit rays
  size_t shadows = 0;  // of shadow rays
};

Differences compare(const Answers& a, const Answers& b) {
  Differences out;
  const auto compare_hits = [&](const std::vector<Hit>& x, const std::vector<Hit>& y) {
    for (size_t i = 0; i < x.size(); ++i) {
      out.hits += x[i].object != y[i].object || (x[i] && x[i].primitive != y[i].primitive);
    }
  };
  const auto compare_bits = [&](const std::vector<uint8_t>& x, const std::vector<uint8_t>& y) {
    for (size_t i = 0; i < x.size(); ++i) out.shadows += (x[i] != 0) != (y[i] != 0);
  };
  compare_hits(a.primary, b.primary);
  compare_hits(a.reflection, b.reflection);
  compare_bits(a.shadow, b.shadow);
  compare_bits(a.reflection_shadow, b.reflection_shadow);
  return out;
}

// One contender in one frame.
struct Cell {
  double update_ms = 0.0, trace_ms = 0.0;
  Differences differ;  // from the reference's answers
  larsson::UpdateWork updated, visited;

  double total() const { return update_ms + trace_ms; }
};

struct FrameResult {
  uint32_t frame = 0, step = 0;
  size_t hit_rays = 0, shadow_rays = 0;
  std::vector<Cell> cells;  // one a contender
};

double trace_all(TableEngine& engine, const TableRays& rays, Answers& out) {
  return milliseconds([&] {
    engine.closest_hits(rays.primary, out.primary);
    engine.any_hits(rays.shadow, out.shadow);
    engine.closest_hits(rays.reflection, out.reflection);
    engine.any_hits(rays.reflection_shadow, out.reflection_shadow);
  });
}

// Contenders take turns, each from the update to the last answer.
FrameResult measure_frame(const TableScene& scene, Contest& contest, const LarssonOptions& options,
                          uint32_t frame, uint32_t step) {
  TableEngine& reference = *contest.reference;
  reference.begin_frame(scene.frame());
  TableRays rays;
  make_rays(scene, reference, options.width, options.height, step, rays);
  Answers expected, answers;
  expected.resize(rays);
  answers.resize(rays);
  trace_all(reference, rays, expected);

  FrameResult out{frame, step, rays.primary.size() + rays.reflection.size(),
                  rays.shadow.size() + rays.reflection_shadow.size(),
                  std::vector<Cell>(contest.contenders.size())};
  std::vector<std::vector<double>> update(out.cells.size()), trace(out.cells.size());
  for (uint32_t r = 0; r < (step == 1 ? 1 : options.repeats); ++r) {
    for (size_t c = 0; c < out.cells.size(); ++c) {
      const Contender& contender = contest.contenders[c];
      const ThreadLimit limit(contender.threads);
      update[c].push_back(milliseconds([&] { contender.engine->begin_frame(scene.frame()); }));
      trace[c].push_back(trace_all(*contender.engine, rays, answers));
      out.cells[c].differ = compare(answers, expected);
      out.cells[c].updated = contender.engine->update_work();
      out.cells[c].visited = contender.engine->visit_work();
    }
  }
  for (size_t c = 0; c < out.cells.size(); ++c) {
    out.cells[c].update_ms = median(update[c]);
    out.cells[c].trace_ms = median(trace[c]);
  }
  return out;
}

// Evenly spread, the last one among them; `wanted` replaces the nearest if it is not.
std::vector<uint32_t> choose_frames(uint32_t count, uint32_t frames, uint32_t wanted) {
  std::vector<uint32_t> out;
  const uint32_t chosen = std::min(count, frames);
  for (uint32_t i = 1; i <= chosen; ++i) {
    out.push_back(static_cast<uint32_t>(uint64_t{i} * count / chosen));
  }
  if (wanted > 0 && wanted <= count) {
    const auto nearest = std::ranges::min_element(
        out, {}, [&](uint32_t frame) { return frame > wanted ? frame - wanted : wanted - frame; });
    *nearest = wanted;
  }
  return out;
}

// L's "ave", "worst" and "best": the mean over all frames, and the frames that take L's bottom-up
// method the most and the least time at a ray a pixel.
struct Case {
  std::string name;
  std::vector<const FrameResult*> frames;
};

std::vector<const FrameResult*> with_sampling(std::span<const FrameResult> results, uint32_t step) {
  std::vector<const FrameResult*> out;
  for (const FrameResult& result : results) {
    if (result.step == step) out.push_back(&result);
  }
  return out;
}

std::vector<Case> cases_of(std::span<const FrameResult> results, uint32_t step) {
  const std::vector<const FrameResult*> frames = with_sampling(results, step);
  const std::vector<const FrameResult*> whole = with_sampling(results, 1);
  const auto [best, worst] = std::ranges::minmax_element(
      whole, {}, [](const FrameResult* f) { return f->cells[kBottomUp].total(); });
  return {{"ave", frames},
          {"worst", {frames[static_cast<size_t>(worst - whole.begin())]}},
          {"best", {frames[static_cast<size_t>(best - whole.begin())]}}};
}

template <class Value>
double mean(const Case& of, const Value& value) {
  double sum = 0.0;
  for (const FrameResult* frame : of.frames) sum += value(*frame);
  return sum / double(of.frames.size());
}

double mean_total(const Case& of, size_t contender) {
  return mean(of, [&](const FrameResult& f) { return f.cells[contender].total(); });
}

nlohmann::json table_line(const Case& of, uint32_t step, const Contest& contest, size_t c) {
  return {{"case", of.name},
          {"sampling", step},
          {"frame", of.name == "ave" ? nlohmann::json() : nlohmann::json(of.frames[0]->frame)},
          {"engine", contest.contenders[c].name},
          {"threads", contest.contenders[c].threads},
          {"update_ms", mean(of, [&](const FrameResult& f) { return f.cells[c].update_ms; })},
          {"trace_ms", mean(of, [&](const FrameResult& f) { return f.cells[c].trace_ms; })},
          {"total_ms", mean_total(of, c)},
          {"speedup", mean_total(of, kBottomUp) / mean_total(of, c)}};
}

nlohmann::json frame_row(const FrameResult& result, const Contest& contest, size_t c) {
  const Cell& cell = result.cells[c];
  nlohmann::json row = {{"frame", result.frame},
                        {"sampling", result.step},
                        {"hit_rays", result.hit_rays},
                        {"shadow_rays", result.shadow_rays},
                        {"engine", contest.contenders[c].name},
                        {"threads", contest.contenders[c].threads},
                        {"update_ms", cell.update_ms},
                        {"trace_ms", cell.trace_ms},
                        {"hits_differ", cell.differ.hits},
                        {"shadows_differ", cell.differ.shadows}};
  if (cell.updated.boxes > 0) {
    row["updated"] = {{"vertices", cell.updated.vertices}, {"boxes", cell.updated.boxes}};
    row["visited"] = {{"vertices", cell.visited.vertices}, {"boxes", cell.visited.boxes}};
  }
  return row;
}

// "sinew full", 2 threads -> "sinew_full_2t"
std::string figure_part(const Contender& contender) {
  std::string out = contender.name;
  for (char& c : out) c = c == ' ' || c == '-' ? '_' : c;
  return contender.threads > 1 ? out + "_" + std::to_string(contender.threads) + "t" : out;
}

// Figures whose names begin with the table's.
struct Figures {
  std::string table;
  nlohmann::json list = nlohmann::json::array();

  void add(const std::string& name, double value, const char* better, const std::string& note) {
    list.push_back({{"name", table + "_" + name},
                    {"value", value},
                    {"unit", "1"},
                    {"better", better},
                    {"note", note}});
  }
};

void add_speedups(std::span<const FrameResult> results, const Contest& contest, Figures& out) {
  for (const uint32_t step : kSteps) {
    const Case all{"ave", with_sampling(results, step)};
    for (size_t c = kHybrid; c < contest.contenders.size(); ++c) {
      out.add(fmt::format("speedup_{}x{}_{}", step, step, figure_part(contest.contenders[c])),
              mean_total(all, kBottomUp) / mean_total(all, c), "more",
              "average frame time of L's bottom-up method over this one's");
    }
  }
}

// L's model of its updates beside what they did.
void add_model(const TableScene& scene, std::span<const FrameResult> results, Figures& out) {
  Case every{"", {}};
  for (const FrameResult& result : results) every.frames.push_back(&result);
  const auto mean_update = [&](size_t c) {
    return mean(every, [&](const FrameResult& f) { return f.cells[c].update_ms; });
  };
  const larsson::UpdateWork whole = results[0].cells[kBottomUp].updated;
  const larsson::UpdateWork upper = results[0].cells[kHybrid].updated;
  out.add("update_speedup_hybrid", mean_update(kBottomUp) / mean_update(kHybrid), "more",
          "time of L's bottom-up update over that of its hybrid update");
  out.add("update_speedup_predicted",
          larsson::predicted_speedup(double(scene.largest_moving_body()), 8.0), "more",
          "L's equation 7 with k = 8 for the triangles of the largest body");
  out.add("update_speedup_limit", larsson::speedup_limit(8.0), "more",
          "what it stays below (equation 10); it is above 8 for trees of height 4 or more");
  out.add("update_speedup_counted",
          double(whole.vertices + whole.boxes) / double(upper.vertices + upper.boxes), "more",
          "vertices and boxes of a bottom-up update over those of a hybrid one, as counted");
  out.add("hybrid_vertices_per_triangle", double(upper.vertices) / double(scene.moving_triangles()),
          "less", "read by a hybrid update; L's model: 0.5 in closed meshes, 3 in soups");
  out.add("hybrid_box_share", double(upper.boxes) / double(whole.boxes), "less",
          "of all boxes, written by a hybrid update");
  for (const uint32_t step : kSteps) {
    const double visited = mean({"", with_sampling(results, step)}, [](const FrameResult& f) {
      return double(f.cells[kHybrid].visited.boxes);
    });
    out.add(fmt::format("hybrid_visited_share_{}x{}", step, step), visited / double(whole.boxes),
            "less", "of all boxes, made by first visits");
  }
}

void add_differences(std::span<const FrameResult> results, const Contest& contest, Figures& out) {
  size_t hits = 0, shadows = 0, hit_rays = 0, shadow_rays = 0;
  for (size_t c = 0; c < contest.contenders.size(); ++c) {
    size_t contender_hits = 0, contender_shadows = 0;
    for (const FrameResult& result : results) {
      contender_hits += result.cells[c].differ.hits;
      contender_shadows += result.cells[c].differ.shadows;
    }
    hits = std::max(hits, contender_hits);
    shadows = std::max(shadows, contender_shadows);
  }
  for (const FrameResult& result : results) {
    hit_rays += result.hit_rays;
    shadow_rays += result.shadow_rays;
  }
  out.add("hits_differ", double(hits) / double(std::max<size_t>(hit_rays, 1)), "less",
          "share of closest-hit rays for which two methods name different triangles, at most");
  out.add("shadows_differ", double(shadows) / double(std::max<size_t>(shadow_rays, 1)), "less",
          "share of shadow rays on which two methods do not agree, at most");
}

nlohmann::json figures_of(const std::string& table, const TableScene& scene,
                          std::span<const FrameResult> results, const Contest& contest) {
  Figures out{table};
  add_speedups(results, contest, out);
  add_model(scene, results, out);
  add_differences(results, contest, out);
  return out.list;
}

Result<nlohmann::json> measure_table(const std::string& input, const std::string& table_name,
                                     uint32_t wanted_frame, const LarssonOptions& options) {
  SINEW_TRY(TableScene scene, TableScene::make(input));
  SINEW_TRY(Contest contest, make_contest(scene, options));
  const auto frames = choose_frames(scene.frame_count(), options.frames, wanted_frame);
  std::vector<FrameResult> results;
  for (const uint32_t step : kSteps) {
    for (const uint32_t frame : frames) {
      scene.set_frame(frame);
      results.push_back(measure_frame(scene, contest, options, frame, step));
    }
  }
  nlohmann::json table = nlohmann::json::array(), rows = nlohmann::json::array();
  for (const uint32_t step : kSteps) {
    for (const Case& of : cases_of(results, step)) {
      for (size_t c = 0; c < contest.contenders.size(); ++c) {
        table.push_back(table_line(of, step, contest, c));
      }
    }
  }
  for (const FrameResult& result : results) {
    for (size_t c = 0; c < contest.contenders.size(); ++c) {
      rows.push_back(frame_row(result, contest, c));
    }
  }
  return nlohmann::json{{"bench", "larsson"},
                        {"version", SINEW_VERSION},
                        {"machine", {{"threads", options.threads}, {"kernels", kernel_target()}}},
                        {"opponents", {"Larsson and Akenine-Moller 2003, scalar, one thread"}},
                        {"scene", scene.name()},
                        {"moving_triangles", scene.moving_triangles()},
                        {"width", options.width},
                        {"height", options.height},
                        {"frames", frames.size()},
                        {"figures", figures_of(table_name, scene, results, contest)},
                        {"table", std::move(table)},
                        {"rows", std::move(rows)}};
}

}  // namespace

Result<nlohmann::json> larsson_table_1(const LarssonOptions& options) {
  return measure_table("study:bodies,motion=free", "l1", kCheapestFrame, options);
}

Result<nlohmann::json> larsson_table_2(const LarssonOptions& options) {
  return measure_table("aff:complexity=8," + options.museum, "l2", 0, options);
}

std::string larsson_text(const nlohmann::json& report) {
  std::string out =
      fmt::format("{}: {} moving triangles, {}x{}, {} frames; up: update, rt: ray queries, in ms\n",
                  report["scene"].get<std::string>(), report["moving_triangles"].get<uint64_t>(),
                  report["width"].get<uint32_t>(), report["height"].get<uint32_t>(),
                  report["frames"].get<size_t>());
  out += fmt::format("{:<11} {:>5}  {:<14} {:>7} {:>9} {:>9} {:>9} {:>8}\n", "case", "sampl",
                     "method", "threads", "up", "rt", "tot", "speedup");
  std::string last;
  for (const auto& line : report["table"]) {
    const uint32_t step = line["sampling"];
    std::string name = line["case"], sampling = fmt::format("{}x{}", step, step);
    if (!line["frame"].is_null()) name += fmt::format(" ({})", line["frame"].get<uint32_t>());
    if (const std::string here = name + sampling; here == last) {
      name.clear(), sampling.clear();
    } else {
      last = here;
    }
    out += fmt::format("{:<11} {:>5}  {:<14} {:>7} {:9.2f} {:9.2f} {:9.2f} {:8.2f}\n", name,
                       sampling, line["engine"].get<std::string>(), line["threads"].get<int>(),
                       line["update_ms"].get<double>(), line["trace_ms"].get<double>(),
                       line["total_ms"].get<double>(), line["speedup"].get<double>());
  }
  for (const auto& f : report["figures"]) {
    out += fmt::format("{} = {:.4g}: {}\n", f["name"].get<std::string>(), f["value"].get<double>(),
                       f["note"].get<std::string>());
  }
  return out;
}

}  // namespace sinew::bench
