#include "raytrace/generate.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <map>
#include <random>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "atlas/streak_atlas.h"
#include "atlas/streak_database.h"
#include "tests/preset_files.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// All tracing happens in children: threads of the tracer do not survive a fork, and a child may be
// killed.
template <typename Action>
int status_of_child(Action action) {
  const pid_t child = fork();
  if (child == 0) {
    try {
      action();
    } catch (const std::exception& error) {
      fmt::print(stderr, "in the child: {}\n", error.what());
      _exit(99);
    }
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

struct Run {
  int threads = 1;
  long kill_at = -1;  // write point; -1: never
};

// Returns {traced, found} of a run that ended well; {-1, -1} of one that was killed.
std::pair<int, int> run_generate(const Preset& preset, const std::string& folder,
                                 const Run& run = {}) {
  const std::string tally = folder + ".tally";
  const int status = status_of_child([&] {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(run.threads));
    if (run.kill_at >= 0) {
      set_write_point_hook([&](long number) {
        if (number == run.kill_at) raise(SIGKILL);
      });
    }
    const GenerateSummary summary = generate_database(preset, folder);
    set_write_point_hook({});
    write_file_atomically(tally, fmt::format("{} {}", summary.traced, summary.found));
  });
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) return {-1, -1};
  EXPECT_EQ(status, 0) << "ended in another way";
  std::pair<int, int> counts;
  std::ifstream(tally) >> counts.first >> counts.second;
  fs::remove(tally);
  return counts;
}

// The message of a run that is refused.
std::string refusal_of_run(const Preset& preset, const std::string& folder,
                           long long file_size_limit = -1) {
  int ends[2];
  EXPECT_EQ(pipe(ends), 0);
  status_of_child([&] {
    if (file_size_limit >= 0) {
      const rlimit limit = {.rlim_cur = static_cast<rlim_t>(file_size_limit),
                            .rlim_max = static_cast<rlim_t>(file_size_limit)};
      setrlimit(RLIMIT_FSIZE, &limit);
    }
    std::string message;
    try {
      generate_database(preset, folder);
    } catch (const std::exception& error) {
      message = error.what();
    }
    if (write(ends[1], message.data(), message.size()) < 0) _exit(98);
  });
  close(ends[1]);
  std::string message(4096, '\0');
  message.resize(
      static_cast<std::size_t>(std::max<ssize_t>(0, read(ends[0], message.data(), 4096))));
  close(ends[0]);
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  return message;
}

// Every file but cost.json and what an interrupted write of it left, by name.
std::map<std::string, std::string> bytes_of(const std::string& folder) {
  std::map<std::string, std::string> bytes;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = fs::relative(entry.path(), folder).string();
    if (!entry.is_regular_file() || name.starts_with("cost.json")) continue;
    bytes[name] = read_file(entry.path().string());
  }
  return bytes;
}

void expect_same(const std::map<std::string, std::string>& ours,
                 const std::map<std::string, std::string>& theirs, const std::string& what) {
  for (const auto& [name, bytes] : theirs) {
    EXPECT_TRUE(ours.contains(name) && ours.at(name) == bytes) << name << ", " << what;
  }
  for (const auto& [name, bytes] : ours) EXPECT_TRUE(theirs.contains(name)) << name << ", " << what;
}

class Generate : public testing::Test {
 protected:
  const TemporaryFolder folder;
  const Preset preset = read_preset(write_preset(folder.path()));  // two shards
};

constexpr const char* rigid_shard = "shards/d3200_osc00_v+80.exr";

TEST_F(Generate, BytesDoNotDependOnThreads) {
  EXPECT_EQ(run_generate(preset, folder / "one", {.threads = 1}), std::pair(2, 0));
  EXPECT_EQ(run_generate(preset, folder / "two", {.threads = 2}), std::pair(2, 0));
  const auto bytes = bytes_of(folder / "one");
  EXPECT_EQ(bytes.size(), 3u);  // a manifest and two shards
  expect_same(bytes_of(folder / "two"), bytes, "two threads");
}

TEST_F(Generate, ManifestTellsWhatTheShardsAre) {
  run_generate(preset, folder / "db");
  const Manifest manifest = read_manifest(folder / "db");
  ASSERT_EQ(manifest.shards.size(), 2u);
  EXPECT_EQ(manifest.parameters, preset_parameters(preset));
  EXPECT_EQ(manifest.seed, preset.seed);
  EXPECT_EQ(manifest.instruction_set, instruction_set(best_isa()));
  EXPECT_NEAR(manifest.pixel_m, 1.6e-3 / 1.4, 1e-12);
  for (const ShardRecord& record : manifest.shards) {
    EXPECT_TRUE(shard_is_whole(folder / "db", record));
    const Shard shard = read_shard(folder / "db/" + record.file);
    EXPECT_EQ(record.images.size(), shard.lights.size() + 2);
    EXPECT_EQ(shard.lights, gn2006_light_directions());
    EXPECT_EQ(record.width_px, shard.width_px);
    EXPECT_EQ(record.height_px, shard.height_px);
    for (std::size_t k = 0; k < shard.light.size(); ++k) {
      EXPECT_EQ(record.estimated_relative_error[k], estimated_relative_error(shard.light[k]));
    }
  }
}

TEST_F(Generate, SecondRunTracesNothingAndChangesNothing) {
  run_generate(preset, folder / "db");
  const auto before = bytes_of(folder / "db");
  const std::string costs = read_file(folder / "db/cost.json");
  EXPECT_EQ(run_generate(preset, folder / "db"), std::pair(0, 2));
  expect_same(bytes_of(folder / "db"), before, "second run");
  EXPECT_EQ(read_file(folder / "db/cost.json"), costs);
}

TEST_F(Generate, RunKilledAtAnyWritePointResumesToTheSameBytes) {
  run_generate(preset, folder / "whole");
  const auto whole = bytes_of(folder / "whole");
  // A manifest, then two times shard, costs and manifest: seven files of five write points each.
  const long points = 7 * 5;
  for (long point = 0; point <= points; ++point) {
    const std::string db = folder / fmt::format("killed{}", point);
    const bool killed = run_generate(preset, db, {.kill_at = point}).first < 0;
    ASSERT_EQ(killed, point < points) << "write point " << point;
    // A shard is finished once its rename is done, at the last of its own five points.
    const int finished = point >= 24 ? 2 : point >= 9 ? 1 : 0;
    const auto [traced, found] = run_generate(preset, db);
    EXPECT_EQ(found, finished) << "write point " << point;
    EXPECT_EQ(traced, 2 - finished) << "write point " << point;
    expect_same(bytes_of(db), whole, fmt::format("killed at write point {}", point));
  }
}

TEST_F(Generate, RunKilledAgainAndAgainEndsWithTheSameBytes) {
  run_generate(preset, folder / "whole");
  const auto whole = bytes_of(folder / "whole");
  const unsigned seed = std::random_device()();
  std::mt19937 random(seed);
  for (int trial = 0; trial < 2; ++trial) {
    const std::string db = folder / fmt::format("killed{}", trial);
    std::string points;
    for (int kill = 0; kill < 6; ++kill) {
      const long point = std::uniform_int_distribution<long>(0, 20)(random);
      points += fmt::format("{} ", point);
      run_generate(preset, db, {.threads = 1 + kill % 2, .kill_at = point});
    }
    run_generate(preset, db);
    expect_same(bytes_of(db), whole, fmt::format("seed {}, killed at {}", seed, points));
  }
}

TEST_F(Generate, OtherParametersAreRefusedByNameAndNothingChanges) {
  run_generate(preset, folder / "db");
  const auto before = bytes_of(folder / "db");
  Preset other = preset;
  other.cone_half_angle_deg = 4;
  EXPECT_EQ(refusal_of_run(other, folder / "db"),
            (folder / "db") +
                "/manifest.json: cone_half_angle_deg 5.0; expected 4.0 as in the "
                "preset, or another --out folder");
  other = preset;
  other.seed = 8;
  EXPECT_THAT(refusal_of_run(other, folder / "db"), HasSubstr("seed 7; expected 8 as in"));
  other = preset;
  other.sets.pop_back();
  other.oscillations = {0};
  EXPECT_THAT(refusal_of_run(other, folder / "db"), HasSubstr("manifest.json: oscillation_sets "));
  expect_same(bytes_of(folder / "db"), before, "refused runs");
}

TEST_F(Generate, ParameterThatThePresetDoesNotKnowIsRefused) {
  run_generate(preset, folder / "db");
  Manifest manifest = read_manifest(folder / "db");
  manifest.parameters = replaced(manifest.parameters, "{\"base", "{\"wind_m_s\":3,\"base");
  write_manifest(folder / "db", manifest);
  EXPECT_THAT(refusal_of_run(preset, folder / "db"), HasSubstr("wind_m_s 3; expected absent"));
}

TEST_F(Generate, DamagedShardIsTracedAgain) {
  run_generate(preset, folder / "db");
  const auto whole = bytes_of(folder / "db");
  const std::string file = folder / "db/" + std::string(rigid_shard);
  const std::string bytes = read_file(file);
  std::string flipped = bytes;
  flipped[flipped.size() / 2] = static_cast<char>(flipped[flipped.size() / 2] ^ 4);
  // Readable, but not what was traced: another shard's pictures under this name.
  Shard dimmed = read_shard(file);
  for (float& value : dimmed.env.mean) value *= 0.5f;
  for (const std::string& damage : {std::string(), bytes.substr(0, 1000), flipped}) {
    write_file_atomically(file, damage);
    EXPECT_EQ(run_generate(preset, folder / "db"), std::pair(1, 1)) << damage.size() << " bytes";
    expect_same(bytes_of(folder / "db"), whole, "damaged shard");
  }
  write_shard(file, dimmed);
  EXPECT_EQ(run_generate(preset, folder / "db"), std::pair(1, 1)) << "readable, other values";
  expect_same(bytes_of(folder / "db"), whole, "other values");
  fs::remove(file);
  EXPECT_EQ(run_generate(preset, folder / "db"), std::pair(1, 1)) << "removed";
  expect_same(bytes_of(folder / "db"), whole, "removed shard");
}

TEST_F(Generate, ShardsWithoutAManifestAreNotTakenForThisPresets) {
  run_generate(preset, folder / "db");
  fs::remove(folder / "db/manifest.json");
  Preset other = preset;
  other.cone_half_angle_deg = 4;
  const auto before = bytes_of(folder / "db");
  EXPECT_THAT(refusal_of_run(other, folder / "db"),
              HasSubstr(".exr: a shard, but no " + (folder / "db/manifest.json")));
  expect_same(bytes_of(folder / "db"), before, "refused run");
}

TEST_F(Generate, DatabaseThatGrowsIsTheOneMadeAtOnce) {
  Preset first = preset, grown = preset;
  first.view_elevations_deg = {60};
  grown.view_elevations_deg = {60, 80};
  EXPECT_EQ(run_generate(first, folder / "grown"), std::pair(2, 0));
  EXPECT_EQ(run_generate(grown, folder / "grown"), std::pair(2, 2));
  grown.view_elevations_deg = {80, 60};
  grown.oscillations = {3, 0};
  EXPECT_EQ(run_generate(grown, folder / "at_once"), std::pair(4, 0));
  expect_same(bytes_of(folder / "grown"), bytes_of(folder / "at_once"), "grown");
  // A smaller request leaves the rest alone.
  EXPECT_EQ(run_generate(first, folder / "grown"), std::pair(0, 2));
  expect_same(bytes_of(folder / "grown"), bytes_of(folder / "at_once"), "asked for less");
}

TEST_F(Generate, FullDiskIsOneLineAndLeavesNoHalfWrittenFile) {
  run_generate(preset, folder / "whole");
  const auto whole = bytes_of(folder / "whole");
  // Enough for the manifest, too little for the shard; then too little for either.
  for (const long long limit : {20000LL, 500LL}) {
    const std::string db = folder / fmt::format("full{}", limit);
    EXPECT_THAT(refusal_of_run(preset, db, limit), HasSubstr(": cannot write: File too large"));
    for (const auto& entry : fs::recursive_directory_iterator(db)) {
      if (!entry.is_regular_file()) continue;
      EXPECT_EQ(entry.path().filename(), "manifest.json") << "limit " << limit;
      EXPECT_EQ(read_manifest(db).shards.size(), 0u);
    }
    run_generate(preset, db);  // with room again
    expect_same(bytes_of(db), whole, "after the disk was full");
  }
}

TEST_F(Generate, FoldersThatCannotBeAreRefused) {
  write_file_atomically(folder / "plain", "x");
  EXPECT_THAT(refusal_of_run(preset, folder / "plain"), HasSubstr("Not a directory"));
  EXPECT_THAT(refusal_of_run(preset, folder / "plain/below"), HasSubstr("Not a directory"));
  EXPECT_EQ(read_file(folder / "plain"), "x");
}

TEST_F(Generate, DamagedBooksAreRefusedWithFileAndPlace) {
  run_generate(preset, folder / "db");
  const std::string manifest = read_file(folder / "db/manifest.json");
  write_file_atomically(folder / "db/cost.json", "{\"version\": 1,\n \"shards\": [");
  EXPECT_THAT(refusal_of_run(preset, folder / "db"), HasSubstr("/cost.json:2:13: not JSON"));
  write_file_atomically(folder / "db/cost.json", "{\"version\": 1, \"shards\": 3}");
  EXPECT_THAT(refusal_of_run(preset, folder / "db"),
              HasSubstr("/cost.json: shards: not an object"));
  fs::remove(folder / "db/cost.json");
  write_file_atomically(folder / "db/manifest.json", manifest.substr(0, manifest.size() / 2));
  EXPECT_THAT(refusal_of_run(preset, folder / "db"), HasSubstr("/manifest.json:"));
  EXPECT_EQ(read_file(folder / "db/manifest.json"), manifest.substr(0, manifest.size() / 2));
}

TEST_F(Generate, OscillationThatThePresetLacksLeavesNothingBehind) {
  Preset other = preset;
  other.oscillations = {0, 4};
  EXPECT_THAT(refusal_of_run(other, folder / "db"), HasSubstr("oscillation 4; expected one of"));
  EXPECT_FALSE(fs::exists(folder / "db"));
}

TEST_F(Generate, ManifestWithoutShardsCannotBePacked) {
  run_generate(preset, folder / "db", {.kill_at = 7});
  ASSERT_EQ(read_manifest(folder / "db").shards.size(), 0u);
  EXPECT_THAT(message_of([&] { pack_database(folder / "db"); }),
              HasSubstr("manifest.json: no shards; expected at least one"));
}

}  // namespace
}  // namespace pluvia
