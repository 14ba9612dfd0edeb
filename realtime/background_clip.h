// The pictures that rain is put over, frame by frame, with their depths: a photograph or a video
// and the depths of its pixels, as radiance in cd/m^2 and metres.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "atlas/clip_files.h"
#include "raytrace/scene.h"
#include "realtime/picture_pass.h"

namespace pluvia {

struct BackgroundFiles {
  std::string pictures = {};             // a source of atlas/clip_files.h
  bool still = false;                    // its first picture stands for all frames
  std::string depths = {};               // as atlas/depth_picture.h reads them: one, or a source of
                                         // one for each frame
  double depth_scale_m = 0;              // of PNGs of depths; 0: not given
  std::optional<double> one_cd_m2 = {};  // radiance of 1; nothing: the camera's white for pictures
                                         // of whole numbers, 1 for floats
};

class BackgroundClip {
 public:
  // scene_file: for messages. Throws std::runtime_error "FILE: what was found; what is expected",
  // as next does.
  BackgroundClip(const BackgroundFiles& files, const Camera& camera, const std::string& scene_file);

  // Goes on to the next frame, the first at first; false at the end of the pictures. Refuses a
  // picture or a depth of another size than the camera's, and depths that are neither one nor as
  // many as pictures.
  bool next();

  // Of the frame; it stays where it is.
  const Picture& picture() const { return picture_; }

 private:
  void check_size(const std::string& file, const Image& image) const;
  [[noreturn]] void refuse_depths() const;
  void read_next_depth();

  BackgroundFiles files_ = {};
  Camera camera_ = {};
  std::string scene_file_ = {};
  ClipReader clip_;
  std::vector<std::string> depths_ = {};
  std::size_t read_ = 0;  // pictures
  Picture picture_ = {};
};

}  // namespace pluvia
