// Small databases of preset gn2006, traced for tests of the validator, with a fault in what is
// traced: their manifests tell the right drop.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "atlas/atomic_file.h"
#include "raytrace/generate.h"
#include "validate/checks.h"

namespace pluvia {

struct FaultyDatabase {
  std::vector<int> oscillations = {0, 6};
  std::vector<LightDirection> lights = {{10, 150}, {30, 50}};
  std::function<void(StreakRequest&)> traced = {};  // changes what is traced
  std::function<void(Shard&)> written = {};         // changes what is written
};

// As the preview, half as wide, at view elevation 0, with orders 0 to 2: so that p = 2 is the last.
inline void write_traced(const std::string& folder, const FaultyDatabase& faulty) {
  Preset preset = read_preset(PLUVIA_SOURCE_DIR "/data/presets/preview.toml");
  preset.lights = faulty.lights;
  preset.width_px = 16;
  preset.slices = 96;
  preset.transfer_degree = -1;
  preset.field.paths.max_order = 2;
  make_folder(folder + "/shards");
  Manifest manifest = {.preset = preset.name,
                       .parameters = preset_parameters(preset),
                       .seed = preset.seed,
                       .instruction_set = instruction_set(preset.field.isa),
                       .mean_radius_m = preset.mean_radius_m,
                       .exposure_s = preset.exposure_s,
                       .fall_speed_m_s = preset.fall_speed_m_s,
                       .pixel_m = gn2006_frame(preset, 0).pixel_m};
  for (const int oscillation : faulty.oscillations) {
    const ShardKey key = {3200, oscillation, 0};
    StreakRequest request = shard_request(preset, key);
    if (faulty.traced) faulty.traced(request);
    TracedStreak streak = trace_streak(request);
    Shard shard = {.key = key,
                   .width_px = request.frame.width_px,
                   .height_px = request.frame.height_px,
                   .lights = preset.lights,
                   .light = std::move(streak.light),
                   .env = std::move(streak.env),
                   .coverage = std::move(streak.coverage)};
    if (faulty.written) faulty.written(shard);
    const std::string file = "shards/" + shard_name(key) + ".exr";
    ShardRecord record = make_record(shard, request.frame, write_shard(folder + "/" + file, shard));
    manifest.shards.push_back(std::move(record));
  }
  write_manifest(folder, manifest);
}

}  // namespace pluvia
