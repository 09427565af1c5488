// The report of `sinew bench asvo` as text for the terminal, and as a page with plots.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "bench/asvo.h"

namespace sinew::bench {

std::string asvo_text(const nlohmann::json& report);
std::string asvo_page(const AsvoReport& report);

}  // namespace sinew::bench
