#include "realtime/video.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cassert>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>

#include "atlas/image_io.h"

namespace pluvia {
namespace {

struct File {  // closed when it goes
  int descriptor = -1;
  ~File() { close_now(); }
  void close_now() {
    if (descriptor >= 0) close(descriptor);
    descriptor = -1;
  }
};

std::string first_line(int descriptor) {
  std::array<char, 1024> text = {};
  if (pread(descriptor, text.data(), text.size() - 1, 0) <= 0) return "it said nothing";
  std::istringstream lines(text.data());
  std::string line;
  std::getline(lines, line);
  return line;
}

}  // namespace

bool ffmpeg_is_present() {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (access((folder + "/ffmpeg").c_str(), X_OK) == 0) return true;
  }
  return false;
}

struct VideoWriter::State {
  std::string file = {};
  int width = 0, height = 0;
  pid_t process = 0;
  File frames = {};    // a socket, not a pipe: writing to a dead one is then an error, not a signal
  File messages = {};  // what ffmpeg says, in an unnamed file

  std::string temporary() const { return file + ".tmp"; }  // renamed when it is whole
  void start(int frames_per_second);
  [[noreturn]] void refuse() const;
  int wait_for_end();
};

void VideoWriter::State::refuse() const {
  std::error_code ignored;
  std::filesystem::remove(temporary(), ignored);
  throw std::runtime_error(fmt::format("{}: ffmpeg: {}; expected it to write an mp4", file,
                                       first_line(messages.descriptor)));
}

int VideoWriter::State::wait_for_end() {
  frames.close_now();
  int status = 0;
  while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  process = 0;
  return status;
}

void VideoWriter::State::start(int frames_per_second) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    throw std::runtime_error(file + ": no socket pair; expected one for ffmpeg");
  frames.descriptor = ends[0];
  const File other_end = {ends[1]};
  messages.descriptor = open("/tmp", O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  const std::string rate = fmt::format("{}", frames_per_second);
  const std::string target = "file:" + temporary();  // a name with a colon is no protocol
  const char* const arguments[] = {
      "ffmpeg",       "-y",      "-loglevel",  "error",      "-f",   "image2pipe",
      "-c:v",         "png",     "-framerate", rate.c_str(), "-i",   "-",
      "-c:v",         "libx264", "-preset",    "veryfast",   "-crf", "20",
      "-pix_fmt",     "yuv420p", "-movflags",  "+faststart", "-f",   "mp4",
      target.c_str(), nullptr};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, other_end.descriptor, STDIN_FILENO);
  if (messages.descriptor >= 0)
    posix_spawn_file_actions_adddup2(&actions, messages.descriptor, STDERR_FILENO);
  const int error = posix_spawnp(&process, "ffmpeg", &actions, nullptr,
                                 const_cast<char* const*>(arguments), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) {
    process = 0;
    throw std::runtime_error(file + ": ffmpeg cannot be started; expected it on the PATH");
  }
}

VideoWriter::VideoWriter(const std::string& file, int width, int height, int frames_per_second)
    : state_(std::make_unique<State>()) {
  if (width < 2 || height < 2 || width % 2 || height % 2 || frames_per_second < 1)
    throw std::runtime_error(
        fmt::format("{}: {} x {} px at {} frames/s; expected an even width and "
                    "height and at least 1 frame/s",
                    file, width, height, frames_per_second));
  state_->file = file;
  state_->width = width;
  state_->height = height;
  state_->start(frames_per_second);
}

VideoWriter::~VideoWriter() {
  if (state_->process == 0) return;
  kill(state_->process, SIGKILL);
  state_->wait_for_end();
  std::error_code ignored;
  std::filesystem::remove(state_->temporary(), ignored);
}

void VideoWriter::add(const Image& frame, double white) {
  assert(frame.width == state_->width && frame.height == state_->height && frame.channels == 3);
  assert(state_->process != 0 && white > 0);
  const std::vector<unsigned char> bytes = png_bytes(frame, white);
  for (std::size_t sent = 0; sent < bytes.size();) {
    const ssize_t n =
        send(state_->frames.descriptor, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      state_->wait_for_end();
      state_->refuse();
    }
    sent += static_cast<std::size_t>(n);
  }
}

void VideoWriter::finish() {
  const int status = state_->wait_for_end();
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) state_->refuse();
  std::filesystem::rename(state_->temporary(), state_->file);
}

}  // namespace pluvia
