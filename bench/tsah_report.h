// The report of `sinew bench tsah` as text for the terminal, and as a page with plots.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "bench/tsah.h"

namespace sinew::bench {

std::string tsah_text(const nlohmann::json& report);
std::string tsah_page(const TsahReport& report);

}  // namespace sinew::bench
