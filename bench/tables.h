// A bench's report as text for the terminal.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace sinew::bench {

// What such texts have in common: who takes part, and the figures with their goals.
std::string bench_head(const nlohmann::json& report);
std::string figures_text(const nlohmann::json& figures);
// A line for each thing that the report says was skipped, after an empty one; empty if none was.
std::string skipped_text(const nlohmann::json& report);

std::string trace_text(const nlohmann::json& report);
std::string update_text(const nlohmann::json& report);

}  // namespace sinew::bench
