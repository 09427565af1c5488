// Study scenes: procedural animations made by the project itself, accepted wherever a file is as
// `study:NAME[,key=value...]`.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "sinew/base/error.h"
#include "sinew/scene/scene.h"

namespace sinew {

struct StudyParameter {
  std::string_view name;
  std::string_view meaning;   // with unit and range
  std::string_view fallback;  // its default, as text
};

struct StudyInfo {
  std::string_view name;
  std::string_view summary;
  std::span<const StudyParameter> parameters;
};

// All study scenes, for help texts.
std::span<const StudyInfo> study_scenes();

// `spec` is "NAME" or "NAME,key=value,...". Unknown names, keys and values out of range are usage
// errors that list what there is. The same spec gives the same scene, bit for bit.
Result<Scene> make_study_scene(std::string_view spec);

}  // namespace sinew
