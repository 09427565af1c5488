// A bench's report as text for the terminal.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace sinew::bench {

std::string trace_text(const nlohmann::json& report);
std::string update_text(const nlohmann::json& report);

}  // namespace sinew::bench
