// What OpenImageIO says went wrong, for messages of one line.
#pragma once

#include <algorithm>
#include <string>

namespace pluvia {

// OpenImageIO's messages may span lines and end with one.
inline std::string one_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.empty() ? "unknown reason" : text;
}

}  // namespace pluvia
