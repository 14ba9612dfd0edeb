// Several databases of the same parameters made into one: what `pluvia generate --shard i/n` traced
// in n folders, put together.
#pragma once

#include <string>
#include <vector>

namespace pluvia {

struct MergeSummary {
  int shards = 0;
  int missing = 0;  // planned, and in none of the folders; only where `partial`
};

// Writes OUT, whole or not at all (atlas/atomic_folder.h): shards and manifest byte for byte those
// of a single run, cost.json with the seconds of all. A shard may be in several folders with the
// same bytes. Throws std::runtime_error where the folders' manifests differ in how shards are made
// (the key and both values are named), a listed shard is missing, damaged or in two versions, no
// folder is given, or, unless `partial`, a planned shard is in none of the folders.
MergeSummary merge_databases(const std::vector<std::string>& folders, const std::string& out,
                             bool partial = false);

}  // namespace pluvia
