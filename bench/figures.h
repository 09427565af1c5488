// The figures that benches report, what each means, and how good it should be.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace sinew::bench {

struct FigureInfo {
  const char* name;
  const char* unit;
  bool more_is_better;
  std::optional<double> goal, floor;  // figures without are for information
};

// Nullptr if there is no figure of this name.
const FigureInfo* find_figure(std::string_view name);

// One figure of a bench's JSON: a plain number in plain units, with its goal and floor. The name
// must be one that find_figure knows.
nlohmann::json figure(const char* name, double value, const std::string& note);

enum class Verdict { goal, floor, missed, none };  // what a figure reaches
Verdict verdict(const nlohmann::json& figure);
const char* name_of(Verdict verdict);

// {"bench", "version", "machine", "opponents"}: what every bench's JSON begins with.
nlohmann::json report_head(const char* bench);

}  // namespace sinew::bench
