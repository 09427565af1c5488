#include "sinew/bvh/bvh.h"

#include <array>
#include <atomic>
#include <cmath>

#include "sinew/base/check.h"
#include "sinew/base/update_gate.h"
#include "sinew/bvh/cost.h"
#include "sinew/bvh/update/visit.h"

namespace sinew {
namespace {

Result<void> check_finite(std::span<const vec3> positions) {
  for (size_t i = 0; i < positions.size(); ++i) {
    const vec3 p = positions[i];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
      return fail({ErrorKind::bad_input, "", "vertex " + std::to_string(i),
                   "its position is not finite", "remove or repair it"});
    }
  }
  return {};
}

// The body in one pose.
struct PosedBvh {
  UpdateMode mode = UpdateMode::full;
  Bvh8 bvh;
  VisitedBody visited;
  std::vector<vec3> copy;  // of the vertices, as far as `visited` reads them there
  WorkTime work;           // of the update
  UpdateGate gate;
  mutable std::atomic<uint64_t> rays = 0;  // of spans, since the update
};

}  // namespace

struct Bvh::Impl {
  Bvh8Layout layout;
  double built_cost = 0.0;
  WayUp way;  // empty until the first update of a range
  UpdateMode mode = UpdateMode::automatic;
  UpdateHistory history;
  std::array<PosedBvh, 2> poses;
  uint32_t shown = 0;
  bool staged = false;  // the other pose is to be shown next

  PosedBvh& now() { return poses[shown]; }
  const PosedBvh& now() const { return poses[shown]; }
  Result<void> check_count(size_t count) const;
  void show_built(std::span<const vec3> positions) {
    update_full(layout, positions, now().bvh);
    built_cost = upper_cost(layout, now().bvh);
  }
  UpdateMode next_mode();
  void update(std::span<const vec3> positions, bool borrowed, PosedBvh& out);
  Instance instance() const;
  void count(size_t rays) const {
    if (rays > 1) now().rays.fetch_add(rays, std::memory_order_relaxed);
  }
};

Result<void> Bvh::Impl::check_count(size_t count) const {
  if (count == layout.vertex_count) return {};
  return fail({ErrorKind::usage, "", "",
               "update got " + std::to_string(count) + " vertices, the body has " +
                   std::to_string(layout.vertex_count),
               "give all vertices in the order of build()"});
}

UpdateMode Bvh::Impl::next_mode() {
  if (mode != UpdateMode::automatic) return mode == UpdateMode::lazy ? UpdateMode::hybrid : mode;
  const PosedBvh& last = now();
  UpdateOutcome outcome;
  outcome.mode = last.mode;
  outcome.treelets = static_cast<double>(layout.treelets.size());
  outcome.made = last.visited.made.load(std::memory_order_relaxed);
  outcome.rays = static_cast<double>(last.rays.load(std::memory_order_relaxed));
  outcome.update_ns = last.work.ns();
  outcome.timed = timed_treelets(last.visited);
  outcome.make_ns = last.visited.make_work.ns();
  if (outcome.rays == 0.0 && outcome.made == 0.0) return choose_mode(false, std::nullopt, history);
  return choose_mode(false, outcome, history);
}

void Bvh::Impl::update(std::span<const vec3> positions, bool borrowed, PosedBvh& out) {
  const UpdateGate::Update updating(out.gate);
  out.mode = next_mode();
  out.visited.made.store(0, std::memory_order_relaxed);
  out.visited.make_work.reset();
  out.work.reset();
  out.rays.store(0, std::memory_order_relaxed);
  if (out.mode == UpdateMode::full) {
    update_full(layout, positions, out.bvh, &out.work);
    return;
  }
  out.copy.clear();
  if (!borrowed) out.copy.assign(positions.begin(), positions.end());
  out.visited.layout = &layout;
  out.visited.bvh = &out.bvh;
  out.visited.positions = borrowed ? positions.data() : out.copy.data();
  update_hybrid(layout, positions, out.bvh, &out.work);
  out.visited.upper.store(out.bvh.root, std::memory_order_release);
}

Instance Bvh::Impl::instance() const {
  const PosedBvh& posed = now();
  Instance instance;
  instance.nodes = posed.bvh.nodes.data();
  if (!posed.bvh.by_links) instance.packets = posed.bvh.packets.data();
  instance.corners = layout.packet_corners.data();
  instance.vertices = posed.bvh.vertices.data();
  instance.primitives = layout.packet_primitives.data();
  instance.root = posed.bvh.root;
  // What rays make is no change of the body, so queries are const.
  if (posed.bvh.by_links) instance.body = const_cast<VisitedBody*>(&posed.visited);
  return instance;
}

Bvh::Bvh() : impl_(std::make_unique<Impl>()) {}
Bvh::Bvh(Bvh&&) noexcept = default;
Bvh& Bvh::operator=(Bvh&&) noexcept = default;
Bvh::~Bvh() = default;

Result<Bvh> build(std::span<const vec3> positions, std::span<const uvec3> triangles,
                  const BuildConfig& config) {
  SINEW_CHECKED(check_finite(positions));
  Bvh bvh;
  SINEW_TRY(bvh.impl_->layout, build_layout(positions, triangles, config));
  bvh.impl_->show_built(positions);
  return bvh;
}

Result<Bvh> build(std::span<const vec3> positions, std::span<const uvec3> triangles,
                  const Tree& tree, std::span<const float> areas) {
  SINEW_CHECKED(check_finite(positions));
  SINEW_CHECKED(check_triangles(triangles, positions.size()));
  const auto count = static_cast<uint32_t>(triangles.size());
  if (const std::string problem = validate(tree, count); !problem.empty()) {
    return fail({ErrorKind::bad_input, "", "tree", problem, "build it for these triangles"});
  }
  std::vector<float> own;
  if (areas.empty()) {
    std::vector<Box> boxes(count);
    triangle_boxes(positions, triangles, boxes);
    own = half_areas(refit(tree, boxes));
  }
  Bvh bvh;
  SINEW_TRY(bvh.impl_->layout, make_layout(tree, areas.empty() ? own : areas, triangles,
                                           static_cast<uint32_t>(positions.size())));
  bvh.impl_->show_built(positions);
  return bvh;
}

Result<void> Bvh::update(std::span<const vec3> positions) {
  SINEW_CHECKED(impl_->check_count(positions.size()));
  impl_->update(positions, false, impl_->now());
  return {};
}

Result<void> Bvh::update_borrowed(std::span<const vec3> positions) {
  SINEW_CHECKED(impl_->check_count(positions.size()));
  impl_->update(positions, true, impl_->now());
  return {};
}

Result<void> Bvh::update(std::span<const vec3> positions, VertexRange changed) {
  SINEW_CHECKED(impl_->check_count(positions.size()));
  if (uint64_t{changed.first} + changed.count > positions.size()) {
    return fail({ErrorKind::usage, "", "",
                 "vertices " + std::to_string(changed.first) + " to " +
                     std::to_string(uint64_t{changed.first} + changed.count) +
                     " are to be updated, the body has " + std::to_string(positions.size()),
                 "give a range within the body's vertices"});
  }
  PosedBvh& posed = impl_->now();
  // After a flip() to what was never staged there is nothing to start from.
  if (posed.bvh.links.size() != impl_->layout.treelets.size()) return update(positions);
  if (impl_->way.first.empty()) impl_->way = find_way_up(impl_->layout);
  const UpdateGate::Update updating(posed.gate);
  if (posed.bvh.by_links) {
    if (posed.copy.empty()) posed.copy.assign(positions.begin(), positions.end());
    std::copy_n(positions.begin() + changed.first, changed.count,
                posed.copy.begin() + changed.first);
    posed.visited.positions = posed.copy.data();
  }
  posed.visited.made.store(0, std::memory_order_relaxed);
  posed.visited.make_work.reset();
  posed.rays.store(0, std::memory_order_relaxed);
  update_local(impl_->layout, positions, changed, impl_->way, posed.bvh);
  posed.visited.upper.store(posed.bvh.root, std::memory_order_release);
  return {};
}

Result<void> Bvh::stage(std::span<const vec3> positions) {
  SINEW_CHECKED(impl_->check_count(positions.size()));
  impl_->update(positions, false, impl_->poses[1 - impl_->shown]);
  impl_->staged = true;
  return {};
}

void Bvh::flip() {
  const UpdateGate::Update updating(impl_->now().gate);
  if (!impl_->staged) return;
  impl_->shown = 1 - impl_->shown;
  impl_->staged = false;
}

void Bvh::set_update_mode(UpdateMode mode) {
  impl_->mode = mode;
}
UpdateChoice Bvh::choice() const {
  return impl_->history.choice;
}

std::optional<Hit> Bvh::closest_hit(const Ray& ray) const {
  Hit hit;
  closest_hits({&ray, 1}, {&hit, 1});
  if (!hit) return std::nullopt;
  return hit;
}

bool Bvh::any_hit(const Ray& ray) const {
  uint8_t hit = 0;
  any_hits({&ray, 1}, {&hit, 1});
  return hit != 0;
}

void Bvh::closest_hits(std::span<const Ray> rays, std::span<Hit> hits,
                       const QueryOptions& options) const {
  impl_->count(rays.size());
  const UpdateGate::Query running(impl_->now().gate);
  const Instance only = impl_->instance();
  sinew::closest_hits({nullptr, &only, 1}, rays, hits, options);
}

void Bvh::any_hits(std::span<const Ray> rays, std::span<uint8_t> hit,
                   const QueryOptions& options) const {
  impl_->count(rays.size());
  const UpdateGate::Query running(impl_->now().gate);
  const Instance only = impl_->instance();
  sinew::any_hits({nullptr, &only, 1}, rays, hit, options);
}

void Bvh::all_hits(const Ray& ray, std::vector<Hit>& out, const QueryOptions& options) const {
  const UpdateGate::Query running(impl_->now().gate);
  const Instance only = impl_->instance();
  sinew::all_hits({nullptr, &only, 1}, ray, out, options);
}

std::optional<NearestPoint> Bvh::nearest_point(vec3 from, float max_distance) const {
  const UpdateGate::Query running(impl_->now().gate);
  const Instance only = impl_->instance();
  return sinew::nearest_point({nullptr, &only, 1}, from, max_distance);
}

void Bvh::triangles_in_box(const Box& box, std::vector<TriangleId>& out) const {
  const UpdateGate::Query running(impl_->now().gate);
  const Instance only = impl_->instance();
  sinew::triangles_in_box({nullptr, &only, 1}, box, out);
}

double Bvh::cost_ratio() const {
  const double now = upper_cost(impl_->layout, impl_->now().bvh);
  return impl_->built_cost > 0.0 ? now / impl_->built_cost : 1.0;
}

const Box& Bvh::box() const {
  return impl_->now().bvh.box;
}
uint32_t Bvh::triangle_count() const {
  return impl_->layout.triangle_count;
}
uint32_t Bvh::treelet_count() const {
  return static_cast<uint32_t>(impl_->layout.treelets.size());
}
uint32_t Bvh::treelets_made() const {
  const PosedBvh& posed = impl_->now();
  return posed.bvh.by_links ? posed.visited.made.load(std::memory_order_relaxed) : treelet_count();
}
size_t Bvh::bytes() const {
  return bytes_of(impl_->layout) + bytes_of(impl_->poses[0].bvh) + bytes_of(impl_->poses[1].bvh);
}

}  // namespace sinew
