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
#include "atlas/json_place.h"

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
  manifest.instruction_set = instruction_set();
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
  const auto differs = [&](const std::string& what, const std::string& found,
                           const std::string& expected) {
    if (found == expected) return;
    throw std::runtime_error(fmt::format(
        "{}/manifest.json: {} {}; expected {} as in the preset, or another --out folder", folder,
        what, found, expected));
  };
  differs("preset", there.preset, here.preset);
  const auto found = nlohmann::json::parse(there.parameters);
  const auto expected = nlohmann::json::parse(here.parameters);
  const auto text = [](const nlohmann::json& object, const std::string& key) {
    return object.contains(key) ? object[key].dump() : "absent";
  };
  for (const auto& item : expected.items()) {
    differs(item.key(), text(found, item.key()), item.value().dump());
  }
  for (const auto& item : found.items()) {
    differs(item.key(), item.value().dump(), text(expected, item.key()));
  }
  differs("seed", std::to_string(there.seed), std::to_string(here.seed));
  differs("instruction_set", there.instruction_set, here.instruction_set);
}

// The folder's own manifest where there is one, an empty one else.
Manifest open_database(const Preset& preset, const std::string& folder) {
  const Manifest fresh = empty_manifest(preset);
  if (fs::exists(folder + "/manifest.json")) {
    Manifest manifest = read_manifest(folder);
    refuse_other_database(folder, manifest, fresh);
    if (preset.physical) add_sizes(manifest, preset);
    make_folder(folder + "/shards");
    return manifest;
  }
  make_folder(folder + "/shards");
  refuse_stray_shards(folder);
  write_manifest(folder, fresh);
  return fresh;
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

void append_band(StreakImage& image, StreakImage band) {
  if (image.mean.empty()) {
    image = std::move(band);
    return;
  }
  image.mean.insert(image.mean.end(), band.mean.begin(), band.mean.end());
  image.variance.insert(image.variance.end(), band.variance.begin(), band.variance.end());
}

// One tracing for each band; where the drop is does not depend on the band.
Shard trace_shard(const Preset& preset, const ShardKey& key,
                  const std::function<void(double)>& progress) {
  const std::vector<Band> bands = bands_of(preset);
  Shard shard = {.key = key, .bands = {}, .lights = preset.lights};
  shard.light.resize(shard.lights.size());
  for (std::size_t k = 0; k < bands.size(); ++k) {
    const StreakRequest request = shard_request(preset, key, static_cast<int>(k));
    TracedStreak streak = trace_streak(request, [&](double share) {
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
  manifest.shards.insert(
      std::upper_bound(manifest.shards.begin(), manifest.shards.end(), record, before), record);
}

// CPU seconds per shard; kept from earlier runs, since their shards are.
struct CostFile {
  std::string file = {};
  nlohmann::ordered_json costs = {{"version", 1}, {"shards", nlohmann::ordered_json::object()}};
};

// Throws std::runtime_error for a damaged file: other runs' seconds are not thrown away unasked.
CostFile open_costs(const std::string& folder) {
  CostFile cost_file = {.file = folder + "/cost.json"};
  if (!fs::exists(cost_file.file)) return cost_file;
  cost_file.costs = parse_json(cost_file.file, read_file(cost_file.file));
  const JsonPlace document = {.value = &cost_file.costs, .file = cost_file.file};
  check_version(document, 1);
  const JsonPlace shards = member(document, "shards");
  if (!shards.value->is_object()) throw_at(shards, "not an object; expected an object");
  return cost_file;
}

void put_cost(CostFile& cost_file, const ShardKey& key, double cpu_s) {
  cost_file.costs["shards"][shard_name(key)] = {{"cpu_s", cpu_s}};
  write_file_atomically(cost_file.file, cost_file.costs.dump(2) + "\n");
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
  return keys;
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
                                  const Progress& progress) {
  GenerateSummary summary;
  const std::vector<ShardKey> keys = keys_of(preset);
  Manifest manifest = open_database(preset, folder);
  CostFile costs = open_costs(folder);
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
      put_record(manifest, make_record(shard, shard_frame(preset, keys[i]), sha));
      const double cpu_s = process_cpu_s() - start_s;
      summary.cpu_s += cpu_s;
      put_cost(costs, keys[i], cpu_s);
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
