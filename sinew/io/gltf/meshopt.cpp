// Based on: Arseny Kapoulkine, "EXT_meshopt_compression", glTF extension, 2020, of which the
// meshoptimizer library is the reference decoder. It is safe on any bytes, but trusts the sizes it
// is given: those are checked here.
#include "sinew/io/gltf/meshopt.h"

#include <fmt/format.h>
#include <meshoptimizer.h>

namespace sinew::gltf {
namespace {

constexpr uint64_t kLargest = 0xffffffff;
// A vertex stream spends at least 2 bits on each byte of 16 vertices, an index stream at least a
// byte on a triangle or a single index. So a small file cannot ask for much memory.
constexpr uint64_t kMostVertexBytes = 64;  // a byte of the file

struct Stream {
  std::string mode, filter;
  uint64_t count = 0;
  uint64_t stride = 0;
};

Result<void> check(const Json& json, const Stream& stream, uint64_t bytes) {
  const uint64_t stride = stream.stride;
  bool sound = false;
  uint64_t least = 0;  // bytes that the stream must have
  if (stream.mode == "ATTRIBUTES") {
    sound = stride >= 4 && stride <= 256 && stride % 4 == 0;
    least = stream.count * stride / kMostVertexBytes;
  } else if (stream.mode == "TRIANGLES") {
    sound = (stride == 2 || stride == 4) && stream.count % 3 == 0;
    least = stream.count / 3;
  } else if (stream.mode == "INDICES") {
    sound = stride == 2 || stride == 4;
    least = stream.count;
  } else {
    return json.error(fmt::format("its compression mode \"{}\" is not known", stream.mode));
  }
  if (!sound || stream.count == 0) {
    return json.error(fmt::format("{} elements of {} bytes cannot be compressed as {}",
                                  stream.count, stride, stream.mode));
  }
  if (least > bytes) {
    return json.error(
        fmt::format("its {} compressed bytes cannot hold {} elements", bytes, stream.count),
        "check that the file is complete, or export it again");
  }
  return {};
}

Result<void> check_filter(const Json& json, const Stream& stream) {
  const uint64_t stride = stream.stride;
  const bool known = stream.filter == "NONE" || stream.filter == "OCTAHEDRAL" ||
                     stream.filter == "QUATERNION" || stream.filter == "EXPONENTIAL";
  if (!known) {
    return json.error(fmt::format("its compression filter \"{}\" is not known", stream.filter));
  }
  const bool fits = stream.filter == "NONE" || stream.filter == "EXPONENTIAL" ||
                    (stream.filter == "OCTAHEDRAL" && (stride == 4 || stride == 8)) ||
                    (stream.filter == "QUATERNION" && stride == 8);
  if (!fits || (stream.filter != "NONE" && stream.mode != "ATTRIBUTES")) {
    return json.error(fmt::format("its compression filter {} does not fit {} of {} bytes",
                                  stream.filter, stream.mode, stride));
  }
  return {};
}

bool decode(const Stream& stream, std::span<const uint8_t> in, void* out) {
  const size_t count = stream.count, stride = stream.stride;
  int problem = 0;
  if (stream.mode == "ATTRIBUTES") {
    problem = meshopt_decodeVertexBuffer(out, count, stride, in.data(), in.size());
  } else if (stream.mode == "TRIANGLES") {
    problem = meshopt_decodeIndexBuffer(out, count, stride, in.data(), in.size());
  } else {
    problem = meshopt_decodeIndexSequence(out, count, stride, in.data(), in.size());
  }
  return problem == 0;
}

void apply_filter(const Stream& stream, void* data) {
  if (stream.filter == "OCTAHEDRAL") {
    meshopt_decodeFilterOct(data, stream.count, stream.stride);
  } else if (stream.filter == "QUATERNION") {
    meshopt_decodeFilterQuat(data, stream.count, stream.stride);
  } else if (stream.filter == "EXPONENTIAL") {
    meshopt_decodeFilterExp(data, stream.count, stream.stride);
  }
}

}  // namespace

bool meshopt_available() {
  return true;
}

Result<DecodedView> decode_meshopt(const Json& extension, std::span<const uint8_t> bytes,
                                   MemoryBudget& budget) {
  Stream stream;
  SINEW_TRY(stream.mode, extension.text("mode"));
  SINEW_TRY(stream.filter, extension.text("filter", "NONE"));
  SINEW_TRY(stream.count, extension.unsigned_number("count", 0, kLargest));
  SINEW_TRY(stream.stride, extension.unsigned_number("byteStride", 0, 256));
  SINEW_CHECKED(check(extension, stream, bytes.size()));
  SINEW_CHECKED(check_filter(extension, stream));
  SINEW_CHECKED(budget.take(extension, stream.count, stream.stride));
  DecodedView view;
  view.stride = static_cast<uint32_t>(stream.stride);
  view.bytes.resize(stream.count * stream.stride);
  if (!decode(stream, bytes, view.bytes.data())) {
    return extension.error("its compressed data are damaged, or of a newer version",
                           "check that the file is complete, or export it without compression");
  }
  apply_filter(stream, view.bytes.data());
  return view;
}

}  // namespace sinew::gltf
