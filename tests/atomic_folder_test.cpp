#include "atlas/atomic_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "atlas/atomic_file.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

void put_one(const std::string& folder, const std::string& text = "new") {
  make_folder(folder + "/below");
  write_file_plainly(folder + "/below/file", text);
}

std::size_t entries_of(const std::string& folder) {
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST(AtomicFolder, FolderAppearsWithAllItHoldsAndNothingBesideIt) {
  const TemporaryFolder root;
  for (const std::string name : {"a/b/out", "slash/", "plain"}) {
    build_folder_atomically(root / name, [&](const std::string& temporary) {
      EXPECT_TRUE(fs::is_empty(temporary));
      EXPECT_FALSE(fs::exists(root / name));
      put_one(temporary);
    });
    EXPECT_EQ(read_file(root / name + "/below/file"), "new") << name;
  }
  EXPECT_EQ(entries_of(root.path()), 3u);
  EXPECT_EQ(entries_of(root / "a/b"), 1u);
}

TEST(AtomicFolder, WhatIsThereIsRefusedAndKept) {
  const TemporaryFolder root;
  make_folder(root / "folder");
  write_file_plainly(root / "file", "old");
  fs::create_symlink("nowhere", root / "link");
  for (const std::string name : {"folder", "folder/", "file", "link"}) {
    EXPECT_THAT(message_of([&] { build_folder_atomically(root / name, [](auto&) { FAIL(); }); }),
                HasSubstr(": is there already; expected a folder that is not there yet"))
        << name;
  }
  EXPECT_THAT(
      message_of([&] { build_folder_atomically(root / "file/below", [](auto&) { FAIL(); }); }),
      HasSubstr("file: cannot create: Not a directory"));
  EXPECT_EQ(read_file(root / "file"), "old");
  EXPECT_EQ(entries_of(root.path()), 3u);
}

TEST(AtomicFolder, FailureLeavesNothing) {
  const TemporaryFolder root;
  EXPECT_EQ(message_of([&] {
              build_folder_atomically(root / "out", [](const std::string& temporary) {
                put_one(temporary);
                throw std::runtime_error("half-way");
              });
            }),
            "half-way");
  EXPECT_TRUE(fs::is_empty(root.path()));
}

TEST(AtomicFolder, FolderThatAppearsMeanwhileIsKept) {
  const TemporaryFolder root;
  EXPECT_THAT(message_of([&] {
                build_folder_atomically(root / "out", [&](const std::string& temporary) {
                  put_one(temporary);
                  put_one(root / "out", "theirs");
                });
              }),
              HasSubstr("out: is there already"));
  EXPECT_EQ(read_file(root / "out/below/file"), "theirs");
  EXPECT_EQ(entries_of(root.path()), 1u);
}

TEST(AtomicFolder, RunAfterAKilledOneStartsAfresh) {
  const TemporaryFolder root;
  const pid_t child = fork();
  if (child == 0) {
    build_folder_atomically(root / "out", [](const std::string& temporary) {
      write_file_plainly(temporary + "/stale", "half");
      raise(SIGKILL);
    });
    _exit(1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_FALSE(fs::exists(root / "out"));
  ASSERT_TRUE(fs::exists(root / "out.pluvia-tmp/stale"));
  build_folder_atomically(root / "out", [](const std::string& temporary) { put_one(temporary); });
  EXPECT_EQ(entries_of(root / "out"), 1u);
  EXPECT_EQ(entries_of(root.path()), 1u);
}

TEST(AtomicFolder, SecondRunAtTheSameTimeIsRefused) {
  const TemporaryFolder root;
  build_folder_atomically(root / "out", [&](const std::string& temporary) {
    put_one(temporary);
    EXPECT_THAT(message_of([&] { build_folder_atomically(root / "out", [](auto&) { FAIL(); }); }),
                HasSubstr("out.pluvia-tmp: another run is writing it"));
  });
  EXPECT_EQ(read_file(root / "out/below/file"), "new");
}

TEST(AtomicFolder, PlainFileThatCannotBeWrittenIsRefused) {
  const TemporaryFolder root;
  EXPECT_THAT(message_of([&] { write_file_plainly(root / "none/file", "x"); }),
              HasSubstr("none/file: cannot write: No such file or directory; expected"));
  EXPECT_THAT(message_of([] { write_file_plainly("/dev/full", "x"); }),
              HasSubstr("/dev/full: cannot write: No space left on device"));
}

}  // namespace
}  // namespace pluvia
