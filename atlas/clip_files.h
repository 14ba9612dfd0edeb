// Frames of a clip from disk, linear: a video that OpenImageIO's ffmpeg reads, or pictures. A
// source is
// - a video, or one picture;
// - a folder of pictures, all of one kind, in the order of their names;
// - a pattern FOLDER/NAME in whose NAME a * stands for any letters, as frames/*.png.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "atlas/image.h"

namespace pluvia {

// The files of a source; a video's or picture's own name alone. Throws std::runtime_error "SOURCE:
// what was found; what is expected" where no file has such a name, or several kinds have.
std::vector<std::string> picture_files(const std::string& source);

struct ClipFrame {
  Image image = {};
  bool encoded = false;  // whole numbers, taken as sRGB-encoded, 0 .. 1; else floats, as linear
};

// Frame by frame: a long video needs no more memory than a short one.
class ClipReader {
 public:
  // Throws std::runtime_error "FILE: what was found; what is expected", as next does.
  explicit ClipReader(const std::string& source);
  ~ClipReader();
  ClipReader(const ClipReader&) = delete;
  ClipReader& operator=(const ClipReader&) = delete;

  // Nothing at the end. One or three channels; a channel of opacity is left out. Refused are values
  // that are not finite or below 0, and a frame of another size than the first.
  std::optional<ClipFrame> next();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// The first most_frames >= 1 frames, or all where there are fewer; of a video at least 3. Throws
// std::runtime_error as above.
std::vector<Image> read_clip(const std::string& source, int most_frames);

}  // namespace pluvia
