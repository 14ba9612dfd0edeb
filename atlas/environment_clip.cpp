#include "atlas/environment_clip.h"

#include <algorithm>
#include <cassert>
#include <optional>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace pluvia {

EnvironmentClip::EnvironmentClip(const std::string& source)
    : source_(source), files_(picture_files(source)) {}

void EnvironmentClip::keep(Image map, long number, const std::string& file) {
  if (map.channels != 3 || map.width != 2 * map.height)
    throw std::runtime_error(
        fmt::format("{}: {} x {} pixels, {} channels; expected width = 2 * height and 3 channels",
                    file, map.width, map.height, map.channels));
  if (shown_ >= 0 && map.width != map_.width)
    throw std::runtime_error(fmt::format("{}: {} pixels wide; expected {} like the others of {}",
                                         file, map.width, map_.width, source_));
  map_ = std::move(map);
  shown_ = number;
}

// Of a video, or the only picture.
void EnvironmentClip::read_on(long k) {
  if (!reader_ || k < shown_) {
    reader_ = std::make_unique<ClipReader>(source_);
    read_ = 0;
  }
  while (read_ <= k) {
    std::optional<ClipFrame> frame = reader_->next();
    if (!frame) break;
    keep(std::move(frame->image), read_++, source_);
  }
  if (shown_ < 0) throw std::runtime_error(source_ + ": has no picture; expected one or more");
}

const Image& EnvironmentClip::at(long k) {
  assert(k >= 0);
  const bool pictures = files_.size() > 1 || files_.front() != source_;
  const long place = std::min(k, static_cast<long>(files_.size()) - 1);
  const std::string& file = files_[static_cast<std::size_t>(place)];
  if (!pictures)
    read_on(k);
  else if (place != shown_)
    keep(ClipReader(file).next().value().image, place, file);
  asked_ = k;
  return map_;
}

}  // namespace pluvia
