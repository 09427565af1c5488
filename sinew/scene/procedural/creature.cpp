#include "sinew/scene/procedural/scenes.h"
namespace sinew {
const StudyInfo creature_info{"creature", "a walking creature", {}};
Result<Scene> make_creature(const StudyArguments&) {
  return Scene{};
}
}  // namespace sinew
