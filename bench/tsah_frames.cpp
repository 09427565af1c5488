#include "bench/tsah_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <numeric>

#include "bench/contest.h"
#include "bench/figures.h"
#include "bench/measure.h"
#include "bench/tsah_engines.h"

namespace sinew::bench {
namespace {

using nlohmann::json;

constexpr size_t kTrialRays = 100000;  // of a kind, to find the best call
constexpr int kTrials = 3;

enum Kind : size_t { kPrimary, kShadow, kAmbient, kKinds };
constexpr std::array<const char*, kKinds> kKindNames = {"primary", "shadow", "ambient"};

// Which of its calls an opponent uses for each kind of ray.
using CallChoice = std::array<size_t, kKinds>;

// Room for the answers to a workload.
struct Answers {
  std::vector<Hit> hits;
  std::array<std::vector<uint8_t>, kKinds> any;
};

const std::vector<Ray>& rays_of(const Workload& work, Kind kind) {
  return kind == kPrimary ? work.primary : kind == kShadow ? work.shadow : work.ambient;
}

void trace(const Call& call, Kind kind, const Workload& work, Answers& answers) {
  const std::vector<Ray>& rays = rays_of(work, kind);
  if (kind == kPrimary) {
    answers.hits.resize(rays.size());
    trace_closest(call, rays, answers.hits);
  } else {
    answers.any[kind].resize(rays.size());
    trace_any(call, rays, answers.any[kind]);
  }
}

// One engine in one frame: what each repeat took.
struct Cell {
  std::vector<double> update;
  std::array<std::vector<double>, kKinds> trace;
  size_t hits = 0;

  double trace_ms(Kind kind) const { return median(trace[kind]); }
  double update_ms() const { return median(update); }
  void forget_first() {  // it warmed up
    update.erase(update.begin());
    for (std::vector<double>& ms : trace) ms.erase(ms.begin());
  }
};

// An engine with what was measured.
struct Entry {
  std::unique_ptr<FrameEngine> engine;
  CallChoice choice{};
  std::vector<Cell> frames;
};

struct FrameCost {
  double update = 0.0, primary = 0.0, secondary = 0.0;  // ms
  double rays = 0.0;
  double full() const { return update + primary + secondary; }
};

Workload make_frame_workload(const FlatClip& clip, const FrameEngine& engine,
                             const TsahOptions& options) {
  const float aspect = float(options.width) / float(options.height);
  std::vector<Ray> primary = primary_rays(clip.camera(aspect), options.width, options.height);
  std::vector<Hit> hits(primary.size());
  trace_closest(engine.calls(TriangleTest::robust).back(), primary, hits);
  return make_workload(clip.flat(), std::move(primary), hits);
}

// The fastest call of an engine for every kind of ray.
CallChoice choose_calls(const FrameEngine& engine, TriangleTest test, Workload work) {
  thin_out(work.primary, kTrialRays);
  thin_out(work.shadow, kTrialRays);
  thin_out(work.ambient, kTrialRays);
  Answers answers;
  const std::vector<Call> calls = engine.calls(test);
  CallChoice choice{};
  for (const Kind kind : {kPrimary, kShadow, kAmbient}) {
    double least = 0.0;
    for (size_t c = 0; c < calls.size(); ++c) {
      std::vector<double> ms;
      for (int i = 0; i < kTrials; ++i) {
        ms.push_back(milliseconds([&] { trace(calls[c], kind, work, answers); }));
      }
      if (c > 0 && median(ms) >= least) continue;
      least = median(ms);
      choice[kind] = c;
    }
  }
  return choice;
}

class FrameContest {
 public:
  FrameContest(FlatClip& clip, const TsahOptions& options, TriangleTest test)
      : clip_(clip), options_(options), test_(test) {}

  void add(std::unique_ptr<FrameEngine> engine) { entries_.push_back({std::move(engine), {}, {}}); }
  Result<void> add_trees(std::span<const MethodTrees> methods, std::string_view name) {
    const MethodTrees* const method = find(methods, name);
    if (method == nullptr) return {};
    SINEW_TRY(auto engine, make_refit_engine(*method, clip_.flat()));
    add(std::move(engine));
    return {};
  }
  void add_embree() {
    const auto add_mode = [&](const char* name, EmbreeMode mode) {
      add(make_embree_engine(name, mode, test_, clip_.flat()));
    };
    clip_.set(0.5);
    add_mode("embree refit, middle", EmbreeMode::refit);
    clip_.set(0.0);
    add_mode("embree refit", EmbreeMode::refit);
    add_mode("embree low rebuild", EmbreeMode::low);
    add_mode("embree medium rebuild", EmbreeMode::medium);
    add_mode("embree high rebuild", EmbreeMode::high);
  }

  void run() {
    for (uint32_t f = 0; f < options_.frames; ++f) measure(f);
  }

  TriangleTest test() const { return test_; }
  const std::vector<Entry>& entries() const { return entries_; }
  double u_of(uint32_t frame) const { return (frame + 0.5) / options_.frames; }
  FrameCost cost(const Entry& entry, uint32_t frame) const {
    const Cell& cell = entry.frames[frame];
    return {cell.update_ms(), cell.trace_ms(kPrimary),
            cell.trace_ms(kShadow) + cell.trace_ms(kAmbient), rays_[frame]};
  }

 private:
  void choose(const Workload& work) {
    // One of each family stands for it: calls are a matter of the kernels, not of the tree.
    const Entry* ours = nullptr;
    const Entry* theirs = nullptr;
    for (const Entry& entry : entries_) {
      (entry.engine->name().starts_with("embree") ? theirs : ours) = &entry;
    }
    const CallChoice our_choice = choose_calls(*ours->engine, test_, work);
    const CallChoice their_choice =
        theirs == nullptr ? CallChoice{} : choose_calls(*theirs->engine, test_, work);
    for (Entry& entry : entries_) {
      entry.choice = entry.engine->name().starts_with("embree") ? their_choice : our_choice;
    }
  }

  // Brings all engines to the frame and measures it, in turn.
  void measure(uint32_t f) {
    clip_.set(u_of(f));
    for (Entry& entry : entries_) {
      entry.engine->prepare(clip_.flat(), u_of(f));
      entry.engine->update();
      entry.frames.emplace_back();
    }
    const Workload work = make_frame_workload(clip_, *entries_.front().engine, options_);
    if (f == 0) choose(work);
    rays_.push_back(double(work.primary.size() + work.shadow.size() + work.ambient.size()));
    Answers answers;
    std::vector<Rival> rivals;
    for (Entry& entry : entries_) {
      rivals.push_back({entry.engine->name(), [&](uint32_t) { run(entry, work, answers); }});
    }
    compete(rivals, {1, options_.repeats}, 0);
    for (Entry& entry : entries_) entry.frames.back().forget_first();
  }

  void run(Entry& entry, const Workload& work, Answers& answers) {
    Cell& cell = entry.frames.back();
    cell.update.push_back(milliseconds([&] { entry.engine->update(); }));
    const std::vector<Call> calls = entry.engine->calls(test_);
    for (const Kind kind : {kPrimary, kShadow, kAmbient}) {
      cell.trace[kind].push_back(
          milliseconds([&] { trace(calls[entry.choice[kind]], kind, work, answers); }));
    }
    cell.hits = static_cast<size_t>(
        std::ranges::count_if(answers.hits, [](const Hit& hit) { return bool(hit); }));
  }

  FlatClip& clip_;
  const TsahOptions& options_;
  TriangleTest test_;
  std::vector<Entry> entries_;
  std::vector<double> rays_;  // of every frame
};

FrameCost mean_cost(const FrameContest& contest, const Entry& entry) {
  FrameCost sum;
  const double count = double(entry.frames.size());
  for (uint32_t f = 0; f < entry.frames.size(); ++f) {
    const FrameCost one = contest.cost(entry, f);
    sum.update += one.update / count;
    sum.primary += one.primary / count;
    sum.secondary += one.secondary / count;
    sum.rays += one.rays / count;
  }
  return sum;
}

json call_names(const FrameContest& contest, const Entry& entry) {
  const std::vector<Call> calls = entry.engine->calls(contest.test());
  json out;
  for (const Kind kind : {kPrimary, kShadow, kAmbient}) {
    out[kKindNames[kind]] = calls[entry.choice[kind]].name;
  }
  return out;
}

void add_rows(const TsahScene& scene, const FlatClip& clip, const FrameContest& contest,
              json& rows) {
  for (const Entry& entry : contest.entries()) {
    const FrameCost cost = mean_cost(contest, entry);
    json u = json::array(), ms = json::array(), rate = json::array(), hits = json::array();
    for (uint32_t f = 0; f < entry.frames.size(); ++f) {
      const FrameCost one = contest.cost(entry, f);
      u.push_back(contest.u_of(f));
      ms.push_back(one.full());
      rate.push_back(one.rays / (one.primary + one.secondary) * 1e-3);
      hits.push_back(entry.frames[f].hits);
    }
    rows.push_back({{"table", "tsah_frame"},
                    {"scene", scene.name},
                    {"motion", name_of(scene.motion)},
                    {"triangles", clip.triangle_count()},
                    {"test", name_of(contest.test())},
                    {"method", entry.engine->name()},
                    {"update_ms", cost.update},
                    {"trace_ms", cost.primary + cost.secondary},
                    {"mrays_per_s", cost.rays / (cost.primary + cost.secondary) * 1e-3},
                    {"total_ms", cost.full()},
                    {"primary_ms", cost.update + cost.primary},
                    {"rays", cost.rays},
                    {"primary_hits", std::move(hits)},
                    {"calls", call_names(contest, entry)}});
    rows.push_back({{"table", "frame_time"},
                    {"scene", scene.name},
                    {"test", name_of(contest.test())},
                    {"method", entry.engine->name()},
                    {"x", std::move(u)},
                    {"y", std::move(ms)},
                    {"mrays_per_s", std::move(rate)}});
  }
}

// All methods with the fast test; the watertight one for those who may win.
Result<void> run_contest(const TsahScene& scene, FlatClip& clip,
                         std::span<const MethodTrees> methods, const TsahOptions& options,
                         TriangleTest test, json& rows) {
  FrameContest contest(clip, options, test);
  clip.set(0.0);
  SINEW_CHECKED(contest.add_trees(methods, kTsah));
  SINEW_CHECKED(contest.add_trees(methods, kSegments3));
  SINEW_CHECKED(contest.add_trees(methods, kSegmentsAuto));
  SINEW_CHECKED(contest.add_trees(methods, kSahMiddle));
  if (test == TriangleTest::fast) {
    SINEW_CHECKED(contest.add_trees(methods, kSahFirst));
    SINEW_CHECKED(contest.add_trees(methods, kSahBest));
    for (const Rebuild how :
         {Rebuild::best, Rebuild::binned, Rebuild::hlbvh_med, Rebuild::hlbvh_sah}) {
      contest.add(make_rebuild_engine(how, clip.flat()));
    }
  }
  contest.add_embree();
  contest.run();
  add_rows(scene, clip, contest, rows);
  return {};
}

// A method's row of table 2; nullptr if there is none.
const json* frame_row(const json& rows, std::string_view scene, const char* test,
                      std::string_view method) {
  for (const json& row : rows) {
    if (row["table"] == "tsah_frame" && row["scene"] == scene && row["test"] == test &&
        row["method"] == method) {
      return &row;
    }
  }
  return nullptr;
}

// The least `what` of Embree's modes.
const json* best_embree(const json& rows, std::string_view scene, const char* test,
                        const char* what) {
  const json* best = nullptr;
  for (const json& row : rows) {
    if (row["table"] != "tsah_frame" || row["scene"] != scene || row["test"] != test) continue;
    if (!row["method"].get<std::string>().starts_with("embree")) continue;
    if (best == nullptr || row[what].get<double>() < (*best)[what].get<double>()) best = &row;
  }
  return best;
}

struct Ratios {
  std::vector<double> values;
  std::string words;

  void add(const std::string& words_for_it, double value) {
    values.push_back(value);
    words += fmt::format("{}{} {:.2f}", words.empty() ? "" : ", ", words_for_it, value);
  }
  void write(const char* name, const char* note, json& figures) const {
    if (values.empty()) return;
    figures.push_back(
        figure(name, geometric_mean(values), fmt::format("{}, geometric mean: {}", note, words)));
  }
};

void add_speedup(const json& rows, const json& ours, const char* test, const char* what,
                 Ratios& out) {
  const std::string scene = ours["scene"];
  const json* const theirs = best_embree(rows, scene, test, what);
  if (theirs == nullptr) return;
  out.add(fmt::format("{} ({})", scene, (*theirs)["method"].get<std::string>()),
          (*theirs)[what].get<double>() / ours[what].get<double>());
}

}  // namespace

Result<void> measure_frames(const TsahScene& scene, FlatClip& clip,
                            std::span<const MethodTrees> methods, const TsahOptions& options,
                            json& rows) {
  for (const TriangleTest test : {TriangleTest::fast, TriangleTest::robust}) {
    SINEW_CHECKED(run_contest(scene, clip, methods, options, test, rows));
  }
  return {};
}

void add_frame_figures(const json& rows, json& figures) {
  Ratios full, primary, full_robust, primary_robust, regret;
  for (const json& row : rows) {
    if (row["table"] != "tsah_frame" || row["method"] != kTsah) continue;
    const std::string scene = row["scene"], motion = row["motion"];
    const bool fast = row["test"] == name_of(TriangleTest::fast);
    const char* const test = name_of(fast ? TriangleTest::fast : TriangleTest::robust);
    if (motion != "rigid") {
      add_speedup(rows, row, test, "total_ms", fast ? full : full_robust);
      add_speedup(rows, row, test, "primary_ms", fast ? primary : primary_robust);
    }
    if (!fast || motion != "scattering") continue;
    const json* const segments = frame_row(rows, scene, test, kSegmentsAuto);
    const json* const rebuilt = frame_row(rows, scene, test, kSahRebuild);
    if (segments == nullptr || rebuilt == nullptr) continue;
    regret.add(scene, (*segments)["trace_ms"].get<double>() / (*rebuilt)["trace_ms"].get<double>());
  }
  full.write("frame_full", "best of Embree's modes over T-SAH, update and 11 rays a pixel",
             figures);
  if (!full.values.empty()) {
    figures.push_back(figure("frame_full_least", *std::ranges::min_element(full.values),
                             "the same, the scene where it is least"));
  }
  full_robust.write("frame_full_robust", "the same, both watertight", figures);
  primary.write("frame_primary", "the same, primary rays only", figures);
  primary_robust.write("frame_primary_robust", "the same, both watertight", figures);
  regret.write("segments_regret",
               "time of all rays with at most 4 trees over that with a tree for every frame",
               figures);
}

}  // namespace sinew::bench
