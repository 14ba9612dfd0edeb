// OpenEXR files as bytes in memory: what the shard, the atlas and single pictures share. A file is
// a list of parts (scan lines, 32-bit float, ZIP), and its bytes are a function of the parts alone.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace pluvia {

struct ExrChannel {
  std::string name = {};
  std::vector<float> values = {};  // width * height of the part, row by row
};

struct ExrPart {
  std::string name = {};  // unique in the file
  int width = 0;          // >= 1
  int height = 0;         // >= 1
  std::vector<ExrChannel> channels = {};
  std::map<std::string, int> attributes = {};  // integers of the part's header
};

std::string exr_bytes(const std::vector<ExrPart>& parts);

// Every part with all of its float channels (by name) and integer attributes; a channel of another
// type is an error. Throws std::runtime_error "FILE: .." or "FILE: part NAME: .." on anything that
// is not a whole file; `file` is only for that message.
std::vector<ExrPart> parse_exr(const std::string& file, std::string_view bytes);

// Throws std::runtime_error "FILE: part NAME: pixel (x, y) channel C = v; expected a finite value
// >= 0".
void check_radiances(const std::string& file, const ExrPart& part);

// The same, but only channels NAME.variance must be >= 0.
void check_signed_values(const std::string& file, const ExrPart& part);

}  // namespace pluvia
