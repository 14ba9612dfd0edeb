#include "raytrace/generate.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>

#include "atlas/atomic_file.h"
#include "atlas/shard_costs.h"
#include "raytrace/process_time.h"
#include "raytrace/streak_accuracy.h"

namespace pluvia {

namespace {

namespace fs = std::filesystem;

// A database may grow: the sizes of earlier runs stay.
void add_sizes(Manifest& manifest, const Preset& preset) {
  for (const int diameter_um : diameters_of(preset)) {
    const auto place =
        std::lower_bound(manifest.sizes.begin(), manifest.sizes.end(), diameter_um,
                         [](const SizeRecord& size, int d) { return size.diameter_um < d; });
    if (place != manifest.sizes.end() && place->diameter_um == diameter_um) continue;
    manifest.sizes.insert(place, size_of(preset, diameter_um));
  }
}

Manifest empty_manifest(const Preset& preset) {
  Manifest manifest;
  manifest.preset = preset.name;
  manifest.parameters = preset_parameters(preset);
  manifest.seed = preset.seed;
  manifest.instruction_set = instruction_set(preset.field.isa);
  manifest.exposure_s = preset.exposure_s;
  if (preset.physical) {
    manifest.bands = bands_of(preset);
    add_sizes(manifest, preset);
    return manifest;
  }
  manifest.mean_radius_m = preset.mean_radius_m;
  manifest.fall_speed_m_s = preset.fall_speed_m_s;
  manifest.pixel_m = gn2006_frame(preset, 0).pixel_m;
  return manifest;
}

// Shards that no manifest vouches for may be of any parameters, and would be taken for this
// preset's.
void refuse_stray_shards(const std::string& folder) {
  for (const auto& entry : fs::directory_iterator(folder + "/shards")) {
    if (entry.path().extension() != ".exr") continue;
    throw std::runtime_error(fmt::format(
        "{}: a shard, but no {}/manifest.json that tells its parameters; expected the manifest, or "
        "another --out folder",
        entry.path().string(), folder));
  }
}

void refuse_other_database(const std::string& folder, const Manifest& there, const Manifest& here) {
  const auto difference = first_difference(there, here);
  if (!difference) return;
  throw std::runtime_error(
      fmt::format("{}/manifest.json: {} {}; expected {} as in the preset, or another --out folder",
                  folder, difference->what, difference->found, difference->expected));
}

// The folder's own manifest where there is one, an empty one else.
Manifest open_database(const Preset& preset, const std::string& folder,
                       const std::vector<ShardKey>& keys) {
  Manifest fresh = empty_manifest(preset);
  for (const ShardKey& key : keys) fresh.planned.insert(shard_name(key));
  if (fs::exists(folder + "/manifest.json")) {
    Manifest manifest = read_manifest(folder);
    refuse_other_database(folder, manifest, fresh);
    if (preset.physical) add_sizes(manifest, preset);
    make_folder(folder + "/shards");
    const std::size_t planned = manifest.planned.size();
    manifest.planned.insert(fresh.planned.begin(), fresh.planned.end());
    if (manifest.planned.size() > planned) write_manifest(folder, manifest);
    return manifest;
  }
  make_folder(folder + "/shards");
  refuse_stray_shards(folder);
  write_manifest(folder, fresh);
  return fresh;
}

void append_band(StreakImage& image, StreakImage band) {
  if (image.mean.empty()) {
    image = std::move(band);
    return;
  }
  image.mean.insert(image.mean.end(), band.mean.begin(), band.mean.end());
  image.variance.insert(image.variance.end(), band.variance.begin(), band.variance.end());
}

TracedStreak trace_band(const Preset& preset, const ShardKey& key, const StreakRequest& request,
                        const std::function<void(double)>& progress) {
  if (preset.target_error <= 0) return trace_streak(request, progress);
  try {
    return trace_streak_to(request, preset.target_error, progress).streak;
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(shard_name(key) + ": " + error.what());
  }
}

// One tracing for each band; where the drop is does not depend on the band.
Shard trace_shard(const Preset& preset, const ShardKey& key,
                  const std::function<void(double)>& progress) {
  const std::vector<Band> bands = bands_of(preset);
  Shard shard = {.key = key, .bands = {}, .lights = preset.lights};
  shard.light.resize(shard.lights.size());
  for (std::size_t k = 0; k < bands.size(); ++k) {
    const StreakRequest request = shard_request(preset, key, static_cast<int>(k));
    TracedStreak streak = trace_band(preset, key, request, [&](double share) {
      progress((static_cast<double>(k) + share) / static_cast<double>(bands.size()));
    });
    shard.width_px = request.frame.width_px;
    shard.height_px = request.frame.height_px;
    shard.bands.push_back(bands[k].name);
    for (std::size_t i = 0; i < shard.light.size(); ++i) {
      append_band(shard.light[i], std::move(streak.light[i]));
    }
    append_band(shard.env, std::move(streak.env));
    shard.transfer.resize(streak.transfer.size());
    for (std::size_t i = 0; i < shard.transfer.size(); ++i) {
      append_band(shard.transfer[i], std::move(streak.transfer[i]));
    }
    if (k == 0) shard.coverage = std::move(streak.coverage);
  }
  return shard;
}

void put_record(Manifest& manifest, const ShardRecord& record) {
  std::erase_if(manifest.shards, [&](const ShardRecord& r) { return r.key == record.key; });
  manifest.shards.insert(std::upper_bound(manifest.shards.begin(), manifest.shards.end(), record,
                                          [](const ShardRecord& a, const ShardRecord& b) {
                                            return comes_before(a.key, b.key);
                                          }),
                         record);
}

std::vector<ShardKey> keys_of(const Preset& preset) {
  std::vector<ShardKey> keys;
  for (const int diameter_um : diameters_of(preset)) {
    for (const int oscillation : preset.oscillations) {
      set_of(preset, oscillation);  // refuses, before anything is written
      for (const int view : preset.view_elevations_deg) {
        keys.push_back({diameter_um, oscillation, view});
      }
    }
  }
  std::sort(keys.begin(), keys.end(), comes_before);
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

// Dealt in turn: neighbours of one oscillation cost alike, and a rigid drop costs little.
std::vector<ShardKey> share_of(const std::vector<ShardKey>& keys, const ShardShare& share) {
  std::vector<ShardKey> own;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (i % static_cast<std::size_t>(share.count) == static_cast<std::size_t>(share.index - 1)) {
      own.push_back(keys[i]);
    }
  }
  return own;
}

// The record of a shard that an earlier run finished; nothing where it is missing or damaged.
std::optional<ShardRecord> find_finished(const Preset& preset, const Manifest& manifest,
                                         const std::string& folder, const ShardKey& key) {
  for (const ShardRecord& record : manifest.shards) {
    if (record.key != key) continue;
    if (shard_is_whole(folder, record)) return record;
    return std::nullopt;  // other bytes than were traced, readable or not
  }
  // Written, and the run killed before the manifest told of it.
  const std::string file = folder + "/shards/" + shard_name(key) + ".exr";
  if (!fs::exists(file)) return std::nullopt;
  const StreakFrame frame = shard_frame(preset, key);
  try {
    const Shard shard = read_shard(file);
    if (shard.width_px != frame.width_px || shard.height_px != frame.height_px) return std::nullopt;
    if (shard.lights != preset.lights) return std::nullopt;
    return make_record(shard, frame, sha256(read_file(file)));
  } catch (const std::runtime_error&) {
    return std::nullopt;  // damaged since: traced again
  }
}

}  // namespace

GenerateSummary generate_database(const Preset& preset, const std::string& folder,
                                  const Progress& progress, const ShardShare& share) {
  GenerateSummary summary;
  const std::vector<ShardKey> all = keys_of(preset);
  const std::vector<ShardKey> keys = share_of(all, share);
  Manifest manifest = open_database(preset, folder, all);
  ShardCosts costs = read_costs(folder);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const auto report = [&](double done) {
      if (!progress) return;
      progress(shard_name(keys[i]),
               (static_cast<double>(i) + done) / static_cast<double>(keys.size()));
    };
    if (const auto record = find_finished(preset, manifest, folder, keys[i])) {
      put_record(manifest, *record);
      ++summary.found;
    } else {
      const double start_s = process_cpu_s();
      const Shard shard = trace_shard(preset, keys[i], report);
      const std::string file = "shards/" + shard_name(keys[i]) + ".exr";
      const std::string sha = write_shard(folder + "/" + file, shard);
      put_record(manifest, make_record(shard, shard_frame(preset, keys[i]), sha));
      const double cpu_s = process_cpu_s() - start_s;
      summary.cpu_s += cpu_s;
      costs[shard_name(keys[i])] = cpu_s;
      write_costs(folder, costs);
      ++summary.traced;
    }
    write_manifest(folder, manifest);
    report(1);
  }
  return summary;
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
    record.images.push_back(light_name(shard.lights[k]));
    record.estimated_relative_error.push_back(estimated_relative_error(shard.light[k]));
  }
  if (!shard.env.mean.empty()) {
    record.images.push_back("env");
    record.estimated_relative_error.push_back(estimated_relative_error(shard.env));
  }
  for (std::size_t k = 0; k < shard.transfer.size(); ++k) {
    record.images.push_back(transfer_name(k));
    record.estimated_relative_error.push_back(estimated_relative_error(shard.transfer[k]));
  }
  record.images.push_back("coverage");
  record.estimated_relative_error.push_back(estimated_relative_error(shard.coverage));
  return record;
}

std::string instruction_set(Isa isa) {
  return isa_name(isa) + (__builtin_cpu_supports("fma") ? ", libm with fma" : ", libm without fma");
}

}  // namespace pluvia
