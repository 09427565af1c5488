// .svo files. Random bytes seldom have right checksums and are seldom packed rightly, so the first
// byte says what the others are:
//
//   0  an encoded octree before it was packed and summed:
//      flags (1) | head (2, then so many bytes, without pages' sizes and sums) | page (the same)
//      ...
//   1  the scene of a file with two octrees, as its GLB's parts: as in gltf.cpp after its first
//   byte S  ("sinewsvo") a whole file
#include "sinew/io/svo/svo.h"

#include <algorithm>

#include "fuzz.h"
#include "glb_parts.h"
#include "sinew/io/gltf/embed.h"
#include "sinew/svo/file/file.h"
#include "svo/sealed_svo.h"
#include "svo/test_octrees.h"

namespace {

using namespace sinew;

// Takes a size of two bytes and as many bytes as it says, or as there are.
std::vector<uint8_t> take_sized(std::span<const uint8_t>& left) {
  if (left.size() < 2) {
    left = {};
    return {};
  }
  const size_t size = std::min(left[0] + size_t{256} * left[1], left.size() - 2);
  const std::span<const uint8_t> own = left.subspan(2, size);
  left = left.subspan(2 + size);
  return {own.begin(), own.end()};
}

void check_octree(std::span<const uint8_t> input) {
  test::UnsealedSvo parts;
  if (input.empty()) return;
  parts.flags = input[0];
  input = input.subspan(1);
  parts.head = take_sized(input);
  while (!input.empty()) parts.pages.push_back(take_sized(input));
  const Result<Svo> svo = decode_svo(test::seal(parts), fuzz::kLimited.memory_limit);
  fuzz::check_error(svo);
  if (!svo) return;
  fuzz::require(validate(*svo).empty(), "an invalid octree: " + validate(*svo));
  const Result<EncodedSvo> again = encode_svo(*svo, 1);
  fuzz::require(again.has_value(), "an octree that cannot be encoded");
}

void check_scene_around(std::string_view parts) {
  static const std::vector<Svo> octrees = {test::moving_octree(9, 30, 4),
                                           test::plain_octree(7, 20, 1, 3)};
  Result<Scene> scene =
      gltf::decode_glb(fuzz::make_glb(parts), fuzz::kFolder + "a.svo", octrees, fuzz::kLimited);
  fuzz::check_error(scene);
  if (!scene) return;
  // What a file lacks is load()'s to find: materials, and skins of octrees with joints.
  const std::string problem = validate(*scene);
  fuzz::require(problem.empty() || problem.find("material") != std::string::npos ||
                    problem.find("no skin") != std::string::npos,
                "an invalid scene: " + problem);
}

}  // namespace

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  if (data[0] == 0) {
    check_octree({data + 1, size - 1});
  } else if (data[0] == 1) {
    check_scene_around(fuzz::as_text(data + 1, size - 1));
  } else {
    fuzz::check_scene(parse_svo({data, size}, fuzz::kFolder + "a.svo", fuzz::kLimited));
  }
  return 0;
}
