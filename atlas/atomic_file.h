// Files that exist whole or not at all: bytes go to "FILE.tmp" beside the target, are synced, then
// renamed over it. A crash leaves either the old state or the new one, and at most a stale .tmp
// that the next write of the same file replaces.
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace pluvia {

// Throws std::runtime_error "FILE: cannot write: REASON; expected ..." (no permission, disk full,
// parent missing or not a directory); the .tmp file is then removed.
void write_file_atomically(const std::string& file, std::string_view bytes);

// Neither atomic nor synced: for the files inside a folder that is (atlas/atomic_folder.h). Throws
// as above.
void write_file_plainly(const std::string& file, std::string_view bytes);

// The whole file. Throws std::runtime_error "FILE: cannot read: REASON; expected a readable file".
std::string read_file(const std::string& file);

// Creates the folder and its parents. Throws std::runtime_error "DIR: cannot create: REASON; ...".
void make_folder(const std::string& folder);

// Hexadecimal SHA-256 of bytes.
std::string sha256(std::string_view bytes);

// A write point is a place where a crash would show a distinct state on disk (before the temporary
// file, in the middle of it, before the sync, before the rename, after it). Tests count them and
// kill the process at one: the hook gets the running number, from 0. Empty: no hook.
void set_write_point_hook(std::function<void(long)> hook);

}  // namespace pluvia
