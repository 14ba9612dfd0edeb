#include "atlas/atomic_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <system_error>

#include <fmt/format.h>

#include "atlas/atomic_file.h"

namespace pluvia {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void throw_cannot_create(const std::string& folder, int error) {
  throw std::runtime_error(
      fmt::format("{}: cannot create: {}; expected a folder, or a place where one may be made",
                  folder, std::generic_category().message(error)));
}

void refuse_existing(const std::string& folder) {
  std::error_code ignored;
  if (fs::symlink_status(folder, ignored).type() == fs::file_type::not_found) return;
  if (ignored) throw_cannot_create(folder, ignored.value());
  throw std::runtime_error(folder + ": is there already; expected a folder that is not there yet");
}

// Held while the folder is filled; released by the system when the process dies.
class FolderLock {
 public:
  explicit FolderLock(const std::string& folder) {
    if (mkdir(folder.c_str(), 0777) != 0 && errno != EEXIST) throw_cannot_create(folder, errno);
    descriptor_ = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (descriptor_ < 0) throw_cannot_create(folder, errno);
    // Any other error: a file system without locks, such as some network ones; then there is none.
    const bool taken = flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    if (!taken && is_still(folder)) return;
    close(descriptor_);
    throw std::runtime_error(folder +
                             ": another run is writing it; expected one run for each folder");
  }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  ~FolderLock() { close(descriptor_); }

  // Everything that was written to the folder's file system.
  int sync() const { return syncfs(descriptor_) == 0 ? 0 : errno; }

 private:
  // Another run may have renamed it between open and lock.
  bool is_still(const std::string& folder) const {
    struct stat ours = {}, theirs = {};
    return fstat(descriptor_, &ours) == 0 && lstat(folder.c_str(), &theirs) == 0 &&
           ours.st_ino == theirs.st_ino && ours.st_dev == theirs.st_dev;
  }

  int descriptor_ = -1;
};

// Without the slash at the end, which would name a place inside it.
std::string plain_name(const std::string& folder) {
  const fs::path path = fs::path(folder).lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).string();
}

void clear(const std::string& folder) {
  for (const auto& entry : fs::directory_iterator(folder)) fs::remove_all(entry.path());
}

}  // namespace

void build_folder_atomically(const std::string& folder,
                             const std::function<void(const std::string& temporary)>& fill) {
  const std::string target = plain_name(folder);
  refuse_existing(target);
  const fs::path parent = fs::path(target).parent_path();
  if (!parent.empty()) make_folder(parent.string());
  const std::string temporary = target + ".pluvia-tmp";
  const FolderLock lock(temporary);
  try {
    clear(temporary);
    fill(temporary);
    if (const int error = lock.sync()) throw_cannot_create(temporary, error);
    if (rename(temporary.c_str(), target.c_str()) != 0) {
      const int error = errno;
      refuse_existing(target);
      throw_cannot_create(target, error);
    }
  } catch (...) {
    std::error_code ignored;
    fs::remove_all(temporary, ignored);
    throw;
  }
}

}  // namespace pluvia
