#include "raytrace/import_database.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <nlohmann/json.hpp>

#include "atlas/atomic_file.h"
#include "atlas/atomic_folder.h"
#include "atlas/gray_png.h"
#include "raytrace/drop_silhouette.h"
#include "raytrace/generate.h"

namespace pluvia {

namespace {

constexpr int widest_px = gn2006_sizes_px.front();
constexpr double white = 65535;

std::vector<ViewFactors> read_factors(const std::string& layout) {
  const std::string file = layout + "/" + gn2006_env_factor_file();
  std::vector<ViewFactors> views = parse_gn2006_env_factors(file, read_file(file));
  for (ViewFactors& view : views) {
    const std::string point = layout + "/" + gn2006_point_factor_file(view.view_elevation_deg);
    view.point = parse_gn2006_point_factors(point, read_file(point));
  }
  return views;
}

// `scale` turns brightness into S.
StreakImage read_streak(const std::string& file, double factor, double scale,
                        const StreakFrame& frame) {
  const GrayPicture picture = read_gray_png(file);
  if (picture.width != frame.width_px || picture.height != frame.height_px) {
    throw std::runtime_error(fmt::format("{}: {} x {} pixels; expected {} x {} as in the preset",
                                         file, picture.width, picture.height, frame.width_px,
                                         frame.height_px));
  }
  if (factor == 0 && *std::max_element(picture.values.begin(), picture.values.end()) > 0) {
    throw std::runtime_error(file + ": not black, with a factor of 0; expected a factor > 0");
  }
  const double step = factor / white * scale;
  StreakImage image;
  image.mean.reserve(picture.values.size());
  for (const std::uint16_t value : picture.values) {
    image.mean.push_back(static_cast<float>(value * step));
  }
  image.variance.assign(image.mean.size(), static_cast<float>(step * step / 12));
  return image;
}

Shard read_layout_shard(const std::string& layout, const ViewFactors& factors,
                        const StreakRequest& request, const ShardKey& key, StreakLevel level) {
  Shard shard = {.key = key,
                 .width_px = request.frame.width_px,
                 .height_px = request.frame.height_px,
                 .lights = gn2006_light_directions()};
  shard.coverage.mean = silhouette_coverage(request.drop, request.view_elevation_deg,
                                            request.exposure_s, request.frame);
  shard.coverage.variance.assign(shard.coverage.mean.size(), 0);
  const auto& covered = shard.coverage.mean;
  const double scale =
      level == StreakLevel::transit ? *std::max_element(covered.begin(), covered.end()) : 1;
  const auto place = static_cast<std::size_t>(key.oscillation);
  const int view = key.view_elevation_deg;
  for (std::size_t i = 0; i < shard.lights.size(); ++i) {
    const std::string name =
        gn2006_point_picture(widest_px, view, shard.lights[i], key.oscillation);
    shard.light.push_back(
        read_streak(layout + "/" + name, factors.point[i][place], scale, request.frame));
  }
  shard.env = read_streak(layout + "/" + gn2006_env_picture(widest_px, view, key.oscillation),
                          factors.env[place], scale, request.frame);
  return shard;
}

Manifest import_manifest(const Preset& preset, StreakLevel level) {
  const nlohmann::ordered_json parameters = {
      {"imported_layout", "gn2006"},
      {"level", level == StreakLevel::transit ? "transit" : "exposure"},
      {"variance", "of the rounding to 16 bits alone"},
      {"coverage", "outline of the preset's drops"},
      {"preset_of_drops_and_fall", nlohmann::ordered_json::parse(preset_parameters(preset))}};
  return {.preset = "gn2006-import",
          .parameters = parameters.dump(),
          .seed = 0,
          .instruction_set = instruction_set(Isa::scalar),
          .mean_radius_m = preset.mean_radius_m,
          .exposure_s = preset.exposure_s,
          .fall_speed_m_s = preset.fall_speed_m_s,
          .pixel_m = gn2006_frame(preset, 0).pixel_m};
}

// The manifest's order: oscillation by oscillation.
std::vector<ShardKey> keys_of(const std::vector<ViewFactors>& views, int diameter_um) {
  std::vector<ShardKey> keys;
  for (int oscillation = 0; oscillation < gn2006_oscillations; ++oscillation) {
    for (const ViewFactors& view : views) {
      keys.push_back({diameter_um, oscillation, view.view_elevation_deg});
    }
  }
  return keys;
}

}  // namespace

int import_gn2006(const std::string& layout, const std::string& out, Preset preset,
                  StreakLevel level) {
  if (preset.physical) {
    throw std::runtime_error(
        fmt::format("preset {}; expected one of a single size, gn2006", preset.name));
  }
  preset.width_px = widest_px;
  const std::vector<ViewFactors> views = read_factors(layout);
  const int diameter_um = static_cast<int>(std::lround(2e6 * preset.mean_radius_m));
  const std::vector<ShardKey> keys = keys_of(views, diameter_um);
  Manifest manifest = import_manifest(preset, level);
  manifest.shards.resize(keys.size());
  build_folder_atomically(out, [&](const std::string& temporary) {
    make_folder(temporary + "/shards");
    tbb::parallel_for(std::size_t{0}, keys.size(), [&](std::size_t i) {
      const StreakRequest request = shard_request(preset, keys[i]);
      const Shard shard =
          read_layout_shard(layout, views[i % views.size()], request, keys[i], level);
      const std::string file = temporary + "/shards/" + shard_name(keys[i]) + ".exr";
      manifest.shards[i] = make_record(shard, request.frame, write_shard(file, shard));
    });
    write_manifest(temporary, manifest);
  });
  return static_cast<int>(keys.size());
}

}  // namespace pluvia
