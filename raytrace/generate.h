// The database from a preset, shard by shard: what is finished is kept, whatever happens in
// between.
#pragma once

#include <functional>
#include <string>

#include "raytrace/preset.h"

namespace pluvia {

// Called with what is being done and the share of the whole, 0 .. 1, from one thread at a time.
using Progress = std::function<void(const std::string& what, double share)>;

struct GenerateSummary {
  int traced = 0;  // shards
  int found = 0;   // .. that were there already
  double cpu_s = 0;
};

// The share of one of `count` workers, each with a folder of its own (atlas/merge_databases.h):
// shards number index, index + count, .. of all that the preset asks for, in the manifest's order.
// More workers than shards are no error: some have nothing to do.
struct ShardShare {
  int index = 1;  // 1 .. count
  int count = 1;
};

// Writes FOLDER/shards/*.exr, FOLDER/manifest.json and FOLDER/cost.json (atlas/streak_database.h).
// The manifest, with all parameters and no shard yet, is written first and after every shard, so
// that a killed run resumes: a whole shard in the folder was made with the manifest's parameters.
// Final bytes of shards and manifest do not depend on interruptions or on threads. Throws
// std::runtime_error when the preset's target_error is not kept, when the folder holds a database of other parameters, shards without a
// manifest or a damaged cost.json, or cannot be written; std::invalid_argument for an oscillation
// that is none of the preset's sets. The manifest tells what the whole preset asks for, whatever
// the share; one run at a time may write a folder.
GenerateSummary generate_database(const Preset& preset, const std::string& folder,
                                  const Progress& progress = {}, const ShardShare& share = {});

// What the manifest tells of a shard whose picture is `frame` and whose file hashes to `sha`.
ShardRecord make_record(const Shard& shard, const StreakFrame& frame, const std::string& sha);

// The set that paths are traced with and the flavour of the C library's sine, which decide the last
// bits: "avx512, libm with fma".
std::string instruction_set(Isa isa);

}  // namespace pluvia
