// Times and averages, and figures without a goal (figures.h has those with one).
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace sinew::bench {

template <class F>
double milliseconds(const F& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

inline double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const size_t half = values.size() / 2;
  return values.size() % 2 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

inline double geometric_mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += std::log(value);
  return values.empty() ? 0.0 : std::exp(sum / double(values.size()));
}

// One figure of a bench's JSON: a plain number in plain units.
inline nlohmann::json figure(const char* name, double value, const char* unit, const char* better,
                             const std::string& note) {
  return {{"name", name}, {"value", value}, {"unit", unit}, {"better", better}, {"note", note}};
}

}  // namespace sinew::bench
