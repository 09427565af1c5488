// Bytes come back from packing; mapped files are the files' bytes.
#include "sinew/base/packing.h"

#include <gtest/gtest.h>

#include "io/hostile.h"
#include "sinew/base/mapped_file.h"

namespace sinew {
namespace {

std::vector<uint8_t> some_bytes(size_t count, uint32_t seed) {
  Random random(seed);
  std::vector<uint8_t> bytes(count);
  for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random.next() % 9);
  return bytes;
}

TEST(Packing, BytesComeBack) {
  for (const size_t count : {0, 1, 100, 300000}) {
    const std::vector<uint8_t> bytes = some_bytes(count, 3);
    for (const std::vector<size_t>& ends : {std::vector<size_t>{}, {count / 3, count / 2, count}}) {
      const Packed packed = pack(bytes, ends, 3);
      ASSERT_EQ(packed.ends.size(), ends.size());
      EXPECT_EQ(ends.empty() ? packed.bytes.size() : packed.ends.back(), packed.bytes.size());
      EXPECT_LE(bytes.size(), most_unpacked(packed.bytes.size()));
      std::vector<uint8_t> again(count);
      ASSERT_TRUE(unpack(packed.bytes, again));
      EXPECT_EQ(again, bytes);
    }
  }
}

TEST(Packing, OtherSizesAndDamagedBytesAreRefused) {
  const std::vector<uint8_t> bytes = some_bytes(5000, 4);
  std::vector<uint8_t> packed = pack(bytes, {}, 3).bytes;
  std::vector<uint8_t> less(4999), more(5001), same(5000);
  EXPECT_FALSE(unpack(packed, less));
  EXPECT_FALSE(unpack(packed, more));
  EXPECT_FALSE(unpack(std::span(packed).first(packed.size() - 1), same));
  packed.push_back(0);
  EXPECT_FALSE(unpack(packed, same));
  EXPECT_FALSE(unpack({}, same));
}

// The most repetitive bytes there are.
TEST(Packing, TheMostIsNotExceeded) {
  const std::vector<uint8_t> bytes(size_t{64} << 20, 7);
  const Packed packed = pack(bytes, {}, 19);
  EXPECT_LE(bytes.size(), most_unpacked(packed.bytes.size()));
}

TEST(MappedFile, HasTheBytesOfTheFile) {
  const TemporaryFolder folder;
  const std::string path = folder.write("a", "some bytes");
  const Result<MappedFile> file = MappedFile::open(path, 100);
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_EQ(std::string(file->bytes().begin(), file->bytes().end()), "some bytes");
  EXPECT_TRUE(MappedFile::open(folder.write("empty", ""), 100)->bytes().empty());
}

TEST(MappedFile, WhatIsNoFileIsRefused) {
  const TemporaryFolder folder;
  const auto refuse = [](const std::string& path, const char* part) {
    const Result<MappedFile> file = MappedFile::open(path, 100);
    ASSERT_FALSE(file);
    EXPECT_EQ(file.error().kind, ErrorKind::bad_input);
    EXPECT_NE(file.error().problem.find(part), std::string::npos) << file.error().problem;
  };
  refuse(folder.path("none"), "does not exist");
  refuse(folder.path("."), "regular file");
  refuse(folder.write("large", std::string(101, 'a')), "at most 100");
}

}  // namespace
}  // namespace sinew
