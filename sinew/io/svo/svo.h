// The .svo file: octrees and the scene around them, so that it plays alone.
//
//   offset  bytes  little endian
//        0      8  "sinewsvo"
//        8      4  version (2; 1 had one page a block)
//       12      4  octrees
//       16      8  size of the file
//       24      8  XXH3-64 of the rest of the header and of the table
//       32         table: the sections' sizes in bytes (8 each): scene, octree 0, octree 1, ...
//        .         section of the scene: size unpacked (8), XXH3-64 of that size xor that of what
//                  follows (8), zstd: a GLB that io/gltf writes and reads, see gltf/embed.h
//        .         sections of octrees, see svo/file/file.h
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/io/load.h"
#include "sinew/io/output_file.h"
#include "sinew/scene/scene.h"
#include "sinew/svo/file/file.h"

namespace sinew {

struct SaveSvoOptions {
  int effort = 9;  // zstd's level, 1 to 19: smaller and slower
};

// Bytes of a part over all octrees of the file.
struct SvoPart {
  std::string name;
  uint64_t bytes = 0;
};

struct SavedSvo {
  std::string path;
  uint64_t bytes = 0;                 // of the file
  uint64_t voxels = 0;                // of level 0, each octree counted once
  std::vector<SvoPart> parts;         // as stored; they sum to `bytes`
  std::vector<std::string> warnings;  // what is left out, or said otherwise
};

// Writes the scene's octrees, and everything that makes them move and be seen: nodes, skins, clips,
// materials, cameras, lights, surroundings, and the triangle objects that are left. Textures of
// materials that no triangle object has are left out (voxels have their colours), as are vertex
// caches and vertex programs (with a warning). The file appears whole or not at all; "-" is
// standard output. The scene must be valid. Errors: usage, output, and bad_input for scenes that
// are not valid or hold no octree.
Result<SavedSvo> save_svo(const Scene& scene, const std::string& path,
                          const SaveSvoOptions& options = {});

// Octrees on their way into a .svo file, kept on disk beside it while they are made in parts.
class SvoStore {
 public:
  SvoStore(std::string path, const SaveSvoOptions& options)
      : path_(std::move(path)), options_(options) {}

  // See SvoEncoder: parts of one octree, and its end. Errors: output, and those of the encoder.
  Result<void> add(const Svo& part);
  Result<void> finish(const Svo& outline);

 private:
  friend class SvoSaver;
  struct Octree {
    SpoolFile skeletons, details;
    std::vector<uint8_t> front;
    SvoFileParts parts;
    uint64_t voxels = 0;
    uint64_t size() const { return front.size() + skeletons.size() + details.size(); }
  };

  std::string path_;
  SaveSvoOptions options_;
  std::vector<Octree> octrees_;
  std::unique_ptr<SvoEncoder> encoder_;  // of the last octree while it is made
};

// The same where the last octrees of the scene are those of the store, without what parts hold (all
// but name, joints, morph targets and weights may be missing). The file is the same as if they were
// whole.
Result<SavedSvo> save_svo(const Scene& scene, const SvoStore& store, const std::string& path,
                          const SaveSvoOptions& options = {});

// Whether save_svo can write `path`: to be asked before long work.
Result<void> check_save_svo(const std::string& path);

// An error if a single bit differs from what save_svo() wrote.
Result<Scene> load_svo(const std::string& path, const LoadOptions& options = {});

// The same from the bytes of the file; `path` stands in errors.
Result<Scene> parse_svo(std::span<const uint8_t> bytes, const std::string& path,
                        const LoadOptions& options);

// `scene` is what all but the octrees take.
std::vector<SvoPart> list_parts(const SvoFileParts& parts, uint64_t scene);

// What the parts of a file take, without reading its octrees.
Result<std::vector<SvoPart>> svo_parts(const std::string& path);

}  // namespace sinew
