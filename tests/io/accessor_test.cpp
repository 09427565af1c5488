#include "sinew/io/gltf/accessor.h"

#include <limits>
#include <memory>

#include "gltf_builder.h"

namespace sinew::gltf {
namespace {

// Reads the last accessor of a builder, as floats or indices.
class AccessorTest : public testing::Test {
 protected:
  template <class T>
  Result<std::vector<T>> read_last(Numbers numbers, uint32_t components = kAnyComponents) {
    builder_.json["test"]["it"] = builder_.json["accessors"].size() - 1;
    MemoryBudget budget(uint64_t{1} << 30);
    SINEW_TRY(const Asset asset, open_asset("a.glb", builder_.glb(), budget));
    SINEW_TRY(const AccessorReader reader, AccessorReader::create(asset, budget, warnings_));
    SINEW_TRY(const Json owner, asset.root().object("test"));
    SINEW_TRY(const Accessor accessor, reader.find(owner, "it", components, numbers));
    std::vector<T> values(size_t{accessor.count} * accessor.components);
    SINEW_CHECKED(read(accessor, std::span<T>(values)));
    return values;
  }
  std::string error(Numbers numbers = Numbers::any_real) {
    const auto values = read_last<float>(numbers);
    return values ? "(no error)" : values.error().message();
  }
  nlohmann::json& last() { return builder_.json["accessors"].back(); }

  TemporaryFolder folder_;
  GltfBuilder builder_;
  Warnings warnings_;
};

TEST_F(AccessorTest, NormalizedIntegersFollowTheSpecification) {
  builder_.accessor<uint8_t>({0, 51, 255}, "SCALAR", true);
  EXPECT_EQ(*read_last<float>(Numbers::real_or_normalized), (std::vector<float>{0.0f, 0.2f, 1.0f}));
  builder_.accessor<int8_t>({-128, -127, 127}, "SCALAR", true);
  EXPECT_EQ(*read_last<float>(Numbers::real_or_normalized), (std::vector<float>{-1, -1, 1}));
  builder_.accessor<uint16_t>({0, 13107, 65535}, "SCALAR", true);
  EXPECT_EQ(*read_last<float>(Numbers::real_or_normalized), (std::vector<float>{0.0f, 0.2f, 1.0f}));
  builder_.accessor<int16_t>({-32768, 0, 32767}, "SCALAR", true);
  EXPECT_EQ(*read_last<float>(Numbers::real_or_normalized), (std::vector<float>{-1, 0, 1}));
  builder_.accessor<int16_t>({-300, 300}, "SCALAR");
  EXPECT_EQ(*read_last<float>(Numbers::any_real), (std::vector<float>{-300, 300}));
  expect_contains(error(Numbers::real_or_normalized), "accessor 4: has the wrong type");
}

TEST_F(AccessorTest, IndicesOfEveryWidth) {
  builder_.accessor<uint8_t>({1, 255}, "SCALAR");
  EXPECT_EQ(*read_last<uint32_t>(Numbers::index), (std::vector<uint32_t>{1, 255}));
  builder_.accessor<uint16_t>({1, 65535}, "SCALAR");
  EXPECT_EQ(*read_last<uint32_t>(Numbers::index), (std::vector<uint32_t>{1, 65535}));
  builder_.accessor<uint32_t>({1, 4294967295u}, "SCALAR");
  EXPECT_EQ(*read_last<uint32_t>(Numbers::index), (std::vector<uint32_t>{1, 4294967295u}));
  builder_.accessor<int16_t>({1, 2}, "SCALAR");
  expect_contains(error(Numbers::index), "wrong type");
}

TEST_F(AccessorTest, StrideAndOffset) {
  builder_.accessor<float>({1, 2, 3, 4, 5, 6, 7, 8, 9, 10}, "SCALAR");
  builder_.json["bufferViews"][0]["byteStride"] = 16;
  last()["byteOffset"] = 4;
  last()["type"] = "VEC2";
  last()["count"] = 3;  // begins at bytes 4, 20, 36; the last needs bytes 36 to 44 of 40
  expect_contains(error(), "accessor 0: reaches past the end of its buffer view (44 of 40 bytes)");
  last()["count"] = 2;
  EXPECT_EQ(*read_last<float>(Numbers::real), (std::vector<float>{2, 3, 6, 7}));
  builder_.json["bufferViews"][0]["byteStride"] = 4;
  expect_contains(error(), "overlap");
}

TEST_F(AccessorTest, SparseOverDataAndOverZeros) {
  const int indices = builder_.view<uint16_t>({1, 3});
  const int values = builder_.view<float>({20, 40});
  builder_.accessor<float>({1, 2, 3, 4}, "SCALAR");
  last()["sparse"] = {{"count", 2},
                      {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
                      {"values", {{"bufferView", values}}}};
  EXPECT_EQ(*read_last<float>(Numbers::real), (std::vector<float>{1, 20, 3, 40}));
  last().erase("bufferView");
  EXPECT_EQ(*read_last<float>(Numbers::real), (std::vector<float>{0, 20, 0, 40}));
  last()["count"] = 3;
  expect_contains(error(), "sparse index 1 is 3");
  last()["sparse"]["count"] = 3;
  expect_contains(error(), "its sparse data reach past the end");
  last()["sparse"]["indices"]["componentType"] = 5126;
  expect_contains(error(), "sparse indices are not unsigned");
}

TEST_F(AccessorTest, SparseIndicesMustRise) {
  const int indices = builder_.view<uint8_t>({2, 2});
  const int values = builder_.view<float>({20, 40});
  builder_.accessor<float>({1, 2, 3, 4}, "SCALAR");
  last()["sparse"] = {{"count", 2},
                      {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                      {"values", {{"bufferView", values}}}};
  expect_contains(error(), "they must rise");
}

TEST_F(AccessorTest, AbsurdSizesAreErrorsBeforeAnythingIsAllocated) {
  builder_.accessor<float>({1, 2, 3, 4}, "SCALAR");
  last()["count"] = 2147483648u;
  expect_contains(error(), "reaches past the end");
  last()["count"] = 4294967295u;
  last()["type"] = "MAT4";
  expect_contains(error(), "wrong type");
  last()["type"] = "VEC4";
  expect_contains(error(), "reaches past the end");
  last().erase("bufferView");
  expect_contains(error(), "elements without data");
  last()["count"] = 1e15;
  expect_contains(error(), "\"count\" is not a whole number");
  last()["count"] = -1;
  expect_contains(error(), "\"count\" is not a whole number");
  last()["count"] = 0;
  expect_contains(error(), "has no elements");
}

TEST_F(AccessorTest, OffsetsCannotOverflow) {
  builder_.accessor<float>({1, 2, 3, 4}, "SCALAR");
  last()["byteOffset"] = 4294967295u;
  expect_contains(error(), "accessor 0: reaches past the end");
  last()["byteOffset"] = 18446744073709551615u;
  expect_contains(error(), "\"byteOffset\" is not a whole number");
  last()["byteOffset"] = 0;
  builder_.json["bufferViews"][0]["byteOffset"] = 4294967295u;
  expect_contains(error(), "buffer view 0: reaches past the end of buffer 0");
  builder_.json["bufferViews"][0]["byteOffset"] = 0;
  builder_.json["bufferViews"][0]["byteLength"] = 17;
  expect_contains(error(), "buffer view 0: reaches past the end of buffer 0 (0 + 17 of 16 bytes)");
}

TEST_F(AccessorTest, ValuesMustBeFinite) {
  builder_.accessor<float>({0, 0, 0, 1, std::numeric_limits<float>::infinity(), 1}, "VEC3");
  expect_contains(error(), "accessor 0: its element 1 is not finite");
  builder_.accessor<float>({std::numeric_limits<float>::quiet_NaN()}, "SCALAR");
  expect_contains(error(), "accessor 1: its element 0 is not finite");
}

TEST_F(AccessorTest, MisalignedDataAreReadWithAWarning) {
  builder_.view<uint8_t>({1, 2, 3});
  builder_.accessor<float>({1, 2, 3}, "SCALAR");
  last()["byteOffset"] = 2;
  last()["count"] = 2;
  ASSERT_TRUE(read_last<float>(Numbers::real));
  ASSERT_EQ(warnings_.texts().size(), 1u);
  expect_contains(warnings_.texts()[0], "accessor 0: is not aligned");
}

}  // namespace
}  // namespace sinew::gltf
