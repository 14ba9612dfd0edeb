#include "validate/frame_composite.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "atlas/atlas_lookup.h"
#include "raytrace/rain_fog.h"
#include "raytrace/streak_geometry.h"
#include "validate/streak_footprint.h"

namespace pluvia {
namespace {

const AtlasLayer& layer_of(const StreakAtlas& atlas, int oscillation) {
  for (const AtlasLayer& layer : atlas.layers) {
    if (layer.oscillation == oscillation) return layer;
  }
  throw std::runtime_error(
      fmt::format("oscillation set {}; expected one of the {} sets of the atlas", oscillation,
                  atlas.layers.size()));
}

// One cell of the atlas and what it counts for in a streak.
struct WeightedCell {
  const Image* image = nullptr;
  CellRect rect = {};
  bool mirrored = false;  // left and right swapped
  StreakValue weight = StreakValue::Zero();
};

// The sum of the cells. Row by row, all cells of a row one after the other: the row then stays in
// the processor's nearest memory, which makes frames under a sky (16 cells a view) much cheaper.
void add_cells(const std::vector<WeightedCell>& cells, StreakPicture& picture) {
  for (int y = 0; y < picture.height; ++y) {
    StreakValue* const row = &picture.values[static_cast<std::size_t>(y * picture.width)];
    for (const WeightedCell& cell : cells) {
      const float* const texels =
          &cell.image->values[static_cast<std::size_t>(cell.rect.y + y) *
                                  static_cast<std::size_t>(cell.image->width) +
                              static_cast<std::size_t>(cell.rect.x)];
      for (int x = 0; x < picture.width; ++x)
        row[x] +=
            static_cast<double>(texels[cell.mirrored ? picture.width - 1 - x : x]) * cell.weight;
    }
  }
}

struct Lookup {
  LookupMode mode = LookupMode::view_linear;
  std::vector<LightRow> rows = {};
};

// As the streak sees it: in the drop's frame, turned over where a view from below is served by one
// from above.
SkyLight sky_seen(const SkyLight& sky, const StreakPlacement& placement, const StreakAtlas& atlas) {
  SkyLight seen = seen_from(sky, placement.world_from_drop);
  const bool over = placement.view_elevation_deg < 0 && views_below(atlas) == ViewsBelow::flipped;
  return over ? turned_over(seen) : seen;
}

// The cells of the sky's light. A database for a scene without an environment has no picture of it.
void add_sky(const StreakAtlas& atlas, const AtlasLayer& layer, int view, double weight,
             const SkyLight& sky, std::vector<WeightedCell>& cells) {
  const auto add = [&](const Image& image, int column, const Eigen::Vector3d& light) {
    cells.push_back({&image,
                     cell_rect(atlas, view, column, 0),
                     false,
                     {weight * light.x(), weight * light.y(), weight * light.z(), 0}});
  };
  if (sky.coefficients.isZero(0)) return;
  if (degree_of(sky) == 0) return add(layer.env.at(0), 0, mean_radiance(sky));
  for (int i = 0; i < static_cast<int>(sky.coefficients.rows()); ++i)
    add(layer.transfer.at(0), i, sky.coefficients.row(i).transpose());
}

// The cell of one view with all lights, the sky as the streak sees it and the coverage of this
// drop.
StreakPicture lit_picture(const StreakAtlas& atlas, const Drop& drop,
                          const StreakPlacement& placement, int view, double weight,
                          double transmitted, const SkyLight& sky, const Lookup& lookup) {
  const AtlasView& row = atlas.views[static_cast<std::size_t>(view)];
  StreakPicture picture{.width = atlas.cell_width_px,
                        .height = row.height_px,
                        .path_top_row = row.path_top_row,
                        .path_rows = row.path_bottom_row - row.path_top_row};
  picture.values.assign(static_cast<std::size_t>(picture.width * picture.height),
                        StreakValue::Zero());
  std::vector<WeightedCell> cells;
  for (const LitStreak& light : placement.lights) {
    const FoldedAngles angles =
        fold_angles(placement.view_elevation_deg, light.light_elevation_deg,
                    light.light_azimuth_deg, drop.oscillation, views_below(atlas));
    for (const LightTap& tap : mix_cells(atlas, lookup.rows, angles, lookup.mode).lights) {
      if (tap.weight == 0) continue;
      const Eigen::Vector3d irradiance = weight * tap.weight * transmitted * light.irradiance_lux;
      if (irradiance.isZero(0)) continue;
      const int oscillation =
          tap.mirrored ? mirrored_oscillation(angles.oscillation) : angles.oscillation;
      cells.push_back({&layer_of(atlas, oscillation).point.at(0),
                       cell_rect(atlas, view, tap.light, 0),
                       angles.mirrored != tap.mirrored,
                       {irradiance.x(), irradiance.y(), irradiance.z(), 0}});
    }
  }
  const AtlasLayer& layer = layer_of(atlas, drop.oscillation);
  add_sky(atlas, layer, view, weight * transmitted, sky, cells);
  cells.push_back({&layer.coverage.at(0), cell_rect(atlas, view, 0, 0), false, {0, 0, 0, weight}});
  add_cells(cells, picture);
  return picture;
}

struct PlacedDrop {
  const Drop* drop;
  StreakPlacement placement;
};

// Farthest first.
std::vector<PlacedDrop> placed_drops(const Scene& scene, const StreakAtlas& atlas,
                                     const std::vector<Drop>& drops) {
  const StreakGeometry geometry = streak_geometry(atlas);
  std::vector<PlacedDrop> placed;
  for (const Drop& drop : drops) {
    const int segments = segment_times(scene.camera.exposure_s, drop.r0_m, geometry).count;
    for (int segment = 0; segment < segments; ++segment) {
      if (auto placement = place_streak(scene, drop, geometry, segment)) {
        placed.push_back({&drop, std::move(*placement)});
      }
    }
  }
  std::sort(placed.begin(), placed.end(), [](const PlacedDrop& a, const PlacedDrop& b) {
    if (a.placement.depth_m != b.placement.depth_m) {
      return a.placement.depth_m > b.placement.depth_m;
    }
    return a.drop->id < b.drop->id;  // segments of one drop differ in depth, or do not overlap
  });
  return placed;
}

// air_per_m: extinction between the camera and the drop.
Footprint drop_footprint(const StreakAtlas& atlas, const PlacedDrop& placed, double air_per_m,
                         const SkyLight& sky, const Lookup& lookup, const Image& screen) {
  const StreakPlacement& placement = placed.placement;
  const CellMix cells = mix_cells(
      atlas, lookup.rows,
      fold_angles(placement.view_elevation_deg, 0, 0, placed.drop->oscillation, views_below(atlas)),
      lookup.mode);
  std::vector<StreakPicture> pictures;
  for (int i = 0; i < 2; ++i) {
    const auto& view = atlas.views[static_cast<std::size_t>(cells.view[i])];
    if (cells.view_weight[i] == 0) continue;
    pictures.push_back({.width = atlas.cell_width_px,
                        .height = view.height_px,
                        .path_top_row = view.path_top_row,
                        .path_rows = view.path_bottom_row - view.path_top_row});
  }
  Footprint footprint = empty_footprint(placement, pictures, screen.width, screen.height);
  if (footprint.values.empty()) return footprint;
  const SkyLight seen = sky_seen(sky, placement, atlas);
  for (int i = 0; i < 2; ++i) {
    if (cells.view_weight[i] == 0) continue;
    const double weight = cells.view_weight[i] * placement.time_share;
    add_streak(placement,
               lit_picture(atlas, *placed.drop, placement, cells.view[i], weight,
                           std::exp(-air_per_m * placement.distance_m), seen, lookup),
               footprint);
  }
  return footprint;
}

// Puts the drop over what lies behind it; the pixels where it does.
StreakMask put_over(const Footprint& drop, double drop_depth_m, const Image& depth_m,
                    std::vector<Eigen::Vector3d>& color) {
  StreakMask mask = mask_of(drop);
  for (int y = 0; y < drop.height; ++y) {
    for (int x = 0; x < drop.width; ++x) {
      const auto i = static_cast<std::size_t>(y * drop.width + x);
      const int screen_x = drop.x0 + x, screen_y = drop.y0 + y;
      mask.touched[i] = mask.touched[i] && drop_depth_m < depth_m.at(screen_x, screen_y);
      if (!mask.touched[i]) continue;
      const StreakValue& value = drop.values[i];
      Eigen::Vector3d& below = color[static_cast<std::size_t>(screen_y * depth_m.width + screen_x)];
      below = (1 - value.w()) * below + value.head<3>().cwiseMax(0);  // raytrace/sky_light.h
    }
  }
  return mask;
}

void require_picture(const Image& image, const Camera& camera, int channels, bool infinity_is_good,
                     const char* name) {
  const auto size = static_cast<std::size_t>(camera.width_px) *
                    static_cast<std::size_t>(camera.height_px) * static_cast<std::size_t>(channels);
  if (image.width != camera.width_px || image.height != camera.height_px ||
      image.channels != channels || image.values.size() != size) {
    throw std::runtime_error(fmt::format(
        "{}: {} x {} pixels, {} channels; expected the camera's {} x {} and {}", name, image.width,
        image.height, image.channels, camera.width_px, camera.height_px, channels));
  }
  for (const float value : image.values) {
    if (std::isfinite(value) || (infinity_is_good && value > 0)) continue;
    throw std::runtime_error(fmt::format("{}: a pixel is {}; expected finite values{}", name, value,
                                         infinity_is_good ? " or +infinity" : ""));
  }
}

}  // namespace

SkyLight sky_of(const Scene& scene, const StreakAtlas& atlas, int most_degree) {
  const EnvironmentLight& environment = scene.environment;
  const std::optional<Image> map = posed_map(environment);
  if (!map) return sky_light(environment, nullptr, 0);
  return sky_light(environment, &*map, std::max(0, std::min(most_degree, atlas.transfer_degree)));
}

FrameComposite composite_frame(const Scene& scene, const StreakAtlas& atlas,
                               const std::vector<Drop>& drops, const SkyLight& sky,
                               const Image& background, const Image& depth_m, LookupMode mode) {
  for (const Light& light : scene.lights) {
    if (light.shadow)
      throw std::runtime_error(
          fmt::format("light \"{}\" casts shadows; expected none: the composite does not know them",
                      light.name));
  }
  require_picture(background, scene.camera, 3, false, "background");
  require_picture(depth_m, scene.camera, 1, true, "depth");
  std::vector<Eigen::Vector3d> color(depth_m.values.size());
  for (std::size_t i = 0; i < color.size(); ++i) {
    color[i] = Eigen::Vector3f(&background.values[3 * i]).cast<double>();
  }
  FrameComposite result{make_image(background.width, background.height, 3),
                        make_image(background.width, background.height, 3)};
  // Batches bound the memory; within one the footprints are made in parallel, then laid down in
  // order.
  const std::vector<PlacedDrop> placed = placed_drops(scene, atlas, drops);
  const double air = air_per_m(scene);
  const Lookup lookup = {mode, light_rows(atlas)};
  constexpr std::size_t batch = 512;
  std::vector<Footprint> footprints(batch);
  for (std::size_t begin = 0; begin < placed.size(); begin += batch) {
    const std::size_t end = std::min(begin + batch, placed.size());
    tbb::parallel_for(begin, end, [&](std::size_t i) {
      footprints[i - begin] = drop_footprint(atlas, placed[i], air, sky, lookup, depth_m);
    });
    for (std::size_t i = begin; i < end; ++i) {
      const double drop_depth_m = placed[i].placement.depth_m;
      StreakMask mask = put_over(footprints[i - begin], drop_depth_m, depth_m, color);
      const auto& touched = mask.touched;
      if (std::find(touched.begin(), touched.end(), true) == touched.end()) continue;
      ++result.drops_seen;
      result.streaks.push_back(std::move(mask));
    }
  }
  for (std::size_t i = 0; i < 3 * color.size(); ++i) {
    const double value = color[i / 3][static_cast<Eigen::Index>(i % 3)];
    result.color.values[i] = static_cast<float>(value);
    result.rain.values[i] = static_cast<float>(value - background.values[i]);
  }
  return result;
}

}  // namespace pluvia
