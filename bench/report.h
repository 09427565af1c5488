// A bench's JSON as one HTML page that needs nothing else: figures with their goals, plots, rows.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace sinew::bench {

// Takes what bench_trace or bench_update gave.
std::string report_page(const nlohmann::json& report);

// The same with a body of the caller's between the figures and what was skipped.
std::string html_page(const nlohmann::json& report, const std::string& body);

}  // namespace sinew::bench
