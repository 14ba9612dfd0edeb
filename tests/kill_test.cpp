// The program killed at any moment, not at counted ones: what it leaves must always be resumed to
// the same bytes; and its work dealt over several folders must merge to them.

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <map>
#include <random>
#include <thread>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/preset_files.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

pid_t start_pluvia(std::vector<std::string> arguments) {
  const pid_t child = fork();
  if (child != 0) return child;
  arguments.insert(arguments.begin(), PLUVIA_PROGRAM);
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  const int nowhere = open("/dev/null", O_WRONLY);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  execv(PLUVIA_PROGRAM, pointers.data());
  _exit(127);
}

// True when it was killed; a failure of the test when it ended otherwise than well.
bool killed(pid_t child) {
  int status = 0;
  waitpid(child, &status, 0);
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) return true;
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "status " << status;
  return false;
}

// By name; without cost.json, which is outside the promise, and what interrupted writes of it left.
std::map<std::string, std::string> bytes_of(const std::string& folder) {
  std::map<std::string, std::string> bytes;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = fs::relative(entry.path(), folder).string();
    if (!entry.is_regular_file() || name.starts_with("cost.json")) continue;
    bytes[name] = read_file(entry.path().string());
  }
  return bytes;
}

class Kill : public testing::Test {
 protected:
  std::vector<std::string> generate(const std::string& out,
                                    const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"generate", preset, "--out", folder / out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  void run(const std::vector<std::string>& arguments) const {
    ASSERT_FALSE(killed(start_pluvia(arguments)));
  }

  void expect_shares_merge_to_whole(int workers) const {
    std::vector<std::string> merge = {"merge", "--out", folder / "merged"};
    std::size_t files = 0;
    for (int i = 1; i <= workers; ++i) {
      const std::string out = fmt::format("part{}", i);
      run(generate(out, {"--shard", fmt::format("{}/{}", i, workers)}));
      files += bytes_of(folder / out).size() - 1;  // without the manifest
      merge.push_back(folder / out);
    }
    run(merge);
    const auto whole = bytes_of(folder / "whole");
    EXPECT_EQ(files, whole.size() - 1) << "each shard once";
    EXPECT_EQ(bytes_of(folder / "merged"), whole);
  }

  const TemporaryFolder folder;
  const std::string preset =
      write_preset(folder.path(), replaced(tiny_preset, "[80]", "[70, 80]"));  // four shards
};

TEST_F(Kill, RunKilledAtTwentyRandomMomentsEndsWithTheSameBytes) {
  const auto start = Clock::now();
  run(generate("whole"));
  const double whole_s = Seconds(Clock::now() - start).count();
  const auto whole = bytes_of(folder / "whole");
  ASSERT_EQ(whole.size(), 5u);
  const unsigned seed = std::random_device()();
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> moment_s(0, whole_s);
  int kills = 0, starts = 0;
  for (; kills < 20 && starts < 100; ++starts) {
    const pid_t child = start_pluvia(generate("killed"));
    std::this_thread::sleep_for(Seconds(moment_s(random)));
    kill(child, SIGKILL);
    if (killed(child)) {
      ++kills;
      continue;
    }
    EXPECT_EQ(bytes_of(folder / "killed"), whole) << "seed " << seed << ", start " << starts;
    fs::remove_all(folder / "killed");
  }
  EXPECT_EQ(kills, 20) << "of " << starts << " starts";
  run(generate("killed"));
  EXPECT_EQ(bytes_of(folder / "killed"), whole) << "seed " << seed;
}

TEST_F(Kill, SharesOfSeveralWorkersMergeToTheSameBytes) {
  run(generate("whole"));
  expect_shares_merge_to_whole(5);  // for four shards: the last has nothing to do
}

TEST_F(Kill, SharesOfSeveralSizesAndBandsMergeToTheSameBytes) {
  write_physical(folder.path());
  run(generate("whole"));
  expect_shares_merge_to_whole(2);
}

}  // namespace
}  // namespace pluvia
