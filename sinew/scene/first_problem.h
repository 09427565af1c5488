// Gathers the checks of a validate() function and keeps the first that fails.
#pragma once

#include <fmt/core.h>

#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace sinew {

class FirstProblem {
 public:
  bool found() const { return !text_.empty(); }
  const std::string& text() const { return text_; }

  template <class... Args>
  void expect(bool holds, fmt::format_string<Args...> problem, Args&&... args) {
    if (!holds && !found()) text_ = fmt::format(problem, std::forward<Args>(args)...);
  }

  void expect_size(std::string_view what, size_t size, size_t wanted) {
    expect(size == wanted, "{}: {} where {} belong", what, size, wanted);
  }

  // Entries are indices, or vectors of them.
  template <class T>
  void expect_below(std::string_view what, const std::vector<T>& entries, size_t limit) {
    using Index = std::conditional_t<sizeof(T) < sizeof(uint32_t), T, uint32_t>;
    for (size_t i = 0; i < entries.size() && !found(); ++i) {
      for (const uint32_t index : scalars<Index>(entries[i])) {
        expect(index < limit, "{}: entry {} is {} where {} exist", what, i, index, limit);
      }
    }
  }

  // Values are floats, or vectors, quaternions and matrices of them.
  template <class T>
  void expect_finite(std::string_view what, const std::vector<T>& values) {
    for (size_t i = 0; i < values.size() && !found(); ++i) {
      expect(is_finite(values[i]), "{}: entry {} is not finite", what, i);
    }
  }
  template <class T>
  void expect_finite(std::string_view what, const T& value) {
    expect(is_finite(value), "{} is not finite", what);
  }

  // check(element, its own FirstProblem) for each; texts then begin with the element's name.
  template <class T, class Check>
  void expect_each(std::string_view kind, const std::vector<T>& elements, const Check& check) {
    for (size_t i = 0; i < elements.size() && !found(); ++i) {
      FirstProblem own;
      check(elements[i], own);
      if constexpr (requires { elements[i].name; }) {
        expect(!own.found(), "{} {} '{}': {}", kind, i, elements[i].name, own.text());
      } else {
        expect(!own.found(), "{} {}: {}", kind, i, own.text());
      }
    }
  }

 private:
  template <class Scalar, class T>
  static std::span<const Scalar> scalars(const T& value) {
    static_assert(sizeof(T) % sizeof(Scalar) == 0);
    return {reinterpret_cast<const Scalar*>(&value), sizeof(T) / sizeof(Scalar)};
  }
  template <class T>
  static bool is_finite(const T& value) {
    for (const float x : scalars<float>(value)) {
      if (!std::isfinite(x)) return false;
    }
    return true;
  }

  std::string text_;
};

}  // namespace sinew
