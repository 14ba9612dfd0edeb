// Lat-long environment maps that follow each other: a video, or pictures, as atlas/clip_files.h
// reads them: whole numbers are taken as sRGB-encoded and made linear, white is 1; floats as they
// are. A map lies as read_environment_map (atlas/image_io.h) has it; here it may be black.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "atlas/clip_files.h"
#include "atlas/image.h"

namespace pluvia {

class EnvironmentClip {
 public:
  // A source of atlas/clip_files.h. Throws std::runtime_error "FILE: what was found; what is
  // expected", as at does.
  explicit EnvironmentClip(const std::string& source);

  // Map k >= 0; beyond the end the last one. Of a video every picture before it is read, in their
  // order, and going back begins anew: a decoder that jumps may show another picture. Refuses a map
  // that is not twice as wide as high, that has less than 3 channels, and one of another size than
  // the first that was read.
  const Image& at(long k);

  long shown() const { return shown_; }          // the map that at gave last; -1: none yet
  bool held() const { return shown_ < asked_; }  // the clip has ended before the one asked for

 private:
  void keep(Image map, long number, const std::string& file);
  void read_on(long k);

  std::string source_ = {};
  std::vector<std::string> files_ = {};      // pictures, or the one video
  std::unique_ptr<ClipReader> reader_ = {};  // of a single file
  long read_ = 0;                            // pictures of it
  long asked_ = -1, shown_ = -1;
  Image map_ = {};
};

}  // namespace pluvia
