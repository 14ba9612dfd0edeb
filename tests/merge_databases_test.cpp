#include "atlas/merge_databases.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "atlas/shard_costs.h"
#include "tests/sample_database.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// A whole database in "whole" and the same dealt over "a" and "b", with costs.
class Merge : public testing::Test {
 protected:
  void SetUp() override {
    manifest = write_database(folder / "whole", sample);
    for (const ShardRecord& record : manifest.shards) {
      manifest.planned.insert(shard_name(record.key));
    }
    write_manifest(folder / "whole", manifest);
    for (const int part : {0, 1}) deal(part);
  }
  std::string part_folder(int part) const { return folder / std::string(part == 0 ? "a" : "b"); }
  void deal(int part) const {
    Manifest own = manifest;
    own.shards.clear();
    ShardCosts costs;
    make_folder(part_folder(part) + "/shards");
    for (std::size_t i = static_cast<std::size_t>(part); i < manifest.shards.size(); i += 2) {
      const ShardRecord& record = manifest.shards[i];
      own.shards.push_back(record);
      fs::copy(folder / ("whole/" + record.file), part_folder(part) + "/" + record.file);
      costs[shard_name(record.key)] = 1.5 + static_cast<double>(i);
    }
    write_manifest(part_folder(part), own);
    write_costs(part_folder(part), costs);
  }
  // The message of a merge of both, which must leave nothing.
  std::string refusal() const {
    const std::string message = message_of([&] {
      merge_databases({folder / "a", folder / "b"}, folder / "out");
    });
    EXPECT_FALSE(fs::exists(folder / "out"));
    EXPECT_FALSE(fs::exists(folder / "out.pluvia-tmp"));
    return message;
  }
  template <typename Change>
  std::string refusal_with(Change change) const {
    const Manifest before = read_manifest(folder / "b");
    Manifest other = before;
    change(other);
    write_manifest(folder / "b", other);
    const std::string message = refusal();
    write_manifest(folder / "b", before);
    return message;
  }
  void expect_whole(const std::string& merged) const {
    EXPECT_EQ(read_file(merged + "/manifest.json"), read_file(folder / "whole/manifest.json"));
    for (const ShardRecord& record : manifest.shards) {
      EXPECT_EQ(read_file(merged + "/" + record.file), read_file(folder / "whole/" + record.file));
    }
  }

  const Sample sample = {.oscillations = {0, 2, 3}, .lights = {{10, 10}}};
  const TemporaryFolder folder;
  Manifest manifest = {};  // 9 shards
};

TEST_F(Merge, PartsMakeTheWholeByteForByteInAnyOrder) {
  EXPECT_EQ(merge_databases({folder / "a", folder / "b"}, folder / "ab").shards, 9);
  expect_whole(folder / "ab");
  merge_databases({folder / "b", folder / "a"}, folder / "ba");
  expect_whole(folder / "ba");
  const ShardCosts costs = read_costs(folder / "ab");
  EXPECT_EQ(costs.size(), 9u);
  EXPECT_EQ(costs.at(shard_name(manifest.shards[3].key)), 4.5);
}

TEST_F(Merge, ShardsThatSeveralHoldAreTakenOnce) {
  EXPECT_EQ(merge_databases({folder / "a", folder / "whole", folder / "b"}, folder / "out").shards,
            9);
  expect_whole(folder / "out");
}

TEST_F(Merge, OtherParametersAreRefusedByName) {
  const std::string first = " as in " + (folder / "a");
  EXPECT_EQ(refusal_with([](Manifest& m) { m.parameters = R"({"cone":4})"; }),
            (folder / "b") + "/manifest.json: cone 4; expected absent" + first);
  EXPECT_THAT(refusal_with([](Manifest& m) { m.preset = "other"; }),
              HasSubstr("preset other; expected test" + first));
  EXPECT_THAT(refusal_with([](Manifest& m) { m.seed = 2; }), HasSubstr("seed 2; expected 1"));
  EXPECT_THAT(refusal_with([](Manifest& m) { m.instruction_set = "avx9"; }),
              HasSubstr("instruction_set avx9; expected generic"));
  EXPECT_THAT(refusal_with([](Manifest& m) { m.pixel_m = 1; }), HasSubstr("pixel_m 1; expected "));
}

TEST_F(Merge, DamagedAndMissingFilesAreRefusedByName) {
  const std::string file = folder / "b/" + read_manifest(folder / "b").shards[1].file;
  const std::string bytes = read_file(file);
  std::string flipped = bytes;
  flipped[flipped.size() / 2] = static_cast<char>(flipped[flipped.size() / 2] ^ 1);
  for (const std::string& damage : {std::string(), bytes.substr(0, 99), flipped}) {
    write_file_plainly(file, damage);
    EXPECT_THAT(refusal(), HasSubstr(file + ": SHA-256 is not the manifest's; expected "));
  }
  fs::remove(file);
  EXPECT_THAT(refusal(), HasSubstr(file + ": missing; expected the shard"));
  EXPECT_THAT(message_of([&] {
                merge_databases({folder / "whole", folder / "b"}, folder / "out");
              }),
              HasSubstr(file + ": missing; expected the shard"))
      << "though the other folder has it";
}

TEST_F(Merge, PlannedShardsThatNobodyTracedAreRefusedUnlessAskedFor) {
  const std::string last = shard_name(read_manifest(folder / "b").shards.back().key);
  EXPECT_THAT(
      refusal_with([](Manifest& m) { m.shards.pop_back(); }),
      HasSubstr("1 of 9 planned shards are in none of the folders: " + last + "; expected"));
  const auto summary = merge_databases({folder / "a"}, folder / "half", true);
  EXPECT_EQ(summary.shards, 5);
  EXPECT_EQ(summary.missing, 4);
  // Half of it, merged with the other half, is the whole.
  merge_databases({folder / "half", folder / "b"}, folder / "out");
  expect_whole(folder / "out");
}

TEST_F(Merge, OtherVersionOfTheSameShardIsRefused) {
  const ShardRecord record = manifest.shards.front();  // a's
  Shard other = read_shard(folder / "whole/" + record.file);
  other.env.mean[0] += 1;
  EXPECT_THAT(
      refusal_with([&](Manifest& m) {
        m.shards.insert(m.shards.begin(), write_and_record(folder / "b", other));
      }),
      HasSubstr("b/manifest.json: shard d3200_osc00_v-20: another than in " + (folder / "a")));
}

TEST_F(Merge, FilesOutsideTheFolderAreNotFollowed) {
  EXPECT_THAT(refusal_with([](Manifest& m) { m.shards[0].file = "../a/" + m.shards[0].file; }),
              HasSubstr("file \"../a/shards/d3200_osc00_v+00.exr\"; expected \"shards/"));
}

TEST_F(Merge, FoldersThatAreNoDatabasesAreRefused) {
  EXPECT_THAT(message_of([&] { merge_databases({}, folder / "out"); }),
              HasSubstr("expected at least one folder"));
  EXPECT_THAT(message_of([&] { merge_databases({folder / "none"}, folder / "out"); }),
              HasSubstr("none/manifest.json: cannot read"));
  EXPECT_THAT(message_of([&] { merge_databases({folder / "whole"}, folder / "a"); }),
              HasSubstr("/a: is there already"));
  write_file_plainly(folder / "b/cost.json", R"({"version":1,"shards":{"x":{}}})");
  EXPECT_THAT(refusal(), HasSubstr("b/cost.json: shards.x.cpu_s: missing"));
}

}  // namespace
}  // namespace pluvia
