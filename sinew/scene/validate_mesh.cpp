// Every invariant that mesh.h states.
#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/scene/first_problem.h"
#include "sinew/scene/mesh.h"

namespace sinew {
namespace {

constexpr float kUnitTolerance = 1e-3f;  // of lengths and sums that should be 1

void check_triangles(const Mesh& mesh, FirstProblem& problem) {
  constexpr size_t kMost = std::numeric_limits<uint32_t>::max();
  problem.expect(mesh.positions.size() < kMost && mesh.triangles.size() < kMost,
                 "more than 2^32 vertices or triangles");
  problem.expect_finite("positions", mesh.positions);
  problem.expect_below("triangles", mesh.triangles, mesh.positions.size());
  problem.expect_size("triangle_part", mesh.triangle_part.size(), mesh.triangles.size());
  problem.expect_below("triangle_part", mesh.triangle_part, mesh.parts.size());
}

void check_attributes(const Mesh& mesh, FirstProblem& problem) {
  if (!mesh.corners.empty()) {
    problem.expect_size("corners", mesh.corners.size(), mesh.triangles.size());
  }
  const auto check = [&](std::string_view what, const auto& values) {
    if (values.empty() || problem.found()) return;
    if (mesh.corners.empty()) {
      problem.expect_size(what, values.size(), mesh.positions.size());
    } else {
      problem.expect_below("corners", mesh.corners, values.size());
    }
    problem.expect_finite(what, values);
  };
  check("normals", mesh.normals);
  check("tangents", mesh.tangents);
  check("texcoords[0]", mesh.texcoords[0]);
  check("texcoords[1]", mesh.texcoords[1]);
  check("colors", mesh.colors);
  for (size_t i = 0; i < mesh.normals.size() && !problem.found(); ++i) {
    problem.expect(std::abs(length(mesh.normals[i]) - 1.0f) <= kUnitTolerance,
                   "normals: entry {} has length {}", i, length(mesh.normals[i]));
  }
  for (size_t i = 0; i < mesh.tangents.size() && !problem.found(); ++i) {
    problem.expect(std::abs(mesh.tangents[i].w) == 1.0f, "tangents: entry {} has w = {}", i,
                   mesh.tangents[i].w);
  }
}

void check_skin(const Mesh& mesh, FirstProblem& problem) {
  const size_t wanted = mesh.positions.size() * mesh.influences;
  problem.expect_size("joints", mesh.joints.size(), wanted);
  problem.expect_size("weights", mesh.weights.size(), wanted);
  problem.expect_finite("weights", mesh.weights);
  if (mesh.influences == 0) return;
  for (size_t begin = 0; begin < wanted && !problem.found(); begin += mesh.influences) {
    const auto of_vertex = std::span(mesh.weights).subspan(begin, mesh.influences);
    float sum = 0.0f;
    for (const float weight : of_vertex) sum += weight;
    problem.expect(std::ranges::min(of_vertex) >= 0.0f, "weights: vertex {} has a negative one",
                   begin / mesh.influences);
    problem.expect(std::abs(sum - 1.0f) <= kUnitTolerance, "weights: those of vertex {} sum to {}",
                   begin / mesh.influences, sum);
  }
}

void check_morph(const Mesh& mesh, FirstProblem& problem) {
  const size_t targets = mesh.morph_targets;
  problem.expect_size("morph_positions", mesh.morph_positions.size(),
                      targets * mesh.positions.size());
  problem.expect(targets == 0 || !mesh.positions.empty(), "morph targets of no vertices");
  if (!mesh.morph_normals.empty()) {
    problem.expect_size("morph_normals", mesh.morph_normals.size(), targets * mesh.normals.size());
  }
  problem.expect_size("morph_weights", mesh.morph_weights.size(), targets);
  if (!mesh.morph_names.empty()) {
    problem.expect_size("morph_names", mesh.morph_names.size(), targets);
  }
  problem.expect_finite("morph_positions", mesh.morph_positions);
  problem.expect_finite("morph_normals", mesh.morph_normals);
  problem.expect_finite("morph_weights", mesh.morph_weights);
}

void check_keys(const Mesh& mesh, FirstProblem& problem) {
  problem.expect_size("key_positions", mesh.key_positions.size(),
                      size_t{mesh.keys} * mesh.positions.size());
  problem.expect(mesh.keys == 0 || !mesh.positions.empty(), "keys of no vertices");
  problem.expect_finite("key_positions", mesh.key_positions);
}

}  // namespace

std::string validate(const Mesh& mesh) {
  FirstProblem problem;
  for (const auto check :
       {check_triangles, check_attributes, check_skin, check_morph, check_keys}) {
    check(mesh, problem);
  }
  return problem.text();
}

}  // namespace sinew
