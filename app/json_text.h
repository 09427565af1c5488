// JSON documents as text. Names in files need not be UTF-8; what is not becomes U+FFFD.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace sinew::app {

inline std::string json_text(const nlohmann::ordered_json& document) {
  return document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace sinew::app
