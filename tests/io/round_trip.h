// Scenes that were saved and loaded again, held against what they were.
#pragma once

#include <string>

#include "io/hostile.h"  // TemporaryFolder
#include "sinew/scene/scene.h"

namespace sinew::test {

// Saves to folder/name and loads that; fails the test if either fails.
Scene save_and_load(const Scene& scene, const TemporaryFolder& folder,
                    const std::string& name = "saved.glb");

// Same triangles of the same materials in the same places at several times of every clip. Objects
// may come in another order, triangles of a part and corners of a triangle may not. `tolerance` is
// in parts of the scene's size.
void expect_same_motion(const Scene& before, const Scene& after, double tolerance);

}  // namespace sinew::test
