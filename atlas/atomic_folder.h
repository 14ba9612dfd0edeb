// Folders that exist whole or not at all: everything is written below "FOLDER.pluvia-tmp" beside
// the target, synced once, then renamed. A crash leaves at most a stale FOLDER.pluvia-tmp, which
// the next run with the same target clears and uses.
#pragma once

#include <functional>
#include <string>

namespace pluvia {

// Calls fill(TEMPORARY) with an empty folder, in which it writes by full path. Parents of FOLDER
// are made. Throws std::runtime_error "FOLDER: is there already; expected .." (also when it appears
// meanwhile, unless it is an empty folder, which is replaced), "FOLDER: cannot create: REASON; ..",
// and, where the file system has locks, "TEMPORARY: another run is writing it; ..". Whatever `fill`
// throws is passed on, and TEMPORARY removed.
void build_folder_atomically(const std::string& folder,
                             const std::function<void(const std::string& temporary)>& fill);

}  // namespace pluvia
