#include "sinew/io/vox/quantize.h"

#include <algorithm>

#include "sinew/base/check.h"
#include "sinew/math/srgb.h"
#include "sinew/math/vec.h"
#include "sinew/svo/format.h"

namespace sinew::vox {
namespace {

struct Entry {
  SurfaceColor what;
  vec3 color;  // square roots of linear light: steps look about alike
  double weight;
};

struct ColorBox {
  size_t begin, end;  // in the list of entries
  glm::dvec3 mean{0.0};
  double error = 0.0;  // sum of weighted squares about the mean
  int axis = 0;        // along which it errs most
};

ColorBox make_box(const std::vector<Entry>& entries, size_t begin, size_t end) {
  ColorBox box{begin, end};
  double weight = 0.0;
  for (size_t i = begin; i < end; ++i) {
    box.mean += entries[i].weight * glm::dvec3(entries[i].color);
    weight += entries[i].weight;
  }
  box.mean /= weight;
  glm::dvec3 errors(0.0);
  for (size_t i = begin; i < end; ++i) {
    const glm::dvec3 away = glm::dvec3(entries[i].color) - box.mean;
    errors += entries[i].weight * away * away;
  }
  for (int k = 1; k < 3; ++k) {
    if (errors[k] > errors[box.axis]) box.axis = k;
  }
  // One entry errs by what rounds, which no cut makes less.
  box.error = end - begin > 1 ? errors.x + errors.y + errors.z : 0.0;
  return box;
}

// Where the upper half begins.
size_t cut(std::vector<Entry>& entries, const ColorBox& box) {
  const auto begin = entries.begin() + static_cast<ptrdiff_t>(box.begin);
  const auto end = entries.begin() + static_cast<ptrdiff_t>(box.end);
  const auto middle = std::partition(
      begin, end, [&](const Entry& e) { return e.color[box.axis] < box.mean[box.axis]; });
  return static_cast<size_t>(middle - entries.begin());
}

std::array<uint8_t, 3> srgb_of(const glm::dvec3& root) {
  std::array<uint8_t, 3> result;
  for (int k = 0; k < 3; ++k) {
    result[static_cast<size_t>(k)] = linear_to_srgb_code(static_cast<float>(root[k] * root[k]));
  }
  return result;
}

}  // namespace

Palette quantize(const std::map<SurfaceColor, uint64_t>& counts, size_t most) {
  std::vector<Entry> entries;
  std::vector<size_t> begins;
  for (const auto& [what, count] : counts) {
    if (entries.empty() || entries.back().what.surface != what.surface) {
      begins.push_back(entries.size());
    }
    entries.push_back({what, glm::sqrt(unpack_color(what.color)), static_cast<double>(count)});
  }
  SINEW_CHECK(begins.size() <= most);
  std::vector<ColorBox> boxes;
  for (size_t i = 0; i < begins.size(); ++i) {
    const size_t end = i + 1 < begins.size() ? begins[i + 1] : entries.size();
    boxes.push_back(make_box(entries, begins[i], end));
  }
  while (boxes.size() < most && !boxes.empty()) {
    const auto worst = std::ranges::max_element(boxes, {}, &ColorBox::error);
    if (!(worst->error > 0.0)) break;
    const ColorBox box = *worst;
    const size_t middle = cut(entries, box);
    if (middle == box.begin || middle == box.end) {  // all alike but for rounding
      worst->error = 0.0;
      continue;
    }
    *worst = make_box(entries, box.begin, middle);
    boxes.push_back(make_box(entries, middle, box.end));
  }
  Palette palette;
  for (size_t b = 0; b < boxes.size(); ++b) {
    palette.entries.push_back({entries[boxes[b].begin].what.surface, srgb_of(boxes[b].mean)});
    for (size_t i = boxes[b].begin; i < boxes[b].end; ++i) {
      palette.index[entries[i].what] = static_cast<uint8_t>(b);
    }
  }
  return palette;
}

}  // namespace sinew::vox
