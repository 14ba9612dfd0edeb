#include "realtime/background_clip.h"

#include <stdexcept>

#include <fmt/format.h>

#include "atlas/depth_picture.h"

namespace pluvia {
namespace {

// A grey picture has three channels alike.
Image radiance(const Image& image, double one_cd_m2) {
  Image color = make_image(image.width, image.height, 3);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < 3; ++c)
        color.at(x, y, c) = static_cast<float>(
            one_cd_m2 * static_cast<double>(image.at(x, y, image.channels == 3 ? c : 0)));
    }
  }
  return color;
}

}  // namespace

BackgroundClip::BackgroundClip(const BackgroundFiles& files, const Camera& camera,
                               const std::string& scene_file)
    : files_(files),
      camera_(camera),
      scene_file_(scene_file),
      clip_(files.pictures),
      depths_(picture_files(files.depths)) {
  const std::size_t pictures = picture_files(files.pictures).size();
  if (files.still && pictures > 1)
    throw std::runtime_error(
        fmt::format("{}: {} pictures; expected one, or --video", files.pictures, pictures));
  if (files.still && depths_.size() > 1) refuse_depths();
}

void BackgroundClip::refuse_depths() const {
  throw std::runtime_error(
      fmt::format("{}: {} depths; expected one for all frames, or one for each of {}",
                  files_.depths, depths_.size(), files_.pictures));
}

void BackgroundClip::check_size(const std::string& file, const Image& image) const {
  if (image.width == camera_.width_px && image.height == camera_.height_px) return;
  throw std::runtime_error(fmt::format("{}: {} x {} pixels; expected {} x {} like the camera of {}",
                                       file, image.width, image.height, camera_.width_px,
                                       camera_.height_px, scene_file_));
}

void BackgroundClip::read_next_depth() {
  if (read_ >= depths_.size()) refuse_depths();
  picture_.depth_m = read_depth(depths_[read_], files_.depth_scale_m);
  check_size(depths_[read_], picture_.depth_m);
}

bool BackgroundClip::next() {
  if (files_.still && read_ > 0) return true;
  const std::optional<ClipFrame> frame = clip_.next();
  if (!frame && depths_.size() > 1 && read_ < depths_.size()) refuse_depths();
  if (!frame) return false;
  check_size(files_.pictures, frame->image);
  picture_.color =
      radiance(frame->image, files_.one_cd_m2.value_or(frame->encoded ? camera_.white_cd_m2 : 1));
  if (depths_.size() > 1 || read_ == 0) read_next_depth();
  ++read_;
  return true;
}

}  // namespace pluvia
