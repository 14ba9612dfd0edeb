// Pages in a real browser: chromium, without a window.
#pragma once

#include <cstdlib>
#include <sstream>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "atlas/atomic_file.h"

namespace pluvia {

inline bool has_browser() {
  return std::system("command -v chromium >/dev/null 2>&1") == 0;
}

struct Browsing {
  std::string document = {};  // as it stands when nothing is left to do
  std::string console = {};   // what the page, or the browser about it, wrote there
};

// Opens FOLDER/FILE in a window. Its clock runs ahead while the page waits, up to 20 s: a page that
// waits for a timer costs no time.
inline Browsing browse(const std::string& folder, const std::string& file, int width_px) {
  const std::string command = fmt::format(
      "timeout 60 chromium --headless --no-sandbox --disable-gpu --disable-quic --no-first-run "
      "--disable-background-networking --disable-component-update --disable-sync "
      "--enable-logging=stderr --user-data-dir='{0}/profile' --window-size={1},2000 "
      "--virtual-time-budget=20000 --dump-dom 'file://{0}/{2}' >'{0}/document' 2>'{0}/log'",
      folder, width_px, file);
  EXPECT_EQ(std::system(command.c_str()), 0) << read_file(folder + "/log");
  Browsing seen = {read_file(folder + "/document"), ""};
  std::istringstream lines(read_file(folder + "/log"));
  for (std::string line; std::getline(lines, line);) {
    if (line.find("CONSOLE") != std::string::npos) seen.console += line + "\n";
  }
  return seen;
}

}  // namespace pluvia
