// Frames to an H.264 mp4, through an ffmpeg process.
#pragma once

#include <memory>
#include <string>

#include "atlas/image.h"

namespace pluvia {

// Whether an `ffmpeg` is on the PATH. Without it there is no video: an outcome, not an error.
bool ffmpeg_is_present();

class VideoWriter {
 public:
  // frames_per_second > 0; width and height even (4:2:0). Throws std::runtime_error
  // "FILE: what was found; what is expected", also when ffmpeg cannot be started.
  VideoWriter(const std::string& file, int width, int height, int frames_per_second);
  ~VideoWriter();  // without finish(): ffmpeg is stopped and what it wrote is removed
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  // RGB of the video's size; encoded like atlas/image_io.h's PNG: linear / white, cut to 0..1,
  // sRGB. Throws std::runtime_error "FILE: ffmpeg: its first line; ..." when ffmpeg stops.
  void add(const Image& frame, double white);

  // Waits for the file to be whole. Throws as add does.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace pluvia
