// How far the dot product of a map's spherical harmonics with a streak's transfer is from the same
// map integrated directly, seen level and from 40 degrees above, by degree, and what both cost; and
// how far both are from themselves on a grid three times as fine. After each error, in brackets,
// the deepest value below zero over the brightest of the picture:
//   transfer_accuracy PRESET MAP..
#include <cmath>
#include <exception>
#include <filesystem>
#include <string>

#include <fmt/format.h>

#include "atlas/image_io.h"
#include "atlas/transfer.h"
#include "raytrace/preset.h"
#include "raytrace/process_time.h"
#include "raytrace/spherical_harmonics.h"

namespace pluvia {
namespace {

struct Timed {
  TracedStreak streak = {};
  double cpu_s = 0;
};

Timed trace(const Preset& preset, const ShardKey& key, const EnvironmentRequest& environment) {
  StreakRequest request = shard_request(preset, key);
  request.environment = environment;
  const double start_s = process_cpu_s();
  Timed timed = {.streak = trace_streak(request)};
  timed.cpu_s = process_cpu_s() - start_s;
  return timed;
}

struct Error {
  double squares = 0, of_squares = 0, most_negative = 0;
  double relative() const { return std::sqrt(squares / of_squares); }
};

// The dot product of one channel.
std::vector<float> picture(const Preset& preset, const ShardKey& key, const TracedStreak& streak,
                           std::vector<double> coefficients, int degree) {
  const StreakFrame frame = shard_frame(preset, key);
  const Shard shard = {
      .width_px = frame.width_px, .height_px = frame.height_px, .transfer = streak.transfer};
  coefficients.resize(harmonic_count(degree));
  return lit_by_environment(shard, {coefficients}).mean;
}

void add_difference(const std::vector<float>& ours, const std::vector<float>& truth, Error& error) {
  double brightest = 0, lowest = 0;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    error.squares += std::pow(ours[i] - truth[i], 2);
    error.of_squares += std::pow(truth[i], 2);
    brightest = std::max(brightest, static_cast<double>(truth[i]));
    lowest = std::min(lowest, static_cast<double>(ours[i]));
  }
  error.most_negative = std::max(error.most_negative, -lowest / brightest);
}

// What the grid costs in accuracy, of the direct picture and of the dot product of degree 4.
void report_grid(Preset preset, const ShardKey& key, const EnvironmentRequest& environment,
                 const TracedStreak& coarse, const std::vector<std::vector<double>>& coefficients) {
  preset.field.base_cells *= 3;
  const TracedStreak fine = trace(preset, key, environment).streak;
  Error direct, dot;
  for (std::size_t c = 0; c < coefficients.size(); ++c) {
    add_difference(coarse.mapped[c].mean, fine.mapped[c].mean, direct);
    add_difference(picture(preset, key, coarse, coefficients[c], 4),
                   picture(preset, key, fine, coefficients[c], 4), dot);
  }
  fmt::print("  against {} base cells: direct {:.4f}, degree 4 {:.4f}\n", preset.field.base_cells,
             direct.relative(), dot.relative());
}

Error error_at(const Preset& preset, const ShardKey& key, const TracedStreak& streak,
               const std::vector<std::vector<double>>& coefficients, int degree) {
  Error error;
  for (std::size_t c = 0; c < coefficients.size(); ++c) {
    add_difference(picture(preset, key, streak, coefficients[c], degree), streak.mapped[c].mean,
                   error);
  }
  return error;
}

// One map, directly and by harmonics.
void report_map(const Preset& preset, const ShardKey& key, const std::string& file) {
  EnvironmentRequest environment = {.transfer_degree = highest_harmonic_degree};
  environment.map.radiance = read_environment_map(file);
  const double start_s = process_cpu_s();
  const auto coefficients = harmonic_coefficients(environment.map, highest_harmonic_degree);
  const double projecting_s = process_cpu_s() - start_s;
  const Timed timed = trace(preset, key, environment);
  fmt::print("set {}, view {}, {}: projected in {:.2f} s, traced in {:.2f} s; relRMSE by degree",
             key.oscillation, key.view_elevation_deg, std::filesystem::path(file).stem().string(),
             projecting_s, timed.cpu_s);
  for (int degree = 0; degree <= highest_harmonic_degree; ++degree) {
    const Error error = error_at(preset, key, timed.streak, coefficients, degree);
    fmt::print(" {:.4f} ({:.4f})", error.relative(), error.most_negative);
  }
  fmt::print("\n");
  report_grid(preset, key, environment, timed.streak, coefficients);
}

void report(const std::string& preset_file, const std::vector<std::string>& maps) {
  const Preset preset = read_preset(preset_file);
  for (const int oscillation : {0, 3}) {
    ShardKey key = {.diameter_um = diameters_of(preset).front(), .oscillation = oscillation};
    for (const int degree : {-1, 3, 4}) {
      fmt::print("set {}, transfer degree {}: {:.2f} CPU s\n", oscillation, degree,
                 trace(preset, key, {.transfer_degree = degree}).cpu_s);
    }
    fmt::print("set {}, no environment: {:.2f} CPU s\n", oscillation,
               trace(preset, key, {.uniform = false}).cpu_s);
    for (const std::string& file : maps) {
      for (const int view : {0, 40}) {
        key.view_elevation_deg = view;
        report_map(preset, key, file);
      }
    }
  }
}

}  // namespace
}  // namespace pluvia

int main(int count, char** values) {
  if (count < 3) {
    fmt::print(stderr, "transfer_accuracy: {} arguments; expected PRESET MAP..\n", count - 1);
    return 2;
  }
  try {
    pluvia::report(values[1], {values + 2, values + count});
  } catch (const std::exception& error) {
    fmt::print(stderr, "transfer_accuracy: {}\n", error.what());
    return 1;
  }
  return 0;
}
