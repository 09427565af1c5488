// Collects what a loader ignored or corrected, one warning for each kind of problem, so that a file
// with a thousand bad channels gives one line.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace sinew::gltf {

class Warnings {
 public:
  // `element` is the part of the file concerned, or empty.
  void add(const std::string& element, const std::string& problem);
  // "animation 2 and 3 more: ..." in the order of first appearance.
  std::vector<std::string> texts() const;

 private:
  struct Entry {
    std::string element;
    std::string problem;
    size_t count = 0;
  };
  std::vector<Entry> entries_;
  size_t dropped_ = 0;  // kinds of problems beyond what a reader wants to see
};

}  // namespace sinew::gltf
