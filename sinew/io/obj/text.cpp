#include "sinew/io/obj/text.h"

#include <fmt/format.h>

#include "sinew/io/text.h"

namespace sinew {

constexpr size_t kMostKindsIgnored = 24;

tl::expected<size_t, std::string> take_numbers(ObjWords& words, std::span<float> out,
                                               size_t least) {
  const auto problem = [](std::string text) {
    return tl::unexpected<std::string>(std::move(text));
  };
  size_t count = 0;
  for (; count < out.size() && !words.at_end(); ++count) {
    const ObjNumber number = words.number(out[count]);
    if (number == ObjNumber::ok) continue;
    const char* wanted = number == ObjNumber::none ? "number" : "finite number";
    return problem(fmt::format("\"{}\" is not a {}", printable(words.word()), wanted));
  }
  if (!words.at_end()) return problem(fmt::format("has more than {} numbers", out.size()));
  if (count < least) return problem(fmt::format("has fewer than {} numbers", least));
  return count;
}

bool IgnoredStatements::add(std::string_view statement, uint64_t line) {
  const std::string name = printable(statement);
  const auto known = std::find_if(entries_.begin(), entries_.end(),
                                  [&](const Entry& entry) { return entry.name == name; });
  if (known != entries_.end()) {
    ++known->count;
    return true;
  }
  if (entries_.size() >= kMostKindsIgnored) return false;
  entries_.push_back({name, line, 1});
  return true;
}

void IgnoredStatements::append_warnings(const std::string& prefix,
                                        std::vector<std::string>& warnings) const {
  for (const Entry& entry : entries_) {
    warnings.push_back(
        fmt::format("{}line {}: statement \"{}\" is not supported: ignored {} time{}", prefix,
                    entry.line, entry.name, entry.count, entry.count == 1 ? "" : "s"));
  }
}

}  // namespace sinew
