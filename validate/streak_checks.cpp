#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "atlas/json_place.h"
#include "raytrace/brute_force.h"
#include "validate/checks.h"
#include "validate/false_alarm.h"
#include "validate/metrics.h"

namespace pluvia {

namespace {

struct JudgedLight {
  LightDirection light = {};
  const char* check = "";
  const char* what = "";
};

// Neither lies in the plane of view and fall, so that left and right differ.
constexpr std::array<JudgedLight, 2> judged_lights = {{
    {{10, 150}, "easy", "behind the drop, where it refracts"},
    {{30, 50}, "hard", "in front, where it shines by internal reflections"},
}};

constexpr int block_columns_of_32 = 4, block_rows_of_32 = 16;

// The drop and the light that the manifest of preset gn2006 tells, whatever its pictures show.
Preset told_preset(const std::string& folder, const Manifest& manifest, int oscillation) {
  const auto document = parse_json(folder + "/manifest.json", manifest.parameters);
  const JsonPlace parameters = {&document, folder + "/manifest.json", "parameters"};
  const auto number = [&](const JsonPlace& place, const char* key) {
    return number_at(member(place, key));
  };
  Preset preset = {.name = manifest.preset,
                   .mean_radius_m = manifest.mean_radius_m,
                   .density_kg_m3 = number(parameters, "density_kg_m3"),
                   .surface_tension_n_m = number(parameters, "surface_tension_n_m"),
                   .exposure_s = manifest.exposure_s,
                   .fall_speed_m_s = manifest.fall_speed_m_s,
                   .cone_half_angle_deg = number(parameters, "cone_half_angle_deg"),
                   .lights = {},
                   .seed = manifest.seed};
  preset.width_px = integer_at(member(parameters, "width_px"), 4, 64);
  preset.field.paths.refractive_index = positive_at(member(parameters, "refractive_index"));
  preset.field.paths.max_order = integer_at(member(parameters, "max_order"), 0, 20);
  preset.field.paths.min_power = number(parameters, "min_power");
  for (const JsonPlace& set : elements(member(parameters, "oscillation_sets"))) {
    if (integer_at(member(set, "index"), 0, 1 << 20) != oscillation) continue;
    preset.sets = {{.index = oscillation,
                    .a20 = number(set, "A20"),
                    .a31 = number(set, "A31"),
                    .phi_drop_deg = number(set, "phi_drop_deg")}};
  }
  return preset;
}

struct Block {
  int columns = 1, rows = 1;
  float pixels() const { return static_cast<float>(columns * rows); }
};

Block block_of(const StreakFrame& frame) {
  return {std::max(1, block_columns_of_32 * frame.width_px / 32),
          std::max(1, block_rows_of_32 * frame.width_px / 32)};
}

// Means over blocks: a pixel of a streak that few rays meet is nearly all noise.
Image in_blocks(const StreakFrame& frame, const std::vector<float>& values) {
  const Block block = block_of(frame);
  Image blocks = make_image(frame.width_px / block.columns, frame.height_px / block.rows, 1);
  for (int y = 0; y < blocks.height * block.rows; ++y) {
    for (int x = 0; x < blocks.width * block.columns; ++x) {
      blocks.at(x / block.columns, y / block.rows) +=
          values[static_cast<std::size_t>(y * frame.width_px + x)] / block.pixels();
    }
  }
  return blocks;
}

// Of means over blocks, pixels taken as independent. A low-discrepancy point set puts evenly many
// rays into neighbours, so that blocks scatter less than that: it errs toward passing.
Image variance_in_blocks(const StreakFrame& frame, const StreakImage& a, const StreakImage& b) {
  std::vector<float> sum(a.variance.size());
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = a.variance[i] + b.variance[i];
  Image blocks = in_blocks(frame, sum);
  for (float& value : blocks.values) value /= block_of(frame).pixels();
  return blocks;
}

// A shard whose drop is not its own mirror image, the one nearest to 20 degrees of view.
const ShardRecord* lopsided_shard(const Manifest& manifest) {
  const ShardRecord* best = nullptr;
  const auto off = [](const ShardRecord& record) {
    return std::abs(record.key.view_elevation_deg - 20);
  };
  for (const ShardRecord& record : manifest.shards) {
    if (record.key.oscillation != 6) continue;
    if (!best || off(record) < off(*best)) best = &record;
  }
  return best;
}

void add_light(const JudgedLight& judged, const StreakRequest& request, const StreakImage& ours,
               const StreakImage& brute, Report& report) {
  const NoisyError error =
      noisy_error(in_blocks(request.frame, ours.mean), in_blocks(request.frame, brute.mean),
                  variance_in_blocks(request.frame, ours, brute));
  Check check;
  check.name = fmt::format("gn2006.brute_force.osc6.{}", judged.check);
  check.measured = error.squared;
  check.uncertainty = error.standard_error;
  // Wrong pictures are farther than noise, never nearer.
  check.value = std::max(0.0, error.squared / error.standard_error);
  check.bound = one_sided_bound(report_false_alarm, report_comparisons);
  check.unit = "standard errors";
  check.why = fmt::format(
      "The database's streak of oscillation 6 under the light {}, in blocks of {} x {} pixels of "
      "32 columns, against brute force of the drop that the manifest tells: measured is the square "
      "of the relative RMSE less what the noise of both makes. {} A relative RMSE of {:.2f} would "
      "be seen.",
      judged.what, block_columns_of_32, block_rows_of_32, false_alarm_text(),
      std::sqrt(check.bound * error.standard_error));
  report.checks.push_back(check);
}

// Those that the database has, and a line for each that it lacks.
std::vector<JudgedLight> lights_in(const Shard& shard, Report& report) {
  std::vector<JudgedLight> found;
  for (const JudgedLight& one : judged_lights) {
    if (std::find(shard.lights.begin(), shard.lights.end(), one.light) != shard.lights.end()) {
      found.push_back(one);
    } else {
      report.skipped.push_back(fmt::format("gn2006.brute_force.osc6.{}: the database has no {}",
                                           one.check, light_name(one.light)));
    }
  }
  return found;
}

void judge_shard(const Shard& shard, Preset preset, const Progress& progress, Report& report) {
  const std::vector<JudgedLight> judged = lights_in(shard, report);
  if (judged.empty()) return;
  for (const JudgedLight& one : judged) preset.lights.push_back(one.light);
  const auto start = std::chrono::steady_clock::now();
  const StreakRequest request = shard_request(preset, shard.key);
  const BruteStreak brute = brute_force_streak(
      request, {.replicates = 8, .instants = 128, .rays_per_instant = 1000}, [&](double share) {
        if (progress) progress("a streak of the database by brute force", share);
      });
  for (std::size_t k = 0; k < judged.size(); ++k) {
    const auto at = std::find(shard.lights.begin(), shard.lights.end(), judged[k].light);
    add_light(judged[k], request, shard.light[static_cast<std::size_t>(at - shard.lights.begin())],
              brute.light[k], report);
  }
  report.timings_s.emplace_back(
      "brute force, a streak of the database",
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
}

}  // namespace

void add_streak_checks(const std::string& database_folder, const Progress& progress,
                       Report& report) {
  const Manifest manifest = read_manifest(database_folder);
  const std::string names = "gn2006.brute_force.osc6: ";
  const ShardRecord* record = lopsided_shard(manifest);
  if (!record) {
    report.skipped.push_back(names + "the database has no oscillation 6");
    return;
  }
  const Preset preset = told_preset(database_folder, manifest, record->key.oscillation);
  if (preset.cone_half_angle_deg == 0) {
    report.skipped.push_back(names + "its lights are points, which no ray meets");
    return;
  }
  judge_shard(read_whole_shard(database_folder, *record), preset, progress, report);
}

}  // namespace pluvia
