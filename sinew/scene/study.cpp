// Finds a study scene by its name and hands its arguments on.
#include "sinew/scene/study.h"

#include <array>

#include "sinew/scene/procedural/scenes.h"

namespace sinew {
namespace {

using Maker = Result<Scene> (*)(const StudyArguments&);
constexpr std::array<Maker, 8> kMakers{make_creature, make_twist,  make_soup,  make_fracture,
                                       make_bodies,   make_cell24, make_cloth, make_herd};

}  // namespace

std::span<const StudyInfo> study_scenes() {
  static const std::array<StudyInfo, kMakers.size()> infos{creature_info, twist_info,  soup_info,
                                                           fracture_info, bodies_info, cell24_info,
                                                           cloth_info,    herd_info};
  return infos;
}

Result<Scene> make_study_scene(std::string_view spec) {
  const size_t comma = spec.find(',');
  const std::string_view name = spec.substr(0, comma);
  const std::string_view rest =
      comma == std::string_view::npos ? std::string_view() : spec.substr(comma + 1);
  std::string names;
  const std::span<const StudyInfo> scenes = study_scenes();
  for (size_t i = 0; i < scenes.size(); ++i) {
    names += (i == 0 ? "" : ", ") + std::string(scenes[i].name);
    if (scenes[i].name != name) continue;
    if (comma != std::string_view::npos && rest.empty()) {
      return fail({ErrorKind::usage, "study:" + std::string(name), "",
                   "a parameter is missing after the comma", "write key=value, or no comma"});
    }
    SINEW_TRY(const StudyArguments arguments, StudyArguments::parse(scenes[i], rest));
    SINEW_TRY(Scene scene, kMakers[i](arguments));
    scene.name = "study:" + std::string(spec);
    list_objects(scene);
    return scene;
  }
  return fail({ErrorKind::usage, "study:" + std::string(spec), "",
               "there is no study scene '" + std::string(name) + "'", "there are " + names});
}

}  // namespace sinew
