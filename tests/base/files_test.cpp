#include "calot/base/files.h"

#include <gtest/gtest.h>

#include "calot/base/error.h"
#include "tests/support/files.h"

namespace calot {
namespace {
namespace fs = std::filesystem;

TEST(Files, AreWrittenWholeOrNotAtAll) {
  const test::TempFolder folder;
  const fs::path path = folder / "a.txt";
  write_file(path, [](std::ostream& out) { out << "first"; });
  EXPECT_THROW(write_file(path,
                          [](std::ostream& out) {
                            out << "second";
                            throw Interrupted();
                          }),
               Interrupted);
  EXPECT_EQ(read_file(path), "first");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
}

TEST(Files, AFullDiskIsSaidAndLeavesNothing) {
  EXPECT_THROW(write_file("/dev/full/x", [](std::ostream& out) { out << "x"; }), FailedError);
  const test::TempFolder folder;
  fs::create_symlink("/dev/full", partial_path(folder / "b.txt"));
  EXPECT_THROW(write_file(folder / "b.txt", [](std::ostream& out) { out << std::string(1 << 20, 'x'); }), FailedError);
  EXPECT_FALSE(fs::exists(folder / "b.txt"));
}

TEST(Files, MissingFoldersAndFilesAreNamed) {
  EXPECT_NE(test::message_of([] { (void)read_file("/no/such/file"); }).find("/no/such/file"), std::string::npos);
  EXPECT_THROW((void)read_file("/"), InputError);
  const test::TempFolder folder;
  write_file(folder / "c", [](std::ostream& out) { out << "0123456789"; });
  EXPECT_THROW((void)read_file(folder / "c", 5), InputError);
}

// FIPS 180-2's own example.
TEST(Files, Sha256OfAbc) {
  const std::string abc = "abc", expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
  EXPECT_EQ(sha256(abc), expected);
  const test::TempFolder folder;
  write_file(folder / "abc", [](std::ostream& out) { out << "abc"; });
  EXPECT_EQ(sha256_of_file(folder / "abc"), expected);
}

}  // namespace
}  // namespace calot
