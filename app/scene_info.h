// A scene's contents in words and as JSON.
#pragma once

#include <string>

#include "sinew/scene/scene.h"

namespace sinew::app {

std::string scene_info_text(const Scene& scene, const std::string& input);
std::string scene_info_json(const Scene& scene, const std::string& input);

// The study scenes and their parameters.
std::string study_list_text();
std::string study_list_json();

}  // namespace sinew::app
