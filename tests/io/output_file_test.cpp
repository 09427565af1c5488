#include "sinew/io/output_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "io/hostile.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

TEST(OutputFile, WritesAndReadsBack) {
  TemporaryFolder folder;
  const std::string path = folder.path("a.txt");
  ASSERT_TRUE(write_file(path, "hello"));
  EXPECT_EQ(*read_file(path, 5), "hello");
  ASSERT_TRUE(write_file(path, ""));
  EXPECT_EQ(*read_file(path, 0), "");
  EXPECT_EQ(folder.file_count(), 1u);
}

TEST(OutputFile, TheUmaskDecidesAboutPermissions) {
  TemporaryFolder folder;
  const mode_t before = ::umask(027);
  const bool written = write_file(folder.path("a"), "x").has_value();
  ::umask(before);
  ASSERT_TRUE(written);
  EXPECT_EQ(fs::status(folder.path("a")).permissions(), static_cast<fs::perms>(0640));
}

TEST(OutputFile, LinksAreFollowedAndDevicesAreKept) {
  TemporaryFolder folder;
  const std::string target = folder.write("sub/target", "old");
  fs::create_symlink("sub/target", folder.path("link"));
  ASSERT_TRUE(write_file(folder.path("link"), "new"));
  EXPECT_TRUE(fs::is_symlink(folder.path("link")));
  EXPECT_EQ(slurp(target), "new");
  ASSERT_TRUE(write_file("/dev/null", "nothing"));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST(OutputFile, FailuresNameTheFileAndLeaveNothing) {
  TemporaryFolder folder;
  const std::string file = folder.write("file", "old");
  fs::create_directory(folder.path("folder"));
  struct Case {
    std::string path;
    const char* problem;
  };
  const Case cases[] = {{folder.path("missing/a.png"), "folder does not exist"},
                        {folder.path("folder"), "is a folder"},
                        {folder.path("new/"), "is a folder"},
                        {file + "/a.png", "is a file, not a folder"},
                        {folder.path(std::string(300, 'a')), "cannot be written"}};
  for (const Case& c : cases) {
    for (const Result<void>& result : {write_file(c.path, "x"), check_writable(c.path)}) {
      ASSERT_FALSE(result) << c.path;
      EXPECT_EQ(result.error().kind, ErrorKind::output);
      EXPECT_EQ(result.error().file, c.path);
      EXPECT_NE(result.error().problem.find(c.problem), std::string::npos)
          << result.error().message();
      EXPECT_FALSE(result.error().remedy.empty());
    }
  }
  EXPECT_FALSE(write_file("", "x"));
  EXPECT_EQ(slurp(file), "old");
  EXPECT_EQ(folder.file_count(), 2u);
}

TEST(OutputFile, AFullDiskIsReported) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  const Result<void> result = write_file("/dev/full", "x");
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().problem, "cannot be written: the disk is full");
}

TEST(OutputFile, CheckWritableLeavesNoTrace) {
  TemporaryFolder folder;
  EXPECT_TRUE(check_writable(folder.path("a")));
  EXPECT_TRUE(check_writable("-"));
  EXPECT_TRUE(check_writable("/dev/null"));
  EXPECT_EQ(folder.file_count(), 0u);
}

TEST(OutputFile, ReadingChecksWhatItReads) {
  TemporaryFolder folder;
  const std::string path = folder.write("a", "12345");
  ASSERT_EQ(::mkfifo(folder.path("pipe").c_str(), 0600), 0);
  for (const Result<std::string>& result :
       {read_file(path, 4), read_file(folder.path("none"), 100), read_file(path + "/b", 100),
        read_file(folder.path(""), 100), read_file(folder.path("pipe"), 100),
        read_file("/dev/zero", 100)}) {
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().kind, ErrorKind::bad_input);
    EXPECT_FALSE(result.error().file.empty());
  }
}

}  // namespace
}  // namespace sinew
