#include "sinew/io/gltf/uri.h"

#include "hostile.h"

namespace sinew::gltf {
namespace {

TEST(GltfUri, PercentEscapes) {
  EXPECT_EQ(percent_decode("a%20b%2fc"), "a b/c");
  EXPECT_EQ(percent_decode("100%"), "100%");
  EXPECT_EQ(percent_decode("%4"), "%4");
  EXPECT_EQ(percent_decode("%zz%41"), "%zzA");
}

TEST(GltfUri, DataUris) {
  EXPECT_EQ(*decode_data_uri("data:;base64,QUJD"), "ABC");  // RFC 4648's kind of vectors
  EXPECT_EQ(*decode_data_uri("data:;base64,QUI="), "AB");
  EXPECT_EQ(*decode_data_uri("data:x/y;base64,QQ=="), "A");
  EXPECT_EQ(*decode_data_uri("data:;base64,QQ"), "A");
  EXPECT_EQ(*decode_data_uri("data:;base64,"), "");
  EXPECT_EQ(*decode_data_uri("data:text/plain,a%20b"), "a b");
  EXPECT_FALSE(decode_data_uri("data:;base64"));
  EXPECT_FALSE(decode_data_uri("data:;base64,Q!JD"));
  EXPECT_FALSE(decode_data_uri("data:;base64,QUJDQ"));
}

TEST(GltfUri, FilesStayInTheFolder) {
  const TemporaryFolder outer;
  outer.write("secret.bin", "x");
  outer.write("in/side/a b.bin", "x");
  const std::filesystem::path folder = std::filesystem::canonical(outer.path("in"));
  EXPECT_EQ(*file_of_uri(folder, "side/a%20b.bin"), folder / "side" / "a b.bin");
  EXPECT_EQ(*file_of_uri(folder, "side/../x.bin"), folder / "x.bin");
  EXPECT_EQ(*file_of_uri(folder, "./x:y.bin"), folder / "x:y.bin");
  for (const char* uri :
       {"../secret.bin", "side/../../secret.bin", "%2e%2e/secret.bin", "..", ".", "", "/etc/passwd",
        "file:///etc/passwd", "http://a.b/c.bin", "C:/x.bin", "%00", "../in2/x.bin"}) {
    EXPECT_FALSE(file_of_uri(folder, uri)) << uri;
  }
}

TEST(GltfUri, LinksCannotLeaveTheFolder) {
  const TemporaryFolder outer;
  outer.write("secret.bin", "x");
  outer.write("in/a.bin", "x");
  const std::filesystem::path folder = std::filesystem::canonical(outer.path("in"));
  std::filesystem::create_symlink("../secret.bin", folder / "out.bin");
  std::filesystem::create_symlink("a.bin", folder / "stays.bin");
  EXPECT_FALSE(file_of_uri(folder, "out.bin"));
  EXPECT_EQ(*file_of_uri(folder, "stays.bin"), folder / "a.bin");
}

}  // namespace
}  // namespace sinew::gltf
