#include "sinew/base/packing.h"

#include <zstd.h>

#include <limits>
#include <memory>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "sinew/base/check.h"

namespace sinew {
namespace {

struct FreeContext {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

constexpr size_t kLeastBlock = 48;  // fewer bytes are not worth statistics of their own

}  // namespace

uint64_t checksum(std::span<const uint8_t> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

Packed pack(std::span<const uint8_t> bytes, std::span<const size_t> ends, int effort) {
  const std::unique_ptr<ZSTD_CCtx, FreeContext> context(ZSTD_createCCtx());
  SINEW_CHECK(context != nullptr);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, effort);
  ZSTD_CCtx_setPledgedSrcSize(context.get(), bytes.size());
  // Room for the blocks' headers, each of 3 bytes.
  Packed packed;
  std::vector<uint8_t>& out = packed.bytes;
  out.resize(ZSTD_compressBound(bytes.size()) + 16 * (ends.size() + 1));
  ZSTD_outBuffer target = {out.data(), out.size(), 0};
  ZSTD_inBuffer source = {bytes.data(), 0, 0};
  const auto compress_to = [&](size_t end, ZSTD_EndDirective directive) {
    source.size = end;
    const size_t left = ZSTD_compressStream2(context.get(), &target, &source, directive);
    SINEW_CHECK(left == 0);
  };
  for (const size_t end : ends) {
    if (end - source.size >= kLeastBlock) compress_to(end, ZSTD_e_flush);
    packed.ends.push_back(target.pos);
  }
  compress_to(bytes.size(), ZSTD_e_end);
  out.resize(target.pos);
  if (!ends.empty()) packed.ends.back() = target.pos;
  return packed;
}

uint64_t most_unpacked(uint64_t packed) {
  // A block of 128 KiB takes 4 bytes at least: its header and the byte that it repeats.
  constexpr uint64_t kRatio = (uint64_t{128} << 10) / 4;
  return packed > std::numeric_limits<uint64_t>::max() / kRatio
             ? std::numeric_limits<uint64_t>::max()
             : packed * kRatio;
}

bool unpack(std::span<const uint8_t> packed, std::span<uint8_t> out) {
  if (ZSTD_findFrameCompressedSize(packed.data(), packed.size()) != packed.size()) return false;
  // One a thread: it costs as much as a small page.
  thread_local const std::unique_ptr<ZSTD_DCtx, FreeContext> context(ZSTD_createDCtx());
  SINEW_CHECK(context != nullptr);
  const size_t size =
      ZSTD_decompressDCtx(context.get(), out.data(), out.size(), packed.data(), packed.size());
  return !ZSTD_isError(size) && size == out.size();
}

}  // namespace sinew
