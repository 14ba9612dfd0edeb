// A frame's bytes with another number of threads: OpenGL's software rasteriser reads LP_NUM_THREADS
// once in a process, so a test runs itself again, and writes its frames to the file it then finds.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "atlas/image.h"
#include "tests/temporary_folder.h"

namespace pluvia {

// The file to append frames to; nullptr in the test that was asked for.
inline const char* file_of_rerun() {
  return std::getenv("PLUVIA_TEST_FRAME");
}

inline void append_bytes(std::ofstream& out, const Image& image) {
  out.write(reinterpret_cast<const char*>(image.values.data()),
            static_cast<std::streamsize>(image.values.size() * sizeof(float)));
}

// What the test that is running now writes with so many threads, run after run.
inline std::vector<std::string> bytes_of_reruns(const std::vector<int>& thread_counts) {
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  const std::string name = std::string(test->test_suite_name()) + "." + test->name();
  const TemporaryFolder folder;
  std::vector<std::string> bytes;
  for (const int threads : thread_counts) {
    const std::string file = folder / std::to_string(bytes.size());
    const std::string command = "LP_NUM_THREADS=" + std::to_string(threads) +
                                " PLUVIA_TEST_FRAME=" + file + " " +
                                std::filesystem::read_symlink("/proc/self/exe").string() +
                                " --gtest_filter=" + name + " > " + file + ".log 2>&1";
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
    std::ifstream in(file, std::ios::binary);
    bytes.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  return bytes;
}

}  // namespace pluvia
