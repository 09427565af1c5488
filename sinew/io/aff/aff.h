// AFF, the animated file format of the BART benchmark: NFF with includes, meshes, transforms by
// keyframes and animated triangles.
// Based on: J. Lext, U. Assarsson, T. Moller, "BART: A Benchmark for Animated Ray Tracing",
// Chalmers TR 00-14, 2000, and their "AFF - Animated File Format", draft 1; E. Haines, "Neutral
// File Format" 3.9 (NFF). Differs in that included files of every detail level are taken until a
// statement `d` names one.
#pragma once

#include <string>
#include <string_view>

#include "sinew/base/error.h"
#include "sinew/io/load.h"
#include "sinew/scene/scene.h"

namespace sinew {

inline constexpr int kLeastComplexity = 5, kMostComplexity = 8;

struct AffOptions {
  int complexity = 0;  // 5 to 8: split the animated triangles into 4^complexity; 0: as they are
};

struct AffInput {
  AffOptions options;
  std::string path;
};

// "[key=value,...]PATH", which is what follows `aff:`; unknown keys and values are usage errors.
Result<AffInput> parse_aff_input(std::string_view spec);

// Animated transforms (`x`) become nodes; below one, what is rigid and comes from one included file
// is one object. Static transforms, spheres and cones are turned into triangles. Ambient light,
// which AFF weighs by a colour of its own, becomes emission.
Result<Scene> load_aff(const std::string& path, const AffOptions& aff, const LoadOptions& options);

}  // namespace sinew
