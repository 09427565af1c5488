// Reads .svo files.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include "sinew/base/mapped_file.h"
#include "sinew/io/gltf/embed.h"
#include "sinew/io/svo/container.h"
#include "sinew/io/svo/svo.h"
#include "sinew/svo/file/file.h"
#include "sinew/svo/file/stream.h"

namespace sinew {
namespace {

tl::unexpected<Error> in_file(Error error, const std::string& path, std::string element = "") {
  error.file = path;
  if (error.element.empty()) error.element = std::move(element);
  return fail(std::move(error));
}

Result<Scene> read_around(std::span<const uint8_t> section, const std::string& path,
                          std::vector<Svo> octrees, uint64_t left, const LoadOptions& options) {
  const Result<std::vector<uint8_t>> glb = svo_file::unpack_scene(section, left / 2);
  if (!glb) return in_file(glb.error(), path);
  LoadOptions scene_options = options;
  scene_options.memory_limit = left;
  return gltf::decode_glb(std::string(glb->begin(), glb->end()), path, std::move(octrees),
                          scene_options);
}

// The first bytes of a file up to the end of its table.
Result<svo_file::SectionTable> read_table_of(const RandomFile& file) {
  std::vector<uint8_t> bytes(std::min<uint64_t>(file.size(), svo_file::kContainerHeader));
  SINEW_CHECKED(file.read(0, bytes));
  SINEW_TRY(const uint64_t end, svo_file::table_end(bytes, file.size()));
  bytes.resize(end);
  SINEW_CHECKED(file.read(0, bytes));
  return svo_file::read_table(bytes, file.size());
}

Result<std::vector<SvoInFile>> find_octrees(const std::shared_ptr<const RandomFile>& file,
                                            const svo_file::SectionTable& table, uint64_t limit) {
  std::vector<SvoInFile> found;
  for (size_t i = 0; i < table.octrees.size(); ++i) {
    Result<SvoInFile> one = find_svo(file, table.octrees[i].offset, table.octrees[i].size, limit);
    if (!one) return in_file(one.error(), file->path(), fmt::format("octree {}", i));
    found.push_back(std::move(*one));
  }
  return found;
}

// Each gets what it needs, and of the rest a share by what its details take.
Result<std::vector<Svo>> open_octrees(std::vector<SvoInFile> found, const std::string& path,
                                      const LoadOptions& options) {
  uint64_t least = 0;
  double details = 0.0;
  for (const SvoInFile& one : found) {
    least += one.least;
    details += static_cast<double>(one.index.detail_bytes);
  }
  if (options.voxel_memory < least) {
    return fail({ErrorKind::bad_input, path, "",
                 fmt::format("its voxels need at least {} bytes of memory, but only {} are given",
                             least, options.voxel_memory),
                 fmt::format("give --voxel-memory {} or more", least)});
  }
  std::vector<Svo> octrees;
  for (SvoInFile& one : found) {
    const double share = static_cast<double>(one.index.detail_bytes) / std::max(details, 1.0);
    const PagingOptions paging{
        one.least +
            static_cast<uint64_t>(share * static_cast<double>(options.voxel_memory - least)),
        options.settle};
    Result<Svo> svo = PagedSvo::open(std::move(one), paging);
    if (!svo) return in_file(svo.error(), path, fmt::format("octree {}", octrees.size()));
    octrees.push_back(std::move(*svo));
  }
  return octrees;
}

Result<Scene> load_paged(const std::string& path, const LoadOptions& options) {
  SINEW_TRY(RandomFile opened, RandomFile::open(path));
  const auto file = std::make_shared<const RandomFile>(std::move(opened));
  const Result<svo_file::SectionTable> table = read_table_of(*file);
  if (!table) return in_file(table.error(), path);
  const uint64_t limit = options.memory_limit;
  if (table->scene.size > limit) {
    return in_file({ErrorKind::bad_input, "", "", "its scene is larger than the memory limit",
                    "raise the memory limit or use a smaller file"},
                   path);
  }
  std::vector<uint8_t> scene(table->scene.size);
  SINEW_CHECKED(file->read(table->scene.offset, scene));
  SINEW_TRY(std::vector<SvoInFile> found, find_octrees(file, *table, limit));
  SINEW_TRY(std::vector<Svo> octrees, open_octrees(std::move(found), path, options));
  return read_around(scene, path, std::move(octrees), limit, options);
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
  return read_around(sections->scene, path, std::move(octrees), left, options);
}

Result<Scene> load_svo(const std::string& path, const LoadOptions& options) {
  if (options.voxel_memory > 0) return load_paged(path, options);
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
