// Vertex caches: positions of every vertex at some times, over a base mesh that has the rest.
//
// PC2 (PointCache2, as 3ds Max and Blender write it), little endian:
//
//   offset  0  char[12]  "POINTCACHE2\0"
//          12  int32     version, 1
//          16  int32     points
//          20  float32   start frame
//          24  float32   sample rate: frames from one sample to the next
//          28  int32     samples
//          32  float32   samples * points * 3: x, y, z; sample-major
//
// MDD (Motion Designer, as LightWave and Blender write it), big endian:
//
//   offset  0  int32     samples
//           4  int32     points
//           8  float32   samples: times in seconds
//           .  float32   samples * points * 3: x, y, z; sample-major
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/base/error.h"
#include "sinew/io/load.h"
#include "sinew/io/output_file.h"
#include "sinew/scene/scene.h"

namespace sinew {

// Neither PC2 nor a sequence of files says how long a frame is.
inline constexpr double kCacheFps = 24.0;

struct VertexCache {
  uint32_t points = 0;
  std::vector<float> times;     // seconds, increasing; one a sample
  std::vector<vec3> positions;  // sample-major, finite
};

// `path` stands in errors. Bytes after the last sample are ignored with a warning. Sample i of a
// PC2 file is at i * sample rate / 24 s, whatever its start frame is: a picture sequence begins
// with the first sample. Times of an MDD file that do not rise are replaced by i / 24 s, with a
// warning.
Result<VertexCache> parse_pc2(std::string_view bytes, const std::string& path,
                              std::vector<std::string>& warnings);
Result<VertexCache> parse_mdd(std::string_view bytes, const std::string& path,
                              std::vector<std::string>& warnings);

// The 32 bytes before the samples, which begin at frame 0 and are a frame apart. Errors (usage):
// more points or samples than 31 bits count.
Result<void> write_pc2_header(uint32_t points, uint32_t samples, OutputFile& out);

// Whether the name ends as one of a vertex cache does: ".pc2", ".mdd".
bool is_vertex_cache(const std::string& path);

// The OBJ or PLY file `base`, moved by the PC2 or MDD file `cache`, with a clip "cache".
Result<Scene> load_vertex_cache(const std::string& base, const std::string& cache,
                                const LoadOptions& options);

// Makes the scene's one mesh a vertex cache and adds its clip: key i of the cache is at times[i]
// (seconds, increasing). Normals of the file fit one pose only, so they go.
void set_keys(Scene& scene, std::vector<vec3> key_positions, std::vector<float> times,
              const std::string& clip_name);

}  // namespace sinew
