#include "tests/bench/shard_choice.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/global_control.h>

#include "atlas/flag_values.h"
#include "raytrace/streak_accuracy.h"

namespace pluvia {

namespace {

std::vector<int> chosen_diameters_um(const ShardFlags& flags, const Preset& preset) {
  const std::vector<int> known = diameters_of(preset);
  if (flags.diameters_mm.empty()) return {known.front()};
  std::vector<int> chosen;
  for (const double mm : flags.diameters_mm) {
    const int um = static_cast<int>(std::lround(1000 * mm));
    if (std::find(known.begin(), known.end(), um) == known.end()) {
      throw CLI::ValidationError(
          "--diameters-mm",
          fmt::format("{}; expected among the preset's {} um", mm, fmt::join(known, ", ")));
    }
    chosen.push_back(um);
  }
  return chosen;
}

void refuse_unknown(const ShardFlags& flags, const Preset& preset) {
  std::vector<int> known;
  for (const OscillationSet& set : preset.sets) known.push_back(set.index);
  for (const int oscillation : flags.oscillations) {
    if (std::find(known.begin(), known.end(), oscillation) != known.end()) continue;
    throw CLI::ValidationError("--oscillations", fmt::format("{}; expected among the preset's {}",
                                                             oscillation, fmt::join(known, ", ")));
  }
  for (const int view : flags.views) {
    if (view >= 0 || preset.physical) continue;
    throw CLI::ValidationError("--views",
                               fmt::format("{}; expected 0 .. 80 for {}", view, preset.name));
  }
}

double number_in(const std::string& item, const std::string& text, double low, double high,
                 bool whole) {
  double value = 0;
  if (CLI::detail::lexical_cast(text, value) && value >= low && value <= high &&
      (!whole || value == std::floor(value))) {
    return value;
  }
  throw CLI::ValidationError("setting",
                             fmt::format("\"{}\"; expected {} from {} to {}", item,
                                         whole ? "a whole number" : "a number", low, high));
}

void apply_item(const std::string& item, StreakRequest& request) {
  const std::size_t equal = std::min(item.find('='), item.size());
  const std::string key = item.substr(0, equal);
  const std::string text = item.substr(std::min(equal + 1, item.size()));
  const auto whole = [&](double low, double high) {
    return static_cast<int>(number_in(item, text, low, high, true));
  };
  FieldOptions& field = request.field;
  if (key == "slices") {
    request.slices = whole(1, 1e6);
  } else if (key == "spans_per_period") {
    request.spans_per_period = number_in(item, text, 0.01, 1e4, false);
  } else if (key == "base_cells") {
    field.base_cells = whole(1, 1000);
  } else if (key == "space_depth") {
    field.space_depth = whole(0, 10);
  } else if (key == "time_depth") {
    field.time_depth = whole(0, 10);
  } else if (key == "bend_tolerance") {
    field.bend_tolerance = number_in(item, text, 1e-6, 10, false);
  } else if (key == "motion_tolerance") {
    request.motion_tolerance = number_in(item, text, 0, 10, false);
  } else if (key == "level") {
    request = at_accuracy_level(request, whole(0, accuracy_levels - 1));
  } else if (key == "seed") {
    request.seed = static_cast<std::uint64_t>(whole(0, std::numeric_limits<int>::max()));
  } else {
    throw CLI::ValidationError(
        "setting",
        fmt::format(
            "\"{}\"; expected KEY=VALUE with one of slices, spans_per_period, "
            "base_cells, space_depth, time_depth, bend_tolerance, motion_tolerance, level, seed",
            item));
  }
}

}  // namespace

void add_shard_options(CLI::App& app, ShardFlags& flags) {
  app.add_option("preset", flags.preset, "preset, TOML")->required();
  app.add_option("--oscillations", flags.oscillations, "sets of the preset")
      ->delimiter(',')
      ->check(CLI::Range(0, 99))
      ->capture_default_str();
  app.add_option("--views", flags.views, "view elevations [deg]")
      ->delimiter(',')
      ->check(CLI::Range(-80, 80))
      ->capture_default_str();
  app.add_option("--diameters-mm", flags.diameters_mm, "of the preset's; default its first [mm]")
      ->delimiter(',')
      ->check(finite_range(0.01, 20));
  app.add_option("--cone-half-angle-deg", flags.cone_half_angle_deg, "instead of the preset's")
      ->check(finite_range(0.05, 30));
  app.add_option("--width-px", flags.width_px, "of the picture, instead of the preset's")
      ->check(CLI::IsMember({4, 8, 16, 32, 64}));
  app.add_option("--threads", flags.threads, "waiting ones count as CPU time")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  app.add_option("--csv", flags.csv, "file for the figures of every light");
}

std::vector<ChosenShard> choose_shards(const ShardFlags& flags) {
  Preset preset = read_preset(flags.preset);
  refuse_unknown(flags, preset);
  if (flags.cone_half_angle_deg) preset.cone_half_angle_deg = *flags.cone_half_angle_deg;
  if (flags.width_px) preset.width_px = *flags.width_px;
  std::vector<ChosenShard> shards;
  for (const int diameter_um : chosen_diameters_um(flags, preset)) {
    for (const int oscillation : flags.oscillations) {
      for (const int view : flags.views) {
        const ShardKey key = {diameter_um, oscillation, view};
        shards.push_back({shard_name(key), shard_request(preset, key)});
      }
    }
  }
  return shards;
}

void apply_setting(const std::string& setting, StreakRequest& request) {
  for (std::size_t from = 0; from < setting.size();) {
    const std::size_t comma = std::min(setting.find(',', from), setting.size());
    apply_item(setting.substr(from, comma - from), request);
    from = comma + 1;
  }
}

int run_judge(CLI::App& app, const ShardFlags& flags, int argc, char** argv,
              const std::function<void()>& judge) {
  try {
    app.parse(argc, argv);
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(flags.threads));
    judge();
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help
    fmt::print(stderr, "{}: {}; see {} --help\n", app.get_name(), error.what(), app.get_name());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: {}\n", app.get_name(), error.what());
    return 1;
  }
  return 0;
}

}  // namespace pluvia
