// A bench's JSON as one HTML page that needs nothing else: figures with their goals, plots, rows.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace sinew::bench {

// Takes what bench_trace or bench_update gave.
std::string report_page(const nlohmann::json& report);

}  // namespace sinew::bench
