#include "atlas/atomic_file.h"

#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

using testing::HasSubstr;

// Runs `action` in a child process and returns how it ended (waitpid's status).
template <typename Action>
int status_of_child(Action action) {
  const pid_t child = fork();
  if (child == 0) {
    action();
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

TEST(AtomicFile, BytesWrittenAreTheBytesReadBack) {
  const TemporaryFolder folder;
  const std::string bytes("rain\0\n\r\xff", 8);
  for (const std::string& content :
       {std::string(), std::string("a"), bytes, std::string(1 << 20, 'x')}) {
    write_file_atomically(folder / "file", content);
    EXPECT_EQ(read_file(folder / "file"), content) << content.size() << " bytes";
    EXPECT_FALSE(std::filesystem::exists(folder / "file.tmp"));
  }
}

TEST(AtomicFile, ShaOfKnownTextsAreThoseOfTheStandard) {
  // FIPS 180-2, appendix B.1, and the hash of no bytes.
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(AtomicFile, ProcessKilledAtAnyWritePointLeavesTheOldFileOrTheNew) {
  const std::string before(5000, 'o');
  const std::string after(70000, 'n');
  for (long point = 0; point <= 4; ++point) {
    const TemporaryFolder folder;
    write_file_atomically(folder / "file", before);
    const int status = status_of_child([&] {
      set_write_point_hook([&](long number) {
        if (number == point) raise(SIGKILL);
      });
      write_file_atomically(folder / "file", after);
    });
    ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) << "write point " << point;
    // Only the last point lies behind the rename.
    EXPECT_EQ(read_file(folder / "file"), point < 4 ? before : after) << "write point " << point;
    // The temporary file shows that the points are where the header says: none yet, half, all, all,
    // renamed.
    const bool left = std::filesystem::exists(folder / "file.tmp");
    EXPECT_EQ(left, point >= 1 && point <= 3) << "write point " << point;
    if (left) {
      EXPECT_EQ(std::filesystem::file_size(folder / "file.tmp"), point == 1 ? 35000u : 70000u);
    }
    write_file_atomically(folder / "file", after);
    EXPECT_EQ(read_file(folder / "file"), after) << "rerun after write point " << point;
    EXPECT_FALSE(std::filesystem::exists(folder / "file.tmp")) << "write point " << point;
  }
}

TEST(AtomicFile, WritePointsAreCountedOnFromFileToFile) {
  const TemporaryFolder folder;
  std::vector<long> numbers;
  set_write_point_hook([&](long number) { numbers.push_back(number); });
  write_file_atomically(folder / "a", "1");
  write_file_atomically(folder / "b", "2");
  set_write_point_hook({});
  write_file_atomically(folder / "c", "3");
  EXPECT_EQ(numbers, (std::vector<long>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}));
}

// The limit is inherited by the whole process, so it is set in a child. Whether the signal of an
// exceeded limit is ignored or would kill, the outcome must be the same message.
TEST(AtomicFile, FullDiskIsAnErrorThatNamesFileAndReasonAndLeavesNothing) {
  for (const auto handler : {SIG_IGN, SIG_DFL}) {
    const TemporaryFolder folder;
    const int status = status_of_child([&] {
      std::signal(SIGXFSZ, handler);
      const rlimit limit = {.rlim_cur = 4096, .rlim_max = 4096};
      setrlimit(RLIMIT_FSIZE, &limit);
      const std::string message =
          message_of([&] { write_file_atomically(folder / "file", std::string(10000, 'x')); });
      const std::string expected =
          (folder / "file") +
          ": cannot write: File too large; expected a writable folder with "
          "room for 10000 bytes";
      _exit(message == expected ? 0 : 3);
    });
    EXPECT_TRUE(WIFEXITED(status)) << "ended by signal " << WTERMSIG(status);
    EXPECT_EQ(WEXITSTATUS(status), 0) << "3: another message";
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  }
}

TEST(AtomicFile, FullDiskLeavesTheOldFileAlone) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "file", "old");
  status_of_child([&] {
    const rlimit limit = {.rlim_cur = 4096, .rlim_max = 4096};
    setrlimit(RLIMIT_FSIZE, &limit);
    message_of([&] { write_file_atomically(folder / "file", std::string(10000, 'x')); });
  });
  EXPECT_EQ(read_file(folder / "file"), "old");
}

TEST(AtomicFile, DeviceIsNotReplacedByAFile) {
  struct stat status = {};
  if (stat("/dev/full", &status) != 0) GTEST_SKIP() << "this machine has no /dev/full";
  EXPECT_THAT(message_of([] { write_file_atomically("/dev/full", "x"); }),
              HasSubstr("/dev/full: cannot write: it is not a regular file; expected"));
  EXPECT_EQ(stat("/dev/full", &status), 0);
  EXPECT_TRUE(S_ISCHR(status.st_mode));
}

TEST(AtomicFile, PlacesThatCannotHoldAFileAreRefused) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "plain", "x");
  EXPECT_THAT(message_of([&] { write_file_atomically(folder / "plain/file", "x"); }),
              HasSubstr("plain/file: cannot write: Not a directory; expected"));
  EXPECT_THAT(message_of([&] { write_file_atomically(folder / "none/file", "x"); }),
              HasSubstr("none/file: cannot write: No such file or directory; expected"));
  EXPECT_THAT(message_of([&] { write_file_atomically(folder.path(), "x"); }),
              HasSubstr("cannot write: it is not a regular file; expected"));
  EXPECT_THAT(message_of([&] { make_folder(folder / "plain/below"); }),
              HasSubstr("plain/below: cannot create: Not a directory; expected"));
  EXPECT_THAT(message_of([&] { make_folder(folder / "plain"); }), HasSubstr("Not a directory"));
}

TEST(AtomicFile, UnreadableFilesAreRefusedWithTheReason) {
  const TemporaryFolder folder;
  EXPECT_EQ(
      message_of([&] { read_file(folder / "none"); }),
      (folder / "none") + ": cannot read: No such file or directory; expected a readable file");
  EXPECT_THAT(message_of([&] { read_file(folder.path()); }),
              HasSubstr("cannot read: Is a directory"));
}

TEST(AtomicFile, FolderIsMadeWithItsParentsAndMayExist) {
  const TemporaryFolder folder;
  make_folder(folder / "a/b/c");
  make_folder(folder / "a/b/c");
  EXPECT_TRUE(std::filesystem::is_directory(folder / "a/b/c"));
}

TEST(AtomicFile, FileInTheCurrentFolderNeedsNoSlash) {
  const TemporaryFolder folder;
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  write_file_atomically("bare", "x");
  std::filesystem::current_path(before);
  EXPECT_EQ(read_file(folder / "bare"), "x");
}

}  // namespace
}  // namespace pluvia
