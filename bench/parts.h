// Benches in parts that --only chooses among.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/base/error.h"

namespace sinew::bench {

// Whether a part is to be measured: all are where none is named.
inline bool wants_part(std::span<const std::string> only, std::string_view part) {
  return only.empty() || std::ranges::find(only, part) != only.end();
}

inline Result<void> check_parts(std::span<const std::string> only,
                                const std::vector<std::string>& known) {
  for (const std::string& part : only) {
    if (std::ranges::find(known, part) != known.end()) continue;
    return fail({ErrorKind::usage, "", "--only " + part, "there is no such part",
                 fmt::format("there are {}", fmt::join(known, ", "))});
  }
  return {};
}

}  // namespace sinew::bench
