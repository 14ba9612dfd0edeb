// The program as a user runs it.
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <string>

#include <fmt/format.h>

#include "atlas/atomic_file.h"
#include "tests/temporary_folder.h"

namespace pluvia {

struct Outcome {
  int code = -1;  // -1: it did not exit by itself
  std::string out = {}, err = {};
};

inline Outcome run_pluvia(const std::string& arguments) {
  const TemporaryFolder folder;
  const int status = std::system(
      fmt::format("{} {} >{} 2>{}", PLUVIA_PROGRAM, arguments, folder / "out", folder / "err")
          .c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_file(folder / "out"),
          read_file(folder / "err")};
}

}  // namespace pluvia
