// The study scenes, one source file each. study.cpp lists them.
#pragma once

#include "sinew/scene/procedural/study_arguments.h"
#include "sinew/scene/study.h"

namespace sinew {

extern const StudyInfo creature_info;
extern const StudyInfo twist_info;
extern const StudyInfo soup_info;
extern const StudyInfo fracture_info;
extern const StudyInfo bodies_info;
extern const StudyInfo cell24_info;
extern const StudyInfo cloth_info;
extern const StudyInfo herd_info;

Result<Scene> make_creature(const StudyArguments& arguments);
Result<Scene> make_twist(const StudyArguments& arguments);
Result<Scene> make_soup(const StudyArguments& arguments);
Result<Scene> make_fracture(const StudyArguments& arguments);
Result<Scene> make_bodies(const StudyArguments& arguments);
Result<Scene> make_cell24(const StudyArguments& arguments);
Result<Scene> make_cloth(const StudyArguments& arguments);
Result<Scene> make_herd(const StudyArguments& arguments);

}  // namespace sinew
