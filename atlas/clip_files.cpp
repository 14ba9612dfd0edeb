#include "atlas/clip_files.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <set>
#include <stdexcept>
#include <utility>

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include "atlas/oiio_message.h"
#include "atlas/rec709.h"

namespace pluvia {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const std::string& file, const std::string& found_and_expected) {
  throw std::runtime_error(file + ": " + found_and_expected);
}

std::unique_ptr<OIIO::ImageInput> opened(const std::string& file) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  if (error) refuse(file, "cannot read: " + error.message() + "; expected a video or pictures");
  if (size == 0) refuse(file, "is empty; expected a video or a picture");
  // Else colours come multiplied by the opacity that is left out.
  const OIIO::ImageSpec config = [] {
    OIIO::ImageSpec spec;
    spec["oiio:UnassociatedAlpha"] = 1;
    return spec;
  }();
  auto input = OIIO::ImageInput::open(file, &config);
  if (!input)
    refuse(file,
           "cannot be read: " + one_line(OIIO::geterror()) + "; expected a video or a picture");
  return input;
}

// The frame at which the input stands.
ClipFrame read_frame(OIIO::ImageInput& input, const std::string& file, int frame) {
  const OIIO::ImageSpec& spec = input.spec();
  const int channels = spec.nchannels < 3 ? 1 : 3;
  Image image = make_image(spec.width, spec.height, channels);
  if (!input.read_image(frame, 0, 0, channels, OIIO::TypeDesc::FLOAT, image.values.data()) ||
      input.has_error())
    refuse(file, fmt::format("frame {} cannot be read: {}; expected a whole one", frame,
                             one_line(input.geterror())));
  const bool encoded = !spec.format.is_floating_point();
  for (float& value : image.values) {
    if (!std::isfinite(value) || value < 0)
      refuse(file, fmt::format("has a value {}; expected finite values >= 0", value));
    if (encoded) value = static_cast<float>(srgb_linear(value));
  }
  return {std::move(image), encoded};
}

bool matches(const std::string& name, const std::string& pattern) {
  const auto star = pattern.find('*');
  if (star == std::string::npos) return name == pattern;
  if (name.compare(0, star, pattern, 0, star) != 0) return false;
  const std::string rest = pattern.substr(star + 1);
  for (std::size_t i = star; i <= name.size(); ++i) {
    if (matches(name.substr(i), rest)) return true;
  }
  return false;
}

// Files of a folder whose name matches, in order of their names.
std::vector<std::string> matching_files(const fs::path& folder, const std::string& pattern) {
  std::error_code error;
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.is_regular_file() && matches(entry.path().filename().string(), pattern))
      files.push_back(entry.path().string());
  }
  if (error) refuse(folder.string(), "cannot read: " + error.message() + "; expected a folder");
  std::sort(files.begin(), files.end());
  return files;
}

bool names_pictures(const std::string& source) {
  const bool pattern = fs::path(source).filename().string().find('*') != std::string::npos;
  return pattern || fs::is_directory(source);
}

std::string size_text(const Image& frame) {
  return fmt::format("{} x {} pixels of {} channels", frame.width, frame.height, frame.channels);
}

}  // namespace

std::vector<std::string> picture_files(const std::string& source) {
  if (!names_pictures(source)) return {source};
  const fs::path path(source);
  const bool folder = fs::is_directory(path);
  const fs::path parent = path.has_parent_path() ? path.parent_path() : fs::path(".");
  std::vector<std::string> files =
      matching_files(folder ? path : parent, folder ? "*" : path.filename().string());
  if (files.empty()) refuse(source, "no file of that name; expected pictures");
  std::set<std::string> kinds;
  for (const std::string& file : files) kinds.insert(fs::path(file).extension().string());
  if (kinds.size() > 1)
    refuse(source, fmt::format("files of {} kinds, {} and {}; expected one, such as \"{}/*.png\"",
                               kinds.size(), *kinds.begin(), *std::next(kinds.begin()),
                               (folder ? path : parent).string()));
  return files;
}

struct ClipReader::State {
  std::vector<std::string> files = {};           // pictures, or the one video
  bool video = false;                            // of which frame after frame is read
  std::unique_ptr<OIIO::ImageInput> input = {};  // the video's
  int next = 0;
  Image first = {};  // without its values
};

ClipReader::ClipReader(const std::string& source) : state_(std::make_unique<State>()) {
  state_->files = picture_files(source);
  state_->video = !names_pictures(source);
  if (state_->video) state_->input = opened(source);
}

ClipReader::~ClipReader() = default;

std::optional<ClipFrame> ClipReader::next() {
  State& state = *state_;
  const int k = state.next;
  const auto place = static_cast<std::size_t>(state.video ? 0 : k);
  if (place >= state.files.size()) return {};
  const std::string& file = state.files[place];
  if (!state.video) state.input = opened(file);
  if (state.video && !state.input->seek_subimage(k, 0)) return {};
  ClipFrame frame = read_frame(*state.input, file, state.video ? k : 0);
  const Image &first = state.first, &now = frame.image;
  if (k == 0)
    state.first = {now.width, now.height, now.channels};
  else if (now.width != first.width || now.height != first.height || now.channels != first.channels)
    refuse(file, fmt::format("{}; expected {} like {}", size_text(now), size_text(first),
                             state.files.front()));
  ++state.next;
  return frame;
}

std::vector<Image> read_clip(const std::string& source, int most_frames) {
  ClipReader reader(source);
  std::vector<Image> frames;
  while (static_cast<int>(frames.size()) < most_frames) {
    std::optional<ClipFrame> frame = reader.next();
    if (!frame) break;
    frames.push_back(std::move(frame->image));
  }
  if (!names_pictures(source) && frames.size() < 3)
    refuse(source, fmt::format("{} frames; expected a video of at least 3", frames.size()));
  return frames;
}

}  // namespace pluvia
