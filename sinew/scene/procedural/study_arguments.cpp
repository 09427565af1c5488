#include "sinew/scene/procedural/study_arguments.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "sinew/base/check.h"

namespace sinew {
namespace {

const StudyParameter* find_parameter(const StudyInfo& info, std::string_view name) {
  const auto found = std::ranges::find(info.parameters, name, &StudyParameter::name);
  return found == info.parameters.end() ? nullptr : &*found;
}

std::string parameter_list(const StudyInfo& info) {
  std::string list = "its parameters are";
  for (const StudyParameter& p : info.parameters) {
    list += fmt::format("{} {}={}", &p == info.parameters.data() ? "" : ",", p.name, p.fallback);
  }
  return list;
}

tl::unexpected<Error> usage(const StudyInfo& info, std::string problem, std::string remedy) {
  return fail({ErrorKind::usage, fmt::format("study:{}", info.name), "", std::move(problem),
               std::move(remedy)});
}

// The whole text as a number, or nothing.
template <class T>
bool read_number(std::string_view text, T& value) {
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end;
}

}  // namespace

Result<StudyArguments> StudyArguments::parse(const StudyInfo& info, std::string_view text) {
  StudyArguments arguments;
  arguments.info_ = &info;
  while (!text.empty()) {
    const size_t comma = text.find(',');
    const std::string_view item = text.substr(0, comma);
    text = comma == std::string_view::npos ? std::string_view() : text.substr(comma + 1);
    const size_t equals = item.find('=');
    if (equals == 0 || equals == std::string_view::npos || equals + 1 == item.size() ||
        (text.empty() && comma != std::string_view::npos)) {
      return usage(info, fmt::format("cannot read '{}' as key=value", item), parameter_list(info));
    }
    const std::string_view key = item.substr(0, equals);
    if (!find_parameter(info, key)) {
      return usage(info, fmt::format("has no parameter '{}'", key), parameter_list(info));
    }
    if (!arguments.given_.emplace(key, item.substr(equals + 1)).second) {
      return usage(info, fmt::format("parameter '{}' is given twice", key), "give it once");
    }
  }
  return arguments;
}

std::string_view StudyArguments::text_of(std::string_view name) const {
  if (const auto found = given_.find(name); found != given_.end()) return found->second;
  const StudyParameter* parameter = find_parameter(*info_, name);
  SINEW_CHECK(parameter != nullptr);
  return parameter->fallback;
}

tl::unexpected<Error> StudyArguments::rejected(std::string_view name,
                                               const std::string& wanted) const {
  return usage(*info_, fmt::format("{}={} is not {}", name, text_of(name), wanted),
               std::string(find_parameter(*info_, name)->meaning));
}

Result<uint32_t> StudyArguments::integer(std::string_view name, uint32_t low, uint32_t high) const {
  uint32_t value = 0;
  if (!read_number(text_of(name), value) || value < low || value > high) {
    return rejected(name, fmt::format("a whole number from {} to {}", low, high));
  }
  return value;
}

Result<double> StudyArguments::number(std::string_view name, double low, double high) const {
  double value = 0.0;
  if (!read_number(text_of(name), value) || !(value >= low && value <= high)) {
    return rejected(name, fmt::format("a number from {} to {}", low, high));
  }
  return value;
}

Result<uint32_t> StudyArguments::choice(std::string_view name,
                                        std::initializer_list<std::string_view> words) const {
  const auto found = std::ranges::find(words, text_of(name));
  if (found != words.end()) return static_cast<uint32_t>(found - words.begin());
  return rejected(name, fmt::format("one of {}", fmt::join(words, ", ")));
}

}  // namespace sinew
