#include "validate/streak_input.h"

#include <algorithm>
#include <regex>
#include <stdexcept>

#include <fmt/format.h>

#include "atlas/image_io.h"

namespace pluvia {

namespace {

StreakInput read_from_shard(const std::string& file, const std::vector<std::string>& names) {
  const Shard shard = read_shard(file);
  if (shard.bands.size() != 1) {
    throw std::runtime_error(fmt::format("{}: {} bands; expected the one of a gn2006 database",
                                         file, shard.bands.size()));
  }
  StreakInput input{.view_elevation_deg = shard.key.view_elevation_deg,
                    .width_px = shard.width_px,
                    .height_px = shard.height_px};
  const auto add = [&](std::size_t k) {
    const std::vector<float>& mean = shard.light[k].mean;
    input.streaks.push_back({shard.lights[k], {mean.begin(), mean.end()}});
  };
  for (const std::string& name : names) {
    const auto at = std::find(shard.lights.begin(), shard.lights.end(), parse_light_name(name));
    if (at == shard.lights.end()) {
      throw std::runtime_error(
          fmt::format("{}: no part {}; expected one of the shard's lights", file, name));
    }
    add(static_cast<std::size_t>(at - shard.lights.begin()));
  }
  for (std::size_t k = 0; names.empty() && k < shard.lights.size(); ++k) add(k);
  return input;
}

StreakInput read_from_picture(const std::string& file, const std::vector<std::string>& names,
                              int view_elevation_deg) {
  if (names.size() != 1) {
    throw std::runtime_error(fmt::format(
        "{}: a picture, and {} lights named; expected the one that lit it", file, names.size()));
  }
  const Image image = read_image(file);
  if (image.channels != 1) {
    throw std::runtime_error(
        fmt::format("{}: {} channels; expected one, of linear values", file, image.channels));
  }
  return {
      .streaks = {{parse_light_name(names.front()), {image.values.begin(), image.values.end()}}},
      .view_elevation_deg = view_elevation_deg,
      .width_px = image.width,
      .height_px = image.height,
      .known_level = false};
}

}  // namespace

LightDirection parse_light_name(const std::string& name) {
  static const std::regex form("light_v([+-][0-9]{2})_h([0-9]{3})");
  std::smatch match;
  if (std::regex_match(name, match, form)) {
    const LightDirection light = {std::stoi(match[1]), std::stoi(match[2])};
    if (std::abs(light.elevation_deg) <= 90 && light.azimuth_deg <= 180) return light;
  }
  throw std::runtime_error(fmt::format("light \"{}\"; expected the like of light_v+10_h050", name));
}

StreakInput read_streaks(const std::string& file, const std::vector<std::string>& lights,
                         int view_elevation_deg) {
  if (file.ends_with(".exr")) return read_from_shard(file, lights);
  return read_from_picture(file, lights, view_elevation_deg);
}

}  // namespace pluvia
