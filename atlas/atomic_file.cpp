#include "atlas/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <mutex>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <openssl/sha.h>

namespace pluvia {
namespace {

std::mutex hook_mutex;
std::function<void(long)> write_point_hook;
long next_write_point = 0;

// The hook runs outside the lock: it may write files itself.
void pass_write_point() {
  std::function<void(long)> hook;
  long number = 0;
  {
    const std::lock_guard lock(hook_mutex);
    if (!write_point_hook) return;
    hook = write_point_hook;
    number = next_write_point++;
  }
  hook(number);
}

std::string reason(int error) {
  return std::generic_category().message(error);
}

[[noreturn]] void throw_write_error(const std::string& file, const std::string& why,
                                    std::size_t size) {
  throw std::runtime_error(fmt::format(
      "{}: cannot write: {}; expected a writable folder with room for {} bytes", file, why, size));
}

// A write beyond the process's file size limit raises SIGXFSZ, which would end the program in the
// middle of the file. Blocked in this thread and taken off the queue, write() just says EFBIG.
class FileSizeSignalBlock {
 public:
  FileSizeSignalBlock() {
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGXFSZ);
    pthread_sigmask(SIG_BLOCK, &signals_, &before_);
  }
  FileSizeSignalBlock(const FileSizeSignalBlock&) = delete;
  FileSizeSignalBlock& operator=(const FileSizeSignalBlock&) = delete;
  ~FileSizeSignalBlock() {
    if (sigismember(&before_, SIGXFSZ) == 1) return;  // the caller's own business
    const timespec at_once = {};
    while (sigtimedwait(&signals_, nullptr, &at_once) == SIGXFSZ) {
    }
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }

 private:
  sigset_t signals_ = {};
  sigset_t before_ = {};
};

// Each step below returns 0 or an errno.

int write_all(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

int write_and_sync(int descriptor, std::string_view bytes) {
  const std::size_t half = bytes.size() / 2;
  if (const int error = write_all(descriptor, bytes.substr(0, half))) return error;
  pass_write_point();
  if (const int error = write_all(descriptor, bytes.substr(half))) return error;
  pass_write_point();
  return fsync(descriptor) == 0 ? 0 : errno;
}

int write_with(int (*write_bytes)(int, std::string_view), const std::string& file,
               std::string_view bytes) {
  const FileSizeSignalBlock block;
  const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) return errno;
  const int error = write_bytes(descriptor, bytes);
  if (close(descriptor) != 0 && error == 0) return errno;
  return error;
}

// Makes the rename itself last through a power cut.
int sync_folder(const std::string& file) {
  const std::string parent = std::filesystem::path(file).parent_path().string();
  const int descriptor =
      open(parent.empty() ? "." : parent.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return errno;
  const int error = fsync(descriptor) == 0 ? 0 : errno;
  close(descriptor);
  return error == EINVAL ? 0 : error;  // EINVAL: a file system that has no such thing
}

std::string read_all(int descriptor, const std::string& file) {
  std::string bytes;
  std::array<char, 1 << 16> chunk = {};
  for (;;) {
    const ssize_t count = read(descriptor, chunk.data(), chunk.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      throw std::runtime_error(
          fmt::format("{}: cannot read: {}; expected a readable file", file, reason(errno)));
    }
    if (count == 0) return bytes;
    bytes.append(chunk.data(), static_cast<std::size_t>(count));
  }
}

}  // namespace

void write_file_atomically(const std::string& file, std::string_view bytes) {
  // A rename would replace a device such as /dev/full by a plain file.
  struct stat status = {};
  if (stat(file.c_str(), &status) == 0 && !S_ISREG(status.st_mode)) {
    throw_write_error(file, "it is not a regular file", bytes.size());
  }
  const std::string temporary = file + ".tmp";
  pass_write_point();
  int error = write_with(write_and_sync, temporary, bytes);
  if (error == 0) {
    pass_write_point();
    if (rename(temporary.c_str(), file.c_str()) != 0) error = errno;
  }
  if (error != 0) {
    unlink(temporary.c_str());
    throw_write_error(file, reason(error), bytes.size());
  }
  pass_write_point();
  if (const int sync_error = sync_folder(file)) {
    throw_write_error(file, reason(sync_error), bytes.size());
  }
}

void write_file_plainly(const std::string& file, std::string_view bytes) {
  if (const int error = write_with(write_all, file, bytes)) {
    throw_write_error(file, reason(error), bytes.size());
  }
}

std::string read_file(const std::string& file) {
  const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) {
    throw std::runtime_error(
        fmt::format("{}: cannot read: {}; expected a readable file", file, reason(errno)));
  }
  try {
    std::string bytes = read_all(descriptor, file);
    close(descriptor);
    return bytes;
  } catch (...) {
    close(descriptor);
    throw;
  }
}

void make_folder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error && !std::filesystem::is_directory(folder)) {
    error = std::make_error_code(std::errc::not_a_directory);
  }
  if (error) {
    throw std::runtime_error(
        fmt::format("{}: cannot create: {}; expected a folder, or a place where one may be made",
                    folder, error.message()));
  }
}

std::string sha256(std::string_view bytes) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest = {};
  SHA256(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(), digest.data());
  std::string text;
  for (const unsigned char byte : digest) text += fmt::format("{:02x}", byte);
  return text;
}

void set_write_point_hook(std::function<void(long)> hook) {
  const std::lock_guard lock(hook_mutex);
  write_point_hook = std::move(hook);
  next_write_point = 0;
}

}  // namespace pluvia
