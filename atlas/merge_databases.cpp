#include "atlas/merge_databases.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include <fmt/format.h>

#include "atlas/atomic_file.h"
#include "atlas/atomic_folder.h"
#include "atlas/shard_costs.h"
#include "atlas/streak_database.h"

namespace pluvia {
namespace {

struct Merged {
  Manifest manifest = {};
  std::vector<std::string> folders = {};  // of each of the manifest's shards
  ShardCosts costs = {};
};

void refuse_mixed(const std::string& folder, const Manifest& found, const std::string& first,
                  const Manifest& expected) {
  const auto difference = first_difference(found, expected);
  if (!difference) return;
  throw std::runtime_error(fmt::format("{}/manifest.json: {} {}; expected {} as in {}", folder,
                                       difference->what, difference->found, difference->expected,
                                       first));
}

std::string file_of(const ShardKey& key) {
  return "shards/" + shard_name(key) + ".exr";
}

bool same_record(const ShardRecord& a, const ShardRecord& b) {
  return a.sha256 == b.sha256 && a.width_px == b.width_px && a.height_px == b.height_px &&
         a.path_top_row == b.path_top_row && a.path_bottom_row == b.path_bottom_row &&
         a.images == b.images && a.estimated_relative_error == b.estimated_relative_error;
}

void add_record(Merged& merged, const std::string& folder, const ShardRecord& record) {
  if (record.file != file_of(record.key)) {
    throw std::runtime_error(fmt::format("{}/manifest.json: file \"{}\"; expected \"{}\"", folder,
                                         record.file, file_of(record.key)));
  }
  auto& shards = merged.manifest.shards;
  const auto at = std::lower_bound(
      shards.begin(), shards.end(), record,
      [](const ShardRecord& a, const ShardRecord& b) { return comes_before(a.key, b.key); });
  const auto place = at - shards.begin();
  if (at == shards.end() || at->key != record.key) {
    shards.insert(at, record);
    merged.folders.insert(merged.folders.begin() + place, folder);
    return;
  }
  if (!same_record(*at, record)) {
    throw std::runtime_error(fmt::format(
        "{}/manifest.json: shard {}: another than in {}; expected the same bytes of the same shard",
        folder, shard_name(record.key), merged.folders[static_cast<std::size_t>(place)]));
  }
  whole_shard_bytes(folder, record);  // a damaged copy is refused, though the other one is taken
}

void add_sizes(Manifest& merged, const Manifest& manifest) {
  for (const SizeRecord& size : manifest.sizes) {
    const auto at = std::lower_bound(
        merged.sizes.begin(), merged.sizes.end(), size,
        [](const SizeRecord& a, const SizeRecord& b) { return a.diameter_um < b.diameter_um; });
    if (at == merged.sizes.end() || at->diameter_um != size.diameter_um) {
      merged.sizes.insert(at, size);
    }
  }
}

Merged merged_books(const std::vector<std::string>& folders) {
  if (folders.empty()) throw std::runtime_error("no databases; expected at least one folder");
  Merged merged = {.manifest = read_manifest(folders.front())};
  merged.manifest.shards.clear();
  for (const std::string& folder : folders) {
    const Manifest manifest = read_manifest(folder);
    refuse_mixed(folder, manifest, folders.front(), merged.manifest);
    add_sizes(merged.manifest, manifest);
    merged.manifest.planned.insert(manifest.planned.begin(), manifest.planned.end());
    for (const ShardRecord& record : manifest.shards) add_record(merged, folder, record);
    for (const auto& cost : read_costs(folder)) merged.costs.insert(cost);
  }
  return merged;
}

std::vector<std::string> missing_shards(const Manifest& manifest) {
  std::set<std::string> missing = manifest.planned;
  for (const ShardRecord& record : manifest.shards) missing.erase(shard_name(record.key));
  return {missing.begin(), missing.end()};
}

}  // namespace

MergeSummary merge_databases(const std::vector<std::string>& folders, const std::string& out,
                             bool partial) {
  const Merged merged = merged_books(folders);
  const std::vector<std::string> missing = missing_shards(merged.manifest);
  if (!missing.empty() && !partial) {
    throw std::runtime_error(fmt::format(
        "{}: {} of {} planned shards are in none of the folders: {}; expected all of them. run "
        "`pluvia generate` for them, or merge with --partial",
        out, missing.size(), merged.manifest.planned.size(), fmt::join(missing, ", ")));
  }
  build_folder_atomically(out, [&](const std::string& temporary) {
    make_folder(temporary + "/shards");
    for (std::size_t i = 0; i < merged.folders.size(); ++i) {
      const ShardRecord& record = merged.manifest.shards[i];
      write_file_plainly(temporary + "/" + record.file,
                         whole_shard_bytes(merged.folders[i], record));
    }
    write_manifest(temporary, merged.manifest);
    if (!merged.costs.empty()) write_costs(temporary, merged.costs);
  });
  return {.shards = static_cast<int>(merged.manifest.shards.size()),
          .missing = static_cast<int>(missing.size())};
}

}  // namespace pluvia
