#include "raytrace/generate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "atlas/atomic_file.h"

namespace pluvia {

namespace {

namespace fs = std::filesystem;

double process_cpu_s() {
  timespec now = {};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Sort order of the manifest.
bool before(const ShardRecord& a, const ShardRecord& b) {
  const auto key = [](const ShardRecord& r) {
    return std::array{r.key.diameter_um, r.key.oscillation, r.key.view_elevation_deg};
  };
  return key(a) < key(b);
}

Manifest empty_manifest(const Preset& preset) {
  Manifest manifest;
  manifest.preset = preset.name;
  manifest.parameters = preset_parameters(preset);
  manifest.seed = preset.seed;
  manifest.instruction_set = instruction_set();
  manifest.mean_radius_m = preset.mean_radius_m;
  manifest.exposure_s = preset.exposure_s;
  manifest.fall_speed_m_s = preset.fall_speed_m_s;
  manifest.pixel_m = gn2006_frame(preset, 0).pixel_m;
  return manifest;
}

// The folder's own manifest where there is one, an empty one else.
Manifest open_database(const Preset& preset, const std::string& folder) {
  const Manifest fresh = empty_manifest(preset);
  make_folder(folder + "/shards");
  if (!fs::exists(folder + "/manifest.json")) {
    write_manifest(folder, fresh);
    return fresh;
  }
  Manifest manifest = read_manifest(folder);
  const auto differs = [&](const std::string& what, const std::string& there,
                           const std::string& here) {
    if (there == here) return;
    throw std::runtime_error(fmt::format(
        "{}/manifest.json: {} {}; expected {} as in the preset, or another --out folder", folder,
        what, there, here));
  };
  const auto there = nlohmann::json::parse(manifest.parameters);
  const auto here = nlohmann::json::parse(fresh.parameters);
  for (const auto& [key, value] : here.items()) {
    differs(key, there.contains(key) ? there[key].dump() : "absent", value.dump());
  }
  differs("seed", std::to_string(manifest.seed), std::to_string(fresh.seed));
  differs("instruction_set", manifest.instruction_set, fresh.instruction_set);
  return manifest;
}

ShardRecord make_record(const Shard& shard, const StreakFrame& frame, const std::string& sha) {
  ShardRecord record;
  record.key = shard.key;
  record.file = "shards/" + shard_name(shard.key) + ".exr";
  record.sha256 = sha;
  record.width_px = shard.width_px;
  record.height_px = shard.height_px;
  record.path_top_row = frame.path_top_row;
  record.path_bottom_row = frame.path_top_row + frame.path_rows;
  for (std::size_t k = 0; k < shard.lights.size(); ++k) {
    record.images.push_back(fmt::format("light_v{:+03d}_h{:03d}", shard.lights[k].elevation_deg,
                                        shard.lights[k].azimuth_deg));
    record.estimated_relative_error.push_back(estimated_relative_error(shard.light[k]));
  }
  record.images.insert(record.images.end(), {"env", "coverage"});
  record.estimated_relative_error.push_back(estimated_relative_error(shard.env));
  record.estimated_relative_error.push_back(estimated_relative_error(shard.coverage));
  return record;
}

Shard trace_shard(const Preset& preset, const ShardKey& key,
                  const std::function<void(double)>& progress) {
  const StreakRequest request = shard_request(preset, key);
  TracedStreak streak = trace_streak(request, progress);
  Shard shard;
  shard.key = key;
  shard.width_px = request.frame.width_px;
  shard.height_px = request.frame.height_px;
  shard.lights = request.lights;
  shard.light = std::move(streak.light);
  shard.env = std::move(streak.env);
  shard.coverage = std::move(streak.coverage);
  return shard;
}

void put_record(Manifest& manifest, const ShardRecord& record) {
  std::erase_if(manifest.shards, [&](const ShardRecord& r) { return r.key == record.key; });
  manifest.shards.insert(
      std::upper_bound(manifest.shards.begin(), manifest.shards.end(), record, before), record);
}

// CPU seconds per shard; kept from earlier runs, since their shards are.
struct CostFile {
  std::string file;
  nlohmann::json costs = {{"version", 1}, {"shards", nlohmann::json::object()}};

  explicit CostFile(const std::string& folder) : file(folder + "/cost.json") {
    if (!fs::exists(file)) return;
    const auto found = nlohmann::json::parse(read_file(file), nullptr, false);
    if (found.is_object() && found.contains("shards") && found["shards"].is_object()) {
      costs = found;
    }
  }
  void put(const ShardKey& key, double cpu_s) {
    costs["shards"][shard_name(key)] = {{"cpu_s", cpu_s}};
    write_file_atomically(file, costs.dump(2) + "\n");
  }
};

std::vector<ShardKey> keys_of(const Preset& preset) {
  std::vector<ShardKey> keys;
  const int diameter_um = static_cast<int>(std::lround(2e6 * preset.mean_radius_m));
  for (const int oscillation : preset.oscillations) {
    for (const int view : preset.view_elevations_deg) {
      keys.push_back({diameter_um, oscillation, view});
    }
  }
  return keys;
}

// The record of a shard that an earlier run finished; nothing where the file is missing or damaged.
std::optional<ShardRecord> find_finished(const Preset& preset, const Manifest& manifest,
                                         const std::string& folder, const ShardKey& key) {
  for (const ShardRecord& record : manifest.shards) {
    if (record.key == key && shard_is_whole(folder, record)) return record;
  }
  const std::string file = folder + "/shards/" + shard_name(key) + ".exr";
  if (!fs::exists(file)) return std::nullopt;
  try {
    const Shard shard = read_shard(file);
    return make_record(shard, gn2006_frame(preset, key.view_elevation_deg),
                       sha256(read_file(file)));
  } catch (const std::runtime_error&) {
    return std::nullopt;  // damaged after it was written: traced again
  }
}

}  // namespace

GenerateSummary generate_database(const Preset& preset, const std::string& folder,
                                  const Progress& progress) {
  GenerateSummary summary;
  Manifest manifest = open_database(preset, folder);
  CostFile costs(folder);
  const std::vector<ShardKey> keys = keys_of(preset);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const auto report = [&](double share) {
      if (!progress) return;
      progress(shard_name(keys[i]),
               (static_cast<double>(i) + share) / static_cast<double>(keys.size()));
    };
    if (const auto record = find_finished(preset, manifest, folder, keys[i])) {
      put_record(manifest, *record);
      ++summary.found;
    } else {
      const double start_s = process_cpu_s();
      const Shard shard = trace_shard(preset, keys[i], report);
      const std::string file = "shards/" + shard_name(keys[i]) + ".exr";
      const std::string sha = write_shard(folder + "/" + file, shard);
      put_record(manifest,
                 make_record(shard, gn2006_frame(preset, keys[i].view_elevation_deg), sha));
      const double cpu_s = process_cpu_s() - start_s;
      summary.cpu_s += cpu_s;
      costs.put(keys[i], cpu_s);
      ++summary.traced;
    }
    write_manifest(folder, manifest);
    report(1);
  }
  return summary;
}

std::string instruction_set() {
  return __builtin_cpu_supports("fma") ? "x86-64, libm with fma" : "x86-64";
}

}  // namespace pluvia
