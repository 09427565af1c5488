#include "bench/tsah_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "bench/html_image.h"
#include "bench/svg_plot.h"
#include "sinew/bvh/bounds.h"
#include "sinew/bvh/bvh.h"
#include "sinew/io/image_file.h"
#include "sinew/math/random.h"

namespace sinew::bench {
namespace {

constexpr uint32_t kPictureWidth = 480, kPictureHeight = 360;
constexpr uint32_t kCutParts = 50;  // nodes of the cut have less than this part of the triangles
constexpr uint32_t kLeastNode = 8;  // triangles
constexpr std::array<double, 2> kPictureFrames = {0.0, 0.75};

// The topmost nodes with less than `limit` triangles, and which of them each triangle is in.
struct Cut {
  std::vector<uint32_t> nodes;
  std::vector<uint32_t> part_of;  // one a triangle: index into `nodes`
};

std::vector<uint32_t> node_sizes(const Tree& tree) {
  std::vector<uint32_t> sizes(tree.nodes.size(), 0);
  // Depth-first order is not promised, so parents come before children only on the stack.
  std::vector<uint32_t> order = {Tree::kRoot};
  for (size_t i = 0; i < order.size(); ++i) {
    const TreeNode& node = tree.nodes[order[i]];
    if (node.is_leaf()) continue;
    order.push_back(node.left());
    order.push_back(node.right());
  }
  for (size_t i = order.size(); i-- > 0;) {
    const TreeNode& node = tree.nodes[order[i]];
    sizes[order[i]] = node.is_leaf() ? node.count() : sizes[node.left()] + sizes[node.right()];
  }
  return sizes;
}

Cut cut_tree(const Tree& tree, uint32_t limit) {
  const std::vector<uint32_t> sizes = node_sizes(tree);
  Cut cut;
  cut.part_of.resize(tree.primitives.size());
  struct Item {
    uint32_t node;
    std::optional<uint32_t> part;
  };
  std::vector<Item> stack = {{Tree::kRoot, {}}};
  while (!stack.empty()) {
    Item item = stack.back();
    stack.pop_back();
    const TreeNode& node = tree.nodes[item.node];
    if (!item.part && (sizes[item.node] < limit || node.is_leaf())) {
      item.part = static_cast<uint32_t>(cut.nodes.size());
      cut.nodes.push_back(item.node);
    }
    if (node.is_leaf()) {
      for (uint32_t i = 0; i < node.count(); ++i) {
        cut.part_of[tree.primitives[node.first() + i]] = *item.part;
      }
    } else {
      stack.push_back({node.left(), item.part});
      stack.push_back({node.right(), item.part});
    }
  }
  return cut;
}

// A bright colour for each part, neighbours in number far from each other in hue.
vec3 part_color(uint32_t part) {
  const float hue = 6.0f * std::fmod(0.61803399f * float(part), 1.0f);
  const float value = 0.75f + 0.25f * unit_float(hash_u32(part));
  const auto channel = [&](float shift) {
    const float x = std::fmod(hue + shift, 6.0f);
    return value * (0.35f + 0.65f * std::clamp(std::abs(x - 3.0f) - 1.0f, 0.0f, 1.0f));
  };
  return {channel(0.0f), channel(4.0f), channel(2.0f)};
}

// Which parts have a triangle that moves.
std::vector<uint8_t> moving_parts(const Cut& cut, std::span<const uint8_t> moves) {
  std::vector<uint8_t> out(cut.nodes.size(), 0);
  for (size_t t = 0; t < moves.size(); ++t) out[cut.part_of[t]] |= moves[t];
  return out;
}

std::vector<Ray> picture_rays(const CameraView& camera) {
  const CameraRays ray_of(camera, kPictureWidth, kPictureHeight);
  std::vector<Ray> rays;
  for (uint32_t y = 0; y < kPictureHeight; ++y) {
    for (uint32_t x = 0; x < kPictureWidth; ++x) {
      rays.push_back(ray_of(float(x) + 0.5f, float(y) + 0.5f));
    }
  }
  return rays;
}

// What a picture shows: the triangles that move, all others would hide them.
struct Shown {
  std::vector<uint8_t> moves;     // one a triangle of the scene
  std::vector<uint32_t> numbers;  // of those that move
  std::vector<uvec3> triangles;   // those
};

Image8 paint_parts(const FlatScene& flat, const Shown& shown, const Bvh& bvh,
                   const CameraView& camera, const Cut& cut) {
  Image8 image{kPictureWidth, kPictureHeight, {}};
  image.pixels.assign(size_t{4} * kPictureWidth * kPictureHeight, 0);
  const std::vector<Ray> rays = picture_rays(camera);
  std::vector<Hit> hits(rays.size());
  bvh.closest_hits(rays, hits);
  for (size_t i = 0; i < rays.size(); ++i) {
    if (!hits[i]) continue;
    const uvec3 t = shown.triangles[hits[i].primitive];
    const vec3 a = flat.positions[t.x];
    const vec3 normal = cross(flat.positions[t.y] - a, flat.positions[t.z] - a);
    const float size = length(normal);
    const float facing =
        size > 0.0f ? std::abs(dot(normal, normalize(rays[i].direction))) / size : 0.0f;
    const uint32_t part = cut.part_of[shown.numbers[hits[i].primitive]];
    const vec3 color = part_color(part) * (0.3f + 0.7f * facing);
    for (int c = 0; c < 3; ++c) {
      image.pixels[4 * i + size_t(c)] = static_cast<uint8_t>(255.0f * std::min(color[c], 1.0f));
    }
    image.pixels[4 * i + 3] = 255;
  }
  return image;
}

// Pixels of a point; nothing if it lies behind the eye.
std::optional<vec2> project(const CameraView& camera, vec3 p) {
  const vec3 away = p - camera.to_world[3];
  const vec3 at{dot(away, camera.to_world[0]), dot(away, camera.to_world[1]),
                dot(away, camera.to_world[2])};
  const float height = camera.orthographic ? camera.ymag : -at.z * std::tan(0.5f * camera.yfov);
  if (!(height > 1e-6f) || at.z > 0.0f) return std::nullopt;
  const float scale = 0.5f * float(kPictureHeight) / height;
  return vec2(0.5f * float(kPictureWidth) + at.x * scale,
              0.5f * float(kPictureHeight) - at.y * scale);
}

std::string box_lines(const CameraView& camera, const Box& box, vec3 color) {
  std::array<vec2, 8> corners;
  for (uint32_t c = 0; c < 8; ++c) {
    const auto at = project(camera, {c & 1 ? box.max.x : box.min.x, c & 2 ? box.max.y : box.min.y,
                                     c & 4 ? box.max.z : box.min.z});
    if (!at) return "";
    corners[c] = *at;
  }
  std::string path;
  for (uint32_t c = 0; c < 8; ++c) {
    for (const uint32_t bit : {1u, 2u, 4u}) {
      if (c & bit) continue;
      path += fmt::format("M{:.0f},{:.0f}L{:.0f},{:.0f}", corners[c].x, corners[c].y,
                          corners[c | bit].x, corners[c | bit].y);
    }
  }
  return fmt::format("<path d=\"{}\" stroke=\"#{:02x}{:02x}{:02x}\"/>\n", path,
                     int(255.0f * color.x), int(255.0f * color.y), int(255.0f * color.z));
}

Result<std::string> picture(const FlatClip& clip, const Shown& shown, const Bvh& bvh,
                            const CameraView& camera, const Tree& tree, const std::string& words) {
  const FlatScene& flat = clip.flat();
  const Cut cut = cut_tree(tree, std::max(clip.triangle_count() / kCutParts, kLeastNode));
  const std::vector<uint8_t> moves = moving_parts(cut, shown.moves);
  SINEW_TRY(const std::vector<uint8_t> png,
            encode_png(paint_parts(flat, shown, bvh, camera, cut), "picture"));
  std::vector<Box> boxes(flat.triangles.size());
  triangle_boxes(flat.positions, flat.triangles, boxes);
  const Bounds bounds = refit(tree, boxes);
  std::string out = fmt::format(
      "<td><svg viewBox=\"0 0 {0} {1}\" style=\"width:{0}px;height:{1}px;margin:0\">\n"
      "<image width=\"{0}\" height=\"{1}\" xlink:href=\"data:image/png;base64,{2}\"/>\n"
      "<g fill=\"none\" stroke-width=\"0.8\" stroke-opacity=\"0.7\">\n",
      kPictureWidth, kPictureHeight, base64(png));
  for (uint32_t i = 0; i < cut.nodes.size(); ++i) {
    if (moves[i]) out += box_lines(camera, bounds[cut.nodes[i]], part_color(i));
  }
  return out + fmt::format("</g></svg><br><span class=\"note\">{}: {} boxes</span></td>\n",
                           escape_markup(words), std::ranges::count(moves, uint8_t{1}));
}

// The triangles that are elsewhere later on; all if none is.
Shown moving_triangles(const FlatClip& clip) {
  std::vector<Box> first(clip.triangle_count()), later(first.size());
  Shown out;
  std::vector<uint8_t>& moves = out.moves;
  moves.assign(first.size(), 0);
  clip.boxes(0.0, first);
  for (const double u : kPictureFrames) {
    clip.boxes(u, later);
    for (size_t t = 0; t < moves.size(); ++t) {
      moves[t] |= uint8_t{first[t].min != later[t].min || first[t].max != later[t].max};
    }
  }
  if (std::ranges::count(moves, uint8_t{1}) == 0) std::ranges::fill(moves, uint8_t{1});
  for (uint32_t t = 0; t < moves.size(); ++t) {
    if (!moves[t]) continue;
    out.numbers.push_back(t);
    out.triangles.push_back(clip.triangles()[t]);
  }
  return out;
}

// Sees all that moves.
CameraView picture_camera(const FlatScene& flat, const Shown& shown) {
  Box box;
  for (const uvec3 t : shown.triangles) {
    for (int k = 0; k < 3; ++k) box.extend(flat.positions[t[k]]);
  }
  return frame_box(box, vec3(0.5f, 0.35f, 1.0f), 0.6f,
                   float(kPictureWidth) / float(kPictureHeight));
}

}  // namespace

Result<std::string> tree_pictures(const TsahScene& scene, FlatClip& clip,
                                  std::span<const MethodTrees> methods) {
  const Shown shown = moving_triangles(clip);
  std::string out = fmt::format("<h3>{}</h3>\n<table>\n", escape_markup(scene.name));
  for (const double u : kPictureFrames) {
    clip.set(u);
    const CameraView camera = picture_camera(clip.flat(), shown);
    SINEW_TRY(const Bvh bvh, build(clip.flat().positions, shown.triangles));
    out += "<tr>\n";
    for (const std::string_view name : {kSahFirst, kTsah}) {
      const MethodTrees* const method = find(methods, name);
      if (method == nullptr) continue;
      SINEW_TRY(const std::string cell, picture(clip, shown, bvh, camera, method->at(u).tree,
                                                fmt::format("{} at {:.0f}%", name, 100.0 * u)));
      out += cell;
    }
    out += "</tr>\n";
  }
  return out + "</table>\n";
}

}  // namespace sinew::bench
