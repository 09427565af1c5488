// Everything that becomes triangles.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sinew/io/aff/reader.h"

namespace sinew::aff {
namespace {

// Bytes of a Mesh and of what building it takes.
constexpr uint64_t kBytesPerPosition = 2 * sizeof(vec3);
constexpr uint64_t kBytesPerTriangle = 3 * (sizeof(vec3) + sizeof(vec2)) + 100;
constexpr uint64_t kBytesPerMaterial = 2 * sizeof(Material) + sizeof(Fill) + 300;
constexpr uint32_t kMostTimes = 1 << 16;

constexpr std::array<uvec3, 1> kOneTriangle = {uvec3(0, 1, 2)};

bool are_equal(const std::array<vec3, 3>& normals) {
  return normals[0] == normals[1] && normals[1] == normals[2];
}

// "vertices n", "normals n": n rows of three numbers.
Result<std::vector<vec3>> read_vectors(Words& words, std::string_view what) {
  SINEW_TRY(const uint32_t count, words.count(what, 3));
  std::vector<vec3> result(count);
  for (vec3& v : result) SINEW_CHECKED(words.vector(v));
  return result;
}

Result<void> read_indices(Words& words, uvec3& out, size_t below, std::string_view what) {
  for (int k = 0; k < 3; ++k) SINEW_CHECKED(words.index(out[k], below, what));
  return {};
}

}  // namespace

Result<bool> Reader::read_primitive(std::string_view statement, Words& words) {
  Result<void> done;
  if (statement == "m") {
    done = read_mesh(words);
  } else if (statement == "p" || statement == "pp") {
    done = read_polygon(words, statement == "pp");
  } else if (statement == "tt" || statement == "ttp") {
    done = read_textured_triangle(words, statement == "ttp");
  } else if (statement == "tpa") {
    done = read_animated_triangle(words);
  } else if (statement == "s") {
    done = read_sphere(words);
  } else if (statement == "c") {
    done = read_cone(words);
  } else {
    return false;
  }
  return done.map([] { return true; });
}

Result<uint32_t> Reader::use_material(const std::string& texture, const Words& words) {
  const size_t materials = scene_.materials.size(), images = scene_.images.size();
  SINEW_TRY(const uint32_t material, materials_.use(texture, memory_left(), words));
  const size_t added = scene_.materials.size() - materials;
  SINEW_CHECKED(charge(added * (kBytesPerMaterial + texture.size()), words));
  for (size_t i = images; i < scene_.images.size(); ++i) {
    SINEW_CHECKED(charge(scene_.images[i].pixels.size(), words));
  }
  return material;
}

Result<void> Reader::add(Primitive primitive, const std::string& texture, const Words& words) {
  SINEW_CHECKED(charge(kBytesPerPosition * primitive.positions.size() +
                           kBytesPerTriangle * primitive.triangles.size(),
                       words));
  SINEW_TRY(primitive.material, use_material(texture, words));
  const Scope& scope = scopes_.back();
  content_.objects[scope.object].mesh.add(primitive, Placement(scope.to_object));
  return {};
}

Result<void> Reader::add(const Tessellation& shape, const Words& words) {
  Primitive primitive;
  primitive.positions = shape.positions;
  primitive.normals = shape.normals;
  primitive.triangles = shape.triangles;
  return add(primitive, "", words);
}

// "p n", then n points; "pp n", then n points with normals. Becomes a fan, right for convex ones.
Result<void> Reader::read_polygon(Words& words, bool patch) {
  SINEW_TRY(const uint32_t count, words.count("corners", patch ? 6 : 3));
  if (count < 3) {
    return words.error(fmt::format("a polygon has {} corners", count), "give at least 3");
  }
  std::vector<vec3> positions(count), normals(patch ? count : 0);
  for (uint32_t i = 0; i < count; ++i) {
    SINEW_CHECKED(words.vector(positions[i]));
    if (patch) SINEW_CHECKED(words.vector(normals[i]));
  }
  std::vector<uvec3> triangles;
  for (uint32_t i = 1; i + 1 < count; ++i) triangles.emplace_back(0, i, i + 1);
  Primitive primitive;
  primitive.positions = positions;
  primitive.normals = normals;
  primitive.triangles = triangles;
  return add(primitive, "", words);
}

Result<void> Reader::read_sphere(Words& words) {
  vec4 sphere;  // centre, radius
  SINEW_CHECKED(words.vector(sphere));
  if (sphere.w == 0.0f) return words.error("a sphere has radius 0", "give another");
  return add(tessellate_sphere(vec3(sphere), sphere.w), words);
}

Result<void> Reader::read_cone(Words& words) {
  vec4 base, apex;  // centre, radius
  SINEW_CHECKED(words.vector(base));
  SINEW_CHECKED(words.vector(apex));
  const float height = distance(vec3(base), vec3(apex));
  if (!(height > 0.0f) || !std::isfinite(height)) {
    return words.error("a cone's ends lie in one point", "give another");
  }
  return add(tessellate_cone(vec3(base), base.w, vec3(apex), apex.w), words);
}

// "tt texture", then three rows "x y z u v"; "ttp texture", then "x y z nx ny nz u v".
Result<void> Reader::read_textured_triangle(Words& words, bool patch) {
  SINEW_TRY(const std::string texture, words.name("the name of a texture"));
  std::array<vec3, 3> positions, normals;
  std::array<vec2, 3> texcoords;
  for (size_t k = 0; k < 3; ++k) {
    SINEW_CHECKED(words.vector(positions[k]));
    if (patch) SINEW_CHECKED(words.vector(normals[k]));
    SINEW_CHECKED(words.vector(texcoords[k]));
  }
  Primitive primitive;
  primitive.positions = positions;
  if (patch) primitive.normals = normals;
  primitive.texcoords = texcoords;
  primitive.triangles = kOneTriangle;
  return add(primitive, texture, words);
}

// "tpa n", then n times a time and three rows "x y z nx ny nz".
Result<void> Reader::read_animated_triangle(Words& words) {
  SINEW_TRY(const uint32_t count, words.count("times", 19));
  if (count == 0 || count > kMostTimes) {
    return words.error(fmt::format("an animated triangle has {} times", count),
                       fmt::format("give 1 to {}", kMostTimes));
  }
  SINEW_CHECKED(charge(uint64_t{count} * 3 * 4 * sizeof(vec3) + 500, words));
  const Scope& scope = scopes_.back();
  const Placement placement(scope.to_object);
  const uvec3 order = placement.order(uvec3(0, 1, 2));
  std::vector<float> times(count);
  std::vector<vec3> positions(size_t{3} * count);
  uint64_t flat = 0;
  for (uint32_t key = 0; key < count; ++key) {
    double time = 0.0;
    SINEW_CHECKED(words.number(time));
    times[key] = static_cast<float>(time);
    if (key > 0 && times[key] <= times[key - 1]) {
      return words.error("the times of an animated triangle do not increase");
    }
    std::array<vec3, 3> normals;
    for (int k = 0; k < 3; ++k) {
      vec3 position;
      SINEW_CHECKED(words.vector(position));
      SINEW_CHECKED(words.vector(normals[static_cast<size_t>(k)]));
      positions[3 * key + order[k]] = placement.point(position);
    }
    flat += are_equal(normals);
  }
  SINEW_TRY(const uint32_t material, use_material("", words));
  Object& object = content_.objects[scope.object];
  const auto [entry, added] = object.by_times.try_emplace(times, object.animated.size());
  if (added) object.animated.emplace_back().times = std::move(times);
  AnimatedTriangles& group = object.animated[entry->second];
  group.positions.insert(group.positions.end(), positions.begin(), positions.end());
  group.materials.push_back(material);
  group.flat_votes += flat;
  group.smooth_votes += count - flat;
  return {};
}

// "m vertices n ... [normals n ...] [texturecoords n texture ...] triangles n ...", where a
// triangle is three indices from 0 for its vertices, then three for its normals and for its
// coordinates if there are such.
Result<void> Reader::read_mesh(Words& words) {
  SINEW_CHECKED(words.expect("vertices"));
  SINEW_TRY(const std::vector<vec3> positions, read_vectors(words, "vertices"));
  std::vector<vec3> normals;
  if (words.next_is("normals")) {
    words.word();
    SINEW_TRY(normals, read_vectors(words, "normals"));
  }
  std::vector<vec2> texcoords;
  std::string texture;
  if (words.next_is("texturecoords")) {
    words.word();
    SINEW_TRY(const uint32_t count, words.count("texture coordinates", 2));
    SINEW_TRY(texture, words.name("the name of a texture"));
    texcoords.resize(count);
    for (vec2& uv : texcoords) SINEW_CHECKED(words.vector(uv));
  }
  SINEW_CHECKED(words.expect("triangles"));
  const bool has_normals = !normals.empty(), has_texcoords = !texcoords.empty();
  SINEW_TRY(const uint32_t count,
            words.count("triangles", 3u * (1u + has_normals + has_texcoords)));
  SINEW_CHECKED(charge(kBytesPerTriangle * count, words));
  std::vector<uvec3> triangles(count), by_normal(has_normals ? count : 0),
      by_texcoord(has_texcoords ? count : 0);
  for (uint32_t i = 0; i < count; ++i) {
    SINEW_CHECKED(read_indices(words, triangles[i], positions.size(), "vertex"));
    if (has_normals) {
      SINEW_CHECKED(read_indices(words, by_normal[i], normals.size(), "normal"));
    }
    if (has_texcoords) {
      SINEW_CHECKED(read_indices(words, by_texcoord[i], texcoords.size(), "texture coordinate"));
    }
  }
  Primitive primitive;
  primitive.positions = positions;
  primitive.normals = normals;
  primitive.texcoords = texcoords;
  primitive.triangles = triangles;
  primitive.triangle_normals = by_normal;
  primitive.triangle_texcoords = by_texcoord;
  return add(primitive, texture, words);
}

}  // namespace sinew::aff
