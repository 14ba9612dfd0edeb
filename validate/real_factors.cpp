#include "validate/real_factors.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <stdexcept>

#include <fmt/format.h>

namespace pluvia {

namespace {

constexpr int judged_elevation_deg = 50;  // the others, 10 and 90, are for fitting

std::vector<double> numbers_of(const std::string& line, const std::string& place) {
  std::vector<double> values;
  const char* at = line.data();
  const char* const end = at + line.size();
  while (at < end) {
    double value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || (next != end && *next != ',')) {
      throw std::runtime_error(fmt::format("{}: \"{}\"; expected numbers between commas", place,
                                           std::string(at, end).substr(0, 20)));
    }
    values.push_back(value);
    if (next == end) break;
    at = next + 1;
    if (at == end) {
      throw std::runtime_error(place + ": nothing after the last comma; expected a number");
    }
  }
  return values;
}

int whole_degrees(double angle, int low, int high, const std::string& place) {
  if (angle >= low && angle <= high && angle == std::floor(angle)) return static_cast<int>(angle);
  throw std::runtime_error(
      fmt::format("{}: angle {}; expected whole degrees, {} .. {}", place, angle, low, high));
}

}  // namespace

std::vector<RealFactor> read_real_factors(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file + ": cannot read; expected a table of factors");
  std::vector<RealFactor> factors;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.empty() || line[0] == '#' || line[0] == 'l') continue;
    const std::string place = fmt::format("{}:{}", file, number);
    const auto row = numbers_of(line, place);
    if (row.size() != 12) {
      throw std::runtime_error(fmt::format(
          "{}: {} columns; expected elevation, azimuth and ten factors", place, row.size()));
    }
    const LightDirection light = {whole_degrees(row[0], -90, 90, place),
                                  whole_degrees(row[1], 0, 180, place)};
    for (int oscillation = 0; oscillation < 10; ++oscillation) {
      const double factor = row[static_cast<std::size_t>(oscillation) + 2];
      if (!(factor > 0) || !std::isfinite(factor)) {
        throw std::runtime_error(
            fmt::format("{}: factor {}; expected a finite number > 0", place, factor));
      }
      factors.push_back({light, oscillation, factor});
    }
  }
  if (factors.empty()) throw std::runtime_error(file + ": no rows; expected a table of factors");
  return factors;
}

FactorComparison compare_factors(const std::string& database_folder, const Manifest& manifest,
                                 const std::vector<RealFactor>& factors) {
  std::map<int, Shard> shards;  // of view elevation 0, by oscillation
  for (const ShardRecord& record : manifest.shards) {
    if (record.key.view_elevation_deg != 0) continue;
    if (record.width_px != 32) {
      throw std::runtime_error(
          fmt::format("{}/{}: {} px wide; expected 32 px, the size whose "
                      "maximum is the factor",
                      database_folder, record.file, record.width_px));
    }
    shards[record.key.oscillation] = read_shard(database_folder + "/" + record.file);
  }
  FactorComparison comparison;
  double sum = 0;
  int count = 0;
  for (const RealFactor& real : factors) {
    const auto shard = shards.find(real.oscillation);
    if (shard == shards.end()) continue;
    const auto& lights = shard->second.lights;
    // At elevation +-90 the azimuth has no meaning; the database files it under 170.
    const auto at = std::find_if(lights.begin(), lights.end(), [&](const LightDirection& l) {
      return l.elevation_deg == real.light.elevation_deg &&
             (std::abs(l.elevation_deg) == 90 || l.azimuth_deg == real.light.azimuth_deg);
    });
    if (at == lights.end()) continue;
    const auto& mean = shard->second.light[static_cast<std::size_t>(at - lights.begin())].mean;
    const double ours = *std::max_element(mean.begin(), mean.end());
    if (!(ours > 0)) {
      throw std::runtime_error(fmt::format(
          "{}: light of elevation {} and azimuth {} of oscillation {} is black; expected a maximum "
          "> 0",
          database_folder, real.light.elevation_deg, real.light.azimuth_deg, real.oscillation));
    }
    comparison.residuals.push_back({real, std::log10(ours / real.factor)});
    if (real.light.elevation_deg == judged_elevation_deg) continue;
    sum += comparison.residuals.back().log10_ratio;
    ++count;
  }
  if (count == 0) {
    throw std::runtime_error(database_folder +
                             ": no shard of view elevation 0 with the factors' lights; expected "
                             "at least one oscillation");
  }
  comparison.log10_constant = sum / count;
  for (FactorResidual& r : comparison.residuals) r.log10_ratio -= comparison.log10_constant;
  return comparison;
}

double factor_rms(const FactorComparison& comparison, int oscillation, int light_elevation_deg) {
  double sum = 0;
  int count = 0;
  for (const FactorResidual& r : comparison.residuals) {
    if (oscillation >= 0 && r.real.oscillation != oscillation) continue;
    if (r.real.light.elevation_deg != light_elevation_deg) continue;
    sum += r.log10_ratio * r.log10_ratio;
    ++count;
  }
  if (count == 0) throw std::runtime_error("no factor of that oscillation and elevation");
  return std::sqrt(sum / count);
}

}  // namespace pluvia
