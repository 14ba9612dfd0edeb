// A display without a screen (Xvfb) for as long as this lives, in DISPLAY.
#pragma once

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <string>

#include <fmt/format.h>

namespace pluvia {

class XServer {
 public:
  XServer() {
    std::array<int, 2> ends = {};
    if (pipe(ends.data()) != 0) return;
    pid_ = fork();
    if (pid_ == 0) {
      close(ends[0]);
      const std::string fd = std::to_string(ends[1]);
      // It chooses a free number itself and tells it there.
      execlp("Xvfb", "Xvfb", "-displayfd", fd.c_str(), "-screen", "0", "1280x720x24", "-nolisten",
             "tcp", nullptr);
      _exit(127);
    }
    close(ends[1]);
    char letter = 0;
    while (read(ends[0], &letter, 1) == 1 && letter != '\n') display_ += letter;
    close(ends[0]);
    if (started()) setenv("DISPLAY", (":" + display_).c_str(), 1);
  }
  ~XServer() {
    unsetenv("DISPLAY");
    if (pid_ <= 0) return;
    kill(pid_, SIGTERM);
    waitpid(pid_, nullptr, 0);
  }
  XServer(const XServer&) = delete;
  XServer& operator=(const XServer&) = delete;

  bool started() const { return !display_.empty(); }

 private:
  pid_t pid_ = -1;
  std::string display_ = {};
};

}  // namespace pluvia
