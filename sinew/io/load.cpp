// Which reader an input is for, by its form and extension.
#include "sinew/io/load.h"

#include <algorithm>
#include <filesystem>
#include <new>
#include <optional>
#include <string_view>
#include <utility>

#include "sinew/io/aff/aff.h"
#include "sinew/io/gltf/gltf.h"
#include "sinew/io/polygon/scene.h"
#include "sinew/io/polygon/sequence.h"
#include "sinew/io/svo/svo.h"
#include "sinew/io/text.h"
#include "sinew/io/vertex_cache.h"
#include "sinew/io/vox/vox.h"
#include "sinew/scene/study.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kStudyPrefix = "study:";
constexpr std::string_view kAffPrefix = "aff:";

bool exists(const std::string& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

struct CacheInput {
  std::string base;
  std::string cache;
};

// The cache as named, or, if there is none, the file of that name beside its base.
std::string find_cache(const CacheInput& split) {
  const std::string beside = (fs::path(split.base).parent_path() / split.cache).string();
  return !exists(split.cache) && exists(beside) ? beside : split.cache;
}

bool is_polygons(const std::string& path) {
  const std::string extension = extension_of(path);
  return extension == ".obj" || extension == ".ply";
}

// "base.obj+positions.pc2"; names may hold a + themselves, so the split whose base exists is meant.
std::optional<CacheInput> split_cache(const std::string& input) {
  std::optional<CacheInput> result;
  for (size_t at = input.find('+'); at != std::string::npos; at = input.find('+', at + 1)) {
    CacheInput split{input.substr(0, at), input.substr(at + 1)};
    if (!is_polygons(split.base) || !is_vertex_cache(split.cache)) continue;
    if (exists(split.base)) return split;
    result = std::move(split);
  }
  return result;
}

Result<Scene> read(const std::string& input, const LoadOptions& options) {
  if (input.starts_with(kStudyPrefix)) {
    return make_study_scene(std::string_view(input).substr(kStudyPrefix.size()));
  }
  const bool literal = exists(input);
  if (!literal && input.starts_with(kAffPrefix)) {
    SINEW_TRY(const AffInput aff, parse_aff_input(input.substr(kAffPrefix.size())));
    return load_aff(aff.path, aff.options, options);
  }
  if (!literal) {
    if (const auto split = split_cache(input)) {
      return load_vertex_cache(split->base, find_cache(*split), options);
    }
  }
  const std::string extension = extension_of(input);
  if (extension == ".gltf" || extension == ".glb") return load_gltf(input, options);
  if (is_polygons(input)) {
    return !literal && is_sequence(input) ? load_sequence(input, options)
                                          : load_polygons(input, options);
  }
  if (extension == ".svo") return load_svo(input, options);
  if (extension == ".vox") return load_vox(input, options);
  if (extension == ".aff") return load_aff(input, {}, options);
  if (is_vertex_cache(input)) {
    return fail({ErrorKind::bad_input, input, "", "a vertex cache needs its base mesh",
                 "give base.obj+" + fs::path(input).filename().string()});
  }
  return fail(
      {ErrorKind::bad_input, input, "",
       extension.empty() ? "has no extension that says what it is"
                         : "files \"" + extension + "\" are not supported",
       "give .gltf, .glb, .obj, .ply, .aff, .svo, .vox, frames_####.obj, base.obj+cache.pc2 or "
       "study:NAME"});
}

std::string name_of(const std::string& input) {
  if (input.starts_with(kStudyPrefix)) return input;
  const auto split = exists(input) ? std::nullopt : split_cache(input);
  return fs::path(split ? split->cache : input).stem().string();
}

}  // namespace

Result<Scene> load(const std::string& input, const LoadOptions& options) {
  try {
    SINEW_TRY(Scene scene, read(input, options));
    if (scene.name.empty()) scene.name = name_of(input);
    if (std::string problem = validate(scene); !problem.empty()) {
      return fail({ErrorKind::bad_input, input, "", std::move(problem), "export the file again"});
    }
    return scene;
  } catch (const std::bad_alloc&) {
    return fail({ErrorKind::bad_input, input, "", "does not fit into this machine's memory",
                 "lower the memory limit or use a smaller file"});
  } catch (const std::exception& error) {
    return fail(
        {ErrorKind::runtime, input, "", std::string("cannot be read: ") + error.what(), ""});
  }
}

}  // namespace sinew
