// The `key=value,...` part of a study scene's name, checked against the scene's own list of
// parameters. Every error names the scene, the key, and what would be accepted.
#pragma once

#include <initializer_list>
#include <map>
#include <string>
#include <string_view>

#include "sinew/base/error.h"
#include "sinew/scene/study.h"

namespace sinew {

class StudyArguments {
 public:
  // `text` is "key=value,..." or empty. The info must outlive the arguments.
  static Result<StudyArguments> parse(const StudyInfo& info, std::string_view text);

  // The value given for `name`, or its fallback. `name` must be one of the scene's parameters.
  Result<uint32_t> integer(std::string_view name, uint32_t low, uint32_t high) const;
  Result<double> number(std::string_view name, double low, double high) const;
  // The index of the value among `words`.
  Result<uint32_t> choice(std::string_view name,
                          std::initializer_list<std::string_view> words) const;

 private:
  std::string_view text_of(std::string_view name) const;
  tl::unexpected<Error> rejected(std::string_view name, const std::string& wanted) const;

  const StudyInfo* info_ = nullptr;
  std::map<std::string, std::string, std::less<>> given_;
};

}  // namespace sinew
