// Pictures of trees, after T's figure 2: the triangles of a frame coloured by the subtree that they
// are in, and the subtrees' boxes over them.
#pragma once

#include <span>
#include <string>

#include "bench/tsah_methods.h"
#include "bench/tsah_scenes.h"
#include "sinew/base/error.h"

namespace sinew::bench {

// SAH0 and T-SAH in an early and a late frame, as HTML with SVG and PNG in it. The cut is that of
// the nodes with less than a fiftieth of the triangles, as in T.
Result<std::string> tree_pictures(const TsahScene& scene, FlatClip& clip,
                                  std::span<const MethodTrees> methods);

}  // namespace sinew::bench
