#include "atlas/streak_database.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "atlas/atomic_file.h"
#include "atlas/exr_parts.h"

namespace pluvia {
namespace {

std::map<std::string, int> attributes_of(const ShardKey& key) {
  return {{"diameter_um", key.diameter_um},
          {"oscillation", key.oscillation},
          {"view_elevation_deg", key.view_elevation_deg}};
}

constexpr const char* transfer_prefix = "transfer_";
constexpr const char* parts_expected = "light_vSEE_hAAA .., env, transfer_NN .., coverage";

// Harmonics change their sign, and so does the light under them.
void check_values(const std::string& file, const ExrPart& part) {
  if (part.name.starts_with(transfer_prefix)) {
    check_signed_values(file, part);
  } else {
    check_radiances(file, part);
  }
}

// Band k of an image is [k * count, (k + 1) * count) of both vectors.
ExrPart part_of(const std::string& file, const Shard& shard, const std::string& name,
                const StreakImage& image, const std::vector<std::string>& bands) {
  const auto count =
      static_cast<std::size_t>(shard.width_px) * static_cast<std::size_t>(shard.height_px);
  if (image.mean.size() != bands.size() * count || image.variance.size() != image.mean.size()) {
    throw std::runtime_error(
        fmt::format("{}: part {}: {} values and {} variances; expected {} x {} of each{}", file,
                    name, image.mean.size(), image.variance.size(), shard.width_px, shard.height_px,
                    bands.size() > 1 ? fmt::format(" for each of {} bands", bands.size()) : ""));
  }
  ExrPart part = {.name = name,
                  .width = shard.width_px,
                  .height = shard.height_px,
                  .attributes = attributes_of(shard.key)};
  const auto slice = [count](const std::vector<float>& values, std::size_t band) {
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(band * count);
    return std::vector<float>(first, first + static_cast<std::ptrdiff_t>(count));
  };
  for (std::size_t k = 0; k < bands.size(); ++k) {
    part.channels.push_back({.name = bands[k], .values = slice(image.mean, k)});
    part.channels.push_back({.name = bands[k] + ".variance", .values = slice(image.variance, k)});
  }
  check_values(file, part);
  return part;
}

void check_bands(const std::string& file, const Shard& shard) {
  const auto& bands = shard.bands;
  const bool ascending =
      std::adjacent_find(bands.begin(), bands.end(), std::greater_equal<>()) == bands.end();
  const bool plain = std::none_of(bands.begin(), bands.end(), [](const std::string& name) {
    return name.empty() || name.find('.') != std::string::npos;
  });
  if (!bands.empty() && ascending && plain) return;
  throw std::runtime_error(
      fmt::format("{}: bands {}; expected names without a dot, ascending, at least one", file,
                  fmt::join(bands, ", ")));
}

void check_lights(const std::string& file, const Shard& shard) {
  if (shard.light.size() != shard.lights.size()) {
    throw std::runtime_error(
        fmt::format("{}: {} light pictures for {} light directions; expected one each", file,
                    shard.light.size(), shard.lights.size()));
  }
  for (auto it = shard.lights.begin(); it != shard.lights.end(); ++it) {
    if (std::abs(it->elevation_deg) > 90 || it->azimuth_deg < 0 || it->azimuth_deg > 180) {
      throw std::runtime_error(
          fmt::format("{}: part {}: expected an elevation of -90 .. 90 and an azimuth of 0 .. 180",
                      file, light_name(*it)));
    }
    if (std::find(shard.lights.begin(), it, *it) != it) {
      throw std::runtime_error(
          fmt::format("{}: part {}: twice; expected each light once", file, light_name(*it)));
    }
  }
}

// All harmonics of degrees 0 .. L: a square number of them.
void check_transfer(const std::string& file, const Shard& shard) {
  std::size_t degree = 0;
  while (degree * degree < shard.transfer.size()) ++degree;
  if (degree * degree == shard.transfer.size()) return;
  throw std::runtime_error(
      fmt::format("{}: {} transfer pictures; expected 1, 4, 9, 16 or another "
                  "square, or none",
                  file, shard.transfer.size()));
}

std::vector<ExrPart> parts_of(const std::string& file, const Shard& shard) {
  if (shard.width_px < 1 || shard.height_px < 1) {
    throw std::runtime_error(fmt::format("{}: {} x {} pixels; expected at least 1 x 1", file,
                                         shard.width_px, shard.height_px));
  }
  check_bands(file, shard);
  check_lights(file, shard);
  check_transfer(file, shard);
  std::vector<ExrPart> parts;
  for (std::size_t i = 0; i < shard.lights.size(); ++i) {
    parts.push_back(part_of(file, shard, light_name(shard.lights[i]), shard.light[i], shard.bands));
  }
  if (!shard.env.mean.empty() || !shard.env.variance.empty()) {
    parts.push_back(part_of(file, shard, "env", shard.env, shard.bands));
  }
  for (std::size_t i = 0; i < shard.transfer.size(); ++i) {
    parts.push_back(part_of(file, shard, transfer_name(i), shard.transfer[i], shard.bands));
  }
  parts.push_back(part_of(file, shard, "coverage", shard.coverage, {"Y"}));
  return parts;
}

[[noreturn]] void throw_part(const std::string& file, const ExrPart& part,
                             const std::string& what) {
  throw std::runtime_error(fmt::format("{}: part {}: {}", file, part.name, what));
}

LightDirection light_of(const std::string& file, const ExrPart& part) {
  LightDirection light;
  const int found =
      std::sscanf(part.name.c_str(), "light_v%3d_h%3d", &light.elevation_deg, &light.azimuth_deg);
  if (found != 2 || light_name(light) != part.name) {
    throw_part(file, part,
               fmt::format("name unknown or out of place; expected {}", parts_expected));
  }
  return light;
}

ShardKey key_of(const std::string& file, const ExrPart& part) {
  for (const auto& [name, unused] : attributes_of({})) {
    if (!part.attributes.contains(name)) {
      throw_part(file, part, fmt::format("no attribute {}; expected an integer", name));
    }
  }
  const ShardKey key = {.diameter_um = part.attributes.at("diameter_um"),
                        .oscillation = part.attributes.at("oscillation"),
                        .view_elevation_deg = part.attributes.at("view_elevation_deg")};
  const std::string stem = std::filesystem::path(file).stem().string();
  if (stem != shard_name(key)) {
    throw_part(
        file, part,
        fmt::format("belongs to {}; expected {} as in the file's name", shard_name(key), stem));
  }
  return key;
}

// Names of the channels that are no variances.
std::vector<std::string> bands_of(const ExrPart& part) {
  std::vector<std::string> bands;
  for (const ExrChannel& channel : part.channels) {
    if (!channel.name.ends_with(".variance")) bands.push_back(channel.name);
  }
  return bands;
}

// Channels come in order of their names, and a dot sorts before what a name may go on with.
bool holds_bands(const ExrPart& part, const std::vector<std::string>& bands) {
  if (part.channels.size() != 2 * bands.size()) return false;
  for (std::size_t k = 0; k < bands.size(); ++k) {
    if (part.channels[2 * k].name != bands[k]) return false;
    if (part.channels[2 * k + 1].name != bands[k] + ".variance") return false;
  }
  return !bands.empty();
}

StreakImage take_image(const std::string& file, ExrPart& part, const Shard& shard,
                       const std::vector<std::string>& bands) {
  if (part.width != shard.width_px || part.height != shard.height_px) {
    throw_part(file, part,
               fmt::format("{} x {} pixels; expected {} x {} like the other parts", part.width,
                           part.height, shard.width_px, shard.height_px));
  }
  if (!holds_bands(part, bands)) {
    throw_part(
        file, part,
        fmt::format("other channels; expected {0} and {0}.variance", fmt::join(bands, ", ")));
  }
  if (key_of(file, part) != shard.key) throw_part(file, part, "other attributes; expected one key");
  check_values(file, part);
  StreakImage image = {.mean = std::move(part.channels[0].values),
                       .variance = std::move(part.channels[1].values)};
  for (std::size_t k = 2; k < part.channels.size(); k += 2) {
    const auto append = [](std::vector<float>& to, const std::vector<float>& from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    append(image.mean, part.channels[k].values);
    append(image.variance, part.channels[k + 1].values);
  }
  return image;
}

// The transfer parts from the end of the list, in their order.
void take_transfer(const std::string& file, std::vector<ExrPart>& parts, Shard& shard) {
  std::size_t first = parts.size();
  while (first > 0 && parts[first - 1].name.starts_with(transfer_prefix)) --first;
  for (std::size_t i = first; i < parts.size(); ++i) {
    if (parts[i].name != transfer_name(i - first)) {
      throw_part(file, parts[i],
                 fmt::format("out of place; expected {}", transfer_name(i - first)));
    }
    shard.transfer.push_back(take_image(file, parts[i], shard, shard.bands));
  }
  check_transfer(file, shard);
  parts.resize(first);
}

}  // namespace

std::vector<LightDirection> gn2006_light_directions() {
  std::vector<LightDirection> lights = {{.elevation_deg = -90, .azimuth_deg = 170}};
  for (int elevation = -70; elevation <= 70; elevation += 20) {
    for (int azimuth = 10; azimuth <= 170; azimuth += 20) {
      lights.push_back({.elevation_deg = elevation, .azimuth_deg = azimuth});
    }
  }
  lights.push_back({.elevation_deg = 90, .azimuth_deg = 170});
  return lights;
}

std::vector<LightDirection> light_grid(int step_deg) {
  if (step_deg == 20) return gn2006_light_directions();
  if (step_deg != 10 && step_deg != 5)
    throw std::invalid_argument(
        fmt::format("light_grid: {} degrees; expected 20, 10 or 5", step_deg));
  std::vector<LightDirection> lights = {{-90, 170}};
  for (int elevation = -90 + step_deg; elevation < 90; elevation += step_deg) {
    for (int azimuth = 0; azimuth <= 180; azimuth += step_deg)
      lights.push_back({elevation, azimuth});
  }
  lights.push_back({90, 170});
  return lights;
}

std::string light_name(const LightDirection& light) {
  return fmt::format("light_v{:+03d}_h{:03d}", light.elevation_deg, light.azimuth_deg);
}

std::string transfer_name(std::size_t number) {
  return fmt::format("{}{:02d}", transfer_prefix, number);
}

std::string shard_name(const ShardKey& key) {
  return fmt::format("d{:04d}_osc{:02d}_v{:+03d}", key.diameter_um, key.oscillation,
                     key.view_elevation_deg);
}

double estimated_relative_error(const StreakImage& image) {
  double squares = 0;
  double variances = 0;
  for (const float value : image.mean) squares += static_cast<double>(value) * value;
  for (const float value : image.variance) variances += value;
  return squares > 0 ? std::sqrt(variances / squares) : 0;
}

std::string write_shard(const std::string& file, const Shard& shard) {
  const std::string bytes = exr_bytes(parts_of(file, shard));
  write_file_atomically(file, bytes);
  return sha256(bytes);
}

Shard read_shard(const std::string& file) {
  std::vector<ExrPart> parts = parse_exr(file, read_file(file));
  if (parts.back().name != "coverage") {
    throw std::runtime_error(
        fmt::format("{}: part coverage: missing at the end, where {} stands; expected {}", file,
                    parts.back().name, parts_expected));
  }
  Shard shard = {.key = key_of(file, parts.back()),
                 .width_px = parts.back().width,
                 .height_px = parts.back().height};
  shard.coverage = take_image(file, parts.back(), shard, {"Y"});
  parts.pop_back();
  if (!parts.empty()) shard.bands = bands_of(parts.front());
  take_transfer(file, parts, shard);
  if (!parts.empty() && parts.back().name == "env") {
    shard.env = take_image(file, parts.back(), shard, shard.bands);
    parts.pop_back();
  }
  for (ExrPart& part : parts) {
    shard.lights.push_back(light_of(file, part));
    shard.light.push_back(take_image(file, part, shard, shard.bands));
  }
  check_lights(file, shard);
  return shard;
}

}  // namespace pluvia
