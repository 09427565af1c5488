// Reads .svo files.
#include <fmt/format.h>

#include <array>
#include <utility>

#include "sinew/base/mapped_file.h"
#include "sinew/io/gltf/embed.h"
#include "sinew/io/svo/container.h"
#include "sinew/io/svo/svo.h"
#include "sinew/svo/file.h"

namespace sinew {
namespace {

tl::unexpected<Error> in_file(Error error, const std::string& path, std::string element = "") {
  error.file = path;
  if (error.element.empty()) error.element = std::move(element);
  return fail(std::move(error));
}

}  // namespace

Result<Scene> parse_svo(std::span<const uint8_t> bytes, const std::string& path,
                        const LoadOptions& options) {
  const Result<svo_file::Sections> sections = svo_file::find_sections(bytes);
  if (!sections) return in_file(sections.error(), path);
  uint64_t left = options.memory_limit;
  std::vector<Svo> octrees;
  for (size_t i = 0; i < sections->octrees.size(); ++i) {
    Result<Svo> octree = decode_svo(sections->octrees[i], left);
    if (!octree) return in_file(octree.error(), path, fmt::format("octree {}", i));
    left -= std::min<uint64_t>(left, octree->bytes());
    octrees.push_back(std::move(*octree));
  }
  const Result<std::vector<uint8_t>> glb = svo_file::unpack_scene(sections->scene, left / 2);
  if (!glb) return in_file(glb.error(), path);
  LoadOptions scene_options = options;
  scene_options.memory_limit = left;
  return gltf::decode_glb(std::string(glb->begin(), glb->end()), path, std::move(octrees),
                          scene_options);
}

Result<Scene> load_svo(const std::string& path, const LoadOptions& options) {
  SINEW_TRY(const MappedFile file, MappedFile::open(path, options.memory_limit));
  return parse_svo(file.bytes(), path, options);
}

Result<std::vector<SvoPart>> svo_parts(const std::string& path) {
  constexpr uint64_t kLimit = LoadOptions{}.memory_limit;
  SINEW_TRY(const MappedFile file, MappedFile::open(path, kLimit));
  const Result<svo_file::Sections> sections = svo_file::find_sections(file.bytes());
  if (!sections) return in_file(sections.error(), path);
  SvoFileParts sum;
  uint64_t octrees = 0;
  for (const std::span<const uint8_t> octree : sections->octrees) {
    const Result<SvoFileParts> parts = parts_of_svo(octree, kLimit);
    if (!parts) return in_file(parts.error(), path);
    sum.add(*parts);
    octrees += octree.size();
  }
  return list_parts(sum, file.bytes().size() - octrees);
}

std::vector<SvoPart> list_parts(const SvoFileParts& parts, uint64_t scene) {
  return {{"scene", scene},           {"tables", parts.tables}, {"topology", parts.topology},
          {"normals", parts.normals}, {"colors", parts.colors}, {"levels", parts.levels},
          {"lattice", parts.lattice}};
}

}  // namespace sinew
