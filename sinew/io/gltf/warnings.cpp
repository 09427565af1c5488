#include "sinew/io/gltf/warnings.h"

#include <fmt/format.h>

#include <algorithm>

namespace sinew::gltf {

constexpr size_t kMostKinds = 64;

void Warnings::add(const std::string& element, const std::string& problem) {
  const auto same = std::find_if(entries_.begin(), entries_.end(),
                                 [&](const Entry& entry) { return entry.problem == problem; });
  if (same != entries_.end()) {
    ++same->count;
  } else if (entries_.size() < kMostKinds) {
    entries_.push_back({element, problem, 1});
  } else {
    ++dropped_;
  }
}

std::vector<std::string> Warnings::texts() const {
  std::vector<std::string> result;
  for (const Entry& entry : entries_) {
    std::string where = entry.element;
    if (entry.count > 1) where += fmt::format(" and {} more", entry.count - 1);
    result.push_back(where.empty() ? entry.problem : where + ": " + entry.problem);
  }
  if (dropped_ > 0) result.push_back(fmt::format("{} further warnings", dropped_));
  return result;
}

}  // namespace sinew::gltf
