#include "sinew/scene/procedural/cloth_simulation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/base/check.h"
#include "sinew/base/parallel.h"
#include "sinew/scene/procedural/cloth_grid.h"
#include "sinew/scene/procedural/cloth_meetings.h"
#include "sinew/scene/procedural/noise.h"

namespace sinew {
namespace {

constexpr size_t kRowsPerTask = 16;
constexpr vec3 kGravity(0.0f, -9.81f, 0.0f);

// Some points of one row, or of a diagonal.
struct Run {
  float* x;
  float* y;
  float* z;

  Run(GridPoints& points, size_t first)
      : x(&points.x[first]), y(&points.y[first]), z(&points.z[first]) {}
};

// A link's length at rest, squared, and the share of its error that it corrects.
struct Link {
  float rest_squared;
  float share;
};

// Jakobsen's link: with d from a to b, both ends move by d (r^2 / (d^2 + r^2) - 1/2), which is half
// of the error to first order and needs no square root.
inline void pull(const Link& link, float& ax, float& ay, float& az, float& bx, float& by,
                 float& bz) {
  const float dx = bx - ax, dy = by - ay, dz = bz - az;
  const float squared = dx * dx + dy * dy + dz * dz;
  const float s = link.share * (link.rest_squared / (squared + link.rest_squared) - 0.5f);
  ax -= s * dx;
  ay -= s * dy;
  az -= s * dz;
  bx += s * dx;
  by += s * dy;
  bz += s * dz;
}

// Links point i of one row with point i of another.
void pull_across(const Link& link, const Run& a, const Run& b, size_t count) {
  float* __restrict ax = a.x, * __restrict ay = a.y, * __restrict az = a.z;
  float* __restrict bx = b.x, * __restrict by = b.y, * __restrict bz = b.z;
  for (size_t i = 0; i < count; ++i) pull(link, ax[i], ay[i], az[i], bx[i], by[i], bz[i]);
}

// Links every point of a row with the point `over` cells on: first the links that start in even
// groups of `over` points, then the others, so that those of a pass share no points.
void pull_along(const Link& link, const Run& r, size_t columns, size_t over) {
  for (size_t pass = 0; pass < 2; ++pass) {
    for (size_t lane = 0; lane < over; ++lane) {
      for (size_t i = pass * over + lane; i + over < columns; i += 2 * over) {
        pull(link, r.x[i], r.y[i], r.z[i], r.x[i + over], r.y[i + over], r.z[i + over]);
      }
    }
  }
}

// Moves a point that is too deep by `depth` along `out`, and takes away as much of its way along
// the surface since `before` as Coulomb's law allows.
vec3 lift(vec3 p, vec3 before, vec3 out, float depth, float friction) {
  p += depth * out;
  const vec3 way = p - before;
  const vec3 sliding = way - dot(way, out) * out;
  const float distance = length(sliding);
  const float held = friction * depth;
  return distance <= held ? p - sliding : p - (held / distance) * sliding;
}

class Cloth {
 public:
  explicit Cloth(const ClothConfig& config)
      : config_(config),
        spacing_(config.width / static_cast<float>(config.cells)),
        step_(static_cast<float>(1.0 / (config.fps * config.steps))),
        points_(start(config)),
        before_(points_),
        velocity_(config.cells),
        meetings_({spacing_, config.cloth_friction}, points_) {
    std::vector<float> places(points_.columns());
    for (size_t i = 0; i < places.size(); ++i) places[i] = spacing_ * static_cast<float>(i);
    while (places.size() > 6) {
      coarse_.emplace_back(places);
      places = coarse_.back().places();
    }
  }

  void advance(uint32_t step) {
    move_freely();
    if (step % config_.search_every == 0) meetings_.search(points_);
    meetings_.push(points_, before_);
    tighten(points_, 0);
    for (uint32_t sweep = 0; sweep < config_.sweeps; ++sweep) pull_links();
    collide();
  }

  void store(vec3* out) const {
    for (size_t i = 0; i < points_.size(); ++i) out[i] = points_.at(i);
  }

 private:
  static GridPoints start(const ClothConfig& config) {
    GridPoints points(config.cells);
    const quat turn = glm::angleAxis(config.tilt, vec3(0.0f, 0.0f, 1.0f)) *
                      glm::angleAxis(config.turn, vec3(0.0f, 1.0f, 0.0f));
    for (size_t i = 0; i < points.size(); ++i) {
      const vec2 at =
          vec2(i % points.columns(), i / points.columns()) / static_cast<float>(config.cells) -
          0.5f;
      const vec3 flat = config.width * vec3(at.x, 0.0f, at.y);
      const float height = config.ripple * gradient_noise(3.0f * flat, 71);
      points.set(i, config.start + turn * (flat + vec3(0.0f, height, 0.0f)));
    }
    return points;
  }

  void move_freely() {
    std::swap(before_, points_);
    const float kept = 1.0f - config_.drag * step_;
    parallel_for(points_.size(), kRowsPerTask * points_.columns(), [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        points_.x[i] = before_.x[i] + step_ * kept * velocity_.x[i];
        points_.y[i] = before_.y[i] + step_ * (kept * velocity_.y[i] + step_ * kGravity.y);
        points_.z[i] = before_.z[i] + step_ * kept * velocity_.z[i];
      }
    });
  }

  void tighten(GridPoints& finer, size_t level) {
    if (level == coarse_.size()) return;
    coarse_[level].correct(finer, [&](GridPoints& points) { tighten(points, level + 1); });
  }

  // Calls body(row) for the rows first, first + stride, ... below `end`, which must not touch each
  // other's points.
  template <class Body>
  void for_rows(size_t first, size_t stride, size_t end, const Body& body) {
    if (end <= first) return;
    const size_t count = (end - first + stride - 1) / stride;
    parallel_for(count, kRowsPerTask, [&](size_t from, size_t to) {
      for (size_t i = from; i < to; ++i) body(first + stride * i);
    });
  }

  void pull_links() {
    const size_t columns = points_.columns(), rows = columns;
    const float squared = spacing_ * spacing_;
    const Link side{squared, 1.0f}, diagonal{2.0f * squared, config_.shear},
        two{4.0f * squared, config_.bend};
    const auto run = [&](size_t row, size_t column) {
      return Run(points_, row * columns + column);
    };
    for (size_t first = 0; first < 4; ++first) {  // rows a multiple of four apart
      for_rows(first, 4, rows - 2,
               [&](size_t r) { pull_across(two, run(r, 0), run(r + 2, 0), columns); });
    }
    for_rows(0, 1, rows, [&](size_t r) {
      pull_along(two, run(r, 0), columns, 2);
      pull_along(side, run(r, 0), columns, 1);
    });
    for (size_t pass = 0; pass < 2; ++pass) {
      for_rows(pass, 2, rows - 1, [&](size_t r) {
        pull_across(diagonal, run(r, 0), run(r + 1, 1), columns - 1);
        pull_across(diagonal, run(r, 1), run(r + 1, 0), columns - 1);
        pull_across(side, run(r, 0), run(r + 1, 0), columns);
      });
    }
  }

  // Keeps points out of the ball and the ground, then takes the velocities from the ways made.
  void collide() {
    const float radius = config_.ball_radius + config_.clearance, to_velocity = 1.0f / step_;
    parallel_for(points_.size(), kRowsPerTask * points_.columns(), [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        vec3 p = points_.at(i);
        const vec3 before = before_.at(i);
        const vec3 from_ball = p - config_.ball;
        const float squared = dot(from_ball, from_ball);
        if (squared < radius * radius && squared > 0.0f) {
          const float distance = std::sqrt(squared);
          p = lift(p, before, from_ball / distance, radius - distance, config_.ball_friction);
        }
        if (p.y < config_.clearance) {
          p = lift(p, before, vec3(0.0f, 1.0f, 0.0f), config_.clearance - p.y,
                   config_.ground_friction);
        }
        points_.set(i, p);
        velocity_.set(i, to_velocity * (p - before));
      }
    });
  }

  ClothConfig config_;
  float spacing_;  // metres
  float step_;     // seconds
  GridPoints points_, before_, velocity_;
  std::vector<CoarseGrid> coarse_;
  ClothMeetings meetings_;
};

}  // namespace

std::vector<vec3> simulate_cloth(const ClothConfig& config) {
  SINEW_CHECK(config.cells >= 4 && config.steps >= 1 && config.search_every >= 1);
  Cloth cloth(config);
  const size_t count = size_t{config.cells + 1} * (config.cells + 1);
  std::vector<vec3> keys((config.frames + size_t{1}) * count);
  cloth.store(keys.data());
  for (uint32_t frame = 1; frame <= config.frames; ++frame) {
    for (uint32_t i = 0; i < config.steps; ++i) cloth.advance((frame - 1) * config.steps + i);
    cloth.store(&keys[frame * count]);
  }
  return keys;
}

}  // namespace sinew
