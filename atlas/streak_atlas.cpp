#include "atlas/streak_atlas.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <numbers>
#include <set>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "atlas/atlas_layout.h"
#include "atlas/atomic_file.h"
#include "atlas/rec709.h"

namespace pluvia {
namespace {

constexpr const char* generate_again = "run `pluvia generate` again";

struct Grid {  // what a database must hold: every oscillation at every view
  std::string manifest_file = {};
  int diameter_um = 0;
  std::set<int> oscillations = {};
  std::set<int> views = {};
};

const ShardRecord& record_of(const Manifest& manifest, const Grid& grid, int oscillation,
                             int view) {
  const ShardKey key = {
      .diameter_um = grid.diameter_um, .oscillation = oscillation, .view_elevation_deg = view};
  const auto found = std::find_if(manifest.shards.begin(), manifest.shards.end(),
                                  [&](const ShardRecord& record) { return record.key == key; });
  if (found == manifest.shards.end()) {
    throw std::runtime_error(fmt::format(
        "{}: shard {} is missing; expected each of {} oscillations at each of {} views. {}",
        grid.manifest_file, shard_name(key), grid.oscillations.size(), grid.views.size(),
        generate_again));
  }
  return *found;
}

// The diameter to pack, of those that have shards.
int chosen_diameter(const Grid& grid, const Manifest& manifest, int wanted_um) {
  std::set<int> diameters;
  for (const ShardRecord& record : manifest.shards) diameters.insert(record.key.diameter_um);
  if (wanted_um == 0 && diameters.size() == 1) return *diameters.begin();
  if (diameters.contains(wanted_um)) return wanted_um;
  throw std::runtime_error(fmt::format(
      "{}: diameters {} um; expected {}", grid.manifest_file, fmt::join(diameters, ", "),
      wanted_um == 0 ? "one diameter, or the choice of one with --diameter-mm"
                     : fmt::format("{} um among them", wanted_um)));
}

Grid grid_of(const std::string& folder, const Manifest& manifest, int wanted_um) {
  Grid grid = {.manifest_file = (std::filesystem::path(folder) / "manifest.json").string()};
  if (manifest.shards.empty()) {
    throw std::runtime_error(grid.manifest_file + ": no shards; expected at least one");
  }
  grid.diameter_um = chosen_diameter(grid, manifest, wanted_um);
  for (const ShardRecord& record : manifest.shards) {
    if (record.key.diameter_um != grid.diameter_um) continue;
    grid.oscillations.insert(record.key.oscillation);
    grid.views.insert(record.key.view_elevation_deg);
  }
  return grid;
}

// The tables that are known before any picture is read; lights follow from the first shard.
StreakAtlas empty_atlas(const Manifest& manifest, const Grid& grid) {
  const ShardRecord& first =
      record_of(manifest, grid, *grid.oscillations.begin(), *grid.views.begin());
  const SizeRecord size = size_of(manifest, grid.diameter_um);
  if (!is_power_of_two(first.width_px)) {
    throw std::runtime_error(fmt::format("{}: width_px = {} of shard {}; expected a power of two",
                                         grid.manifest_file, first.width_px,
                                         shard_name(first.key)));
  }
  StreakAtlas atlas = {.cell_width_px = first.width_px,
                       .levels = 1,
                       .diameter_um = first.key.diameter_um,
                       .mean_radius_m = size.mean_radius_m,
                       .exposure_s = size.span_s,
                       .fall_speed_m_s = size.fall_speed_m_s,
                       .pixel_m = size.pixel_m,
                       .database_sha256 = sha256(read_file(grid.manifest_file))};
  while (first.width_px >> atlas.levels >= 1) ++atlas.levels;
  for (const int view : grid.views) {
    const ShardRecord& record = record_of(manifest, grid, first.key.oscillation, view);
    atlas.views.push_back({.elevation_deg = view,
                           .height_px = record.height_px,
                           .row_px = rows_of_views(atlas),
                           .path_top_row = record.path_top_row,
                           .path_bottom_row = record.path_bottom_row});
  }
  return atlas;
}

// A shard must look like those packed before it: a reader has one table for all layers.
void check_record(const StreakAtlas& atlas, const AtlasView& view, const Grid& grid,
                  const ShardRecord& record) {
  const bool same = record.width_px == atlas.cell_width_px && record.height_px == view.height_px &&
                    record.path_top_row == view.path_top_row &&
                    record.path_bottom_row == view.path_bottom_row;
  if (same) return;
  throw std::runtime_error(fmt::format(
      "{}: shard {}: {} x {} pixels, path rows {} .. {}; expected {} x {}, {} .. {} like the other "
      "oscillations at this view",
      grid.manifest_file, shard_name(record.key), record.width_px, record.height_px,
      record.path_top_row, record.path_bottom_row, atlas.cell_width_px, view.height_px,
      view.path_top_row, view.path_bottom_row));
}

// The weight of each band in the one picture that is packed.
std::vector<double> band_weights(const std::string& file, const std::string& wanted,
                                 const std::vector<std::string>& bands) {
  if (wanted.empty() && bands.size() == 1) return {1};
  if (wanted.empty() && bands == std::vector<std::string>{"B", "G", "R"}) {
    return {rec709_luminance[2], rec709_luminance[1], rec709_luminance[0]};
  }
  const auto found = std::find(bands.begin(), bands.end(), wanted);
  if (found == bands.end()) {
    throw std::runtime_error(
        fmt::format("{}: bands {}; expected {}", file, fmt::join(bands, ", "),
                    wanted.empty() ? "one, or R, G and B, or the choice of one with --band"
                                   : fmt::format("\"{}\" among them", wanted)));
  }
  std::vector<double> weights(bands.size(), 0.0);
  weights[static_cast<std::size_t>(found - bands.begin())] = 1;
  return weights;
}

void mix_bands(const std::vector<double>& weights, std::vector<float>& values) {
  const std::size_t count = values.size() / weights.size();
  for (std::size_t i = 0; i < count; ++i) {
    double sum = 0;
    for (std::size_t k = 0; k < weights.size(); ++k) sum += weights[k] * values[k * count + i];
    values[i] = static_cast<float>(sum);
  }
  values.resize(count);
}

// -1 for none.
int transfer_degree_of(const Shard& shard) {
  return static_cast<int>(std::lround(std::sqrt(static_cast<double>(shard.transfer.size())))) - 1;
}

// Lights, the presence of an environment and the number of harmonics are those of the first shard;
// the others must agree.
void check_parts(StreakAtlas& atlas, bool has_env, const std::string& file, const Shard& shard) {
  if (atlas.lights.empty()) {
    atlas.lights = shard.lights;
    atlas.transfer_degree = transfer_degree_of(shard);
  }
  if (shard.lights.empty() || shard.lights != atlas.lights) {
    throw std::runtime_error(fmt::format(
        "{}: {} light directions; expected the same {} as in the first shard, at least one", file,
        shard.lights.size(), atlas.lights.size()));
  }
  if (shard.env.mean.empty() == has_env) {
    throw std::runtime_error(fmt::format("{}: part env is {}; expected it in all shards or in none",
                                         file, has_env ? "missing" : "there"));
  }
  if (transfer_degree_of(shard) != atlas.transfer_degree) {
    throw std::runtime_error(
        fmt::format("{}: transfer of degree {} (-1: none); expected {} as in the first shard", file,
                    transfer_degree_of(shard), atlas.transfer_degree));
  }
}

void put_cell(Image& picture, const CellRect& cell, const StreakImage& image) {
  for (int y = 0; y < cell.height; ++y) {
    const auto row = image.mean.begin() + static_cast<std::ptrdiff_t>(y) * cell.width;
    std::copy_n(row, cell.width, &picture.at(cell.x, cell.y + y));
  }
}

// Cells start at multiples of 2^(levels-1), so no 2 x 2 block mixes two of them. Summed in double:
// the only rounding of a level is that of its own texels.
Image half_size(const Image& picture) {
  Image half = make_image(picture.width / 2, picture.height / 2);
  for (int y = 0; y < half.height; ++y) {
    for (int x = 0; x < half.width; ++x) {
      const double sum = static_cast<double>(picture.at(2 * x, 2 * y)) +
                         picture.at(2 * x + 1, 2 * y) + picture.at(2 * x, 2 * y + 1) +
                         picture.at(2 * x + 1, 2 * y + 1);
      half.at(x, y) = static_cast<float>(sum / 4);
    }
  }
  return half;
}

void add_mips(std::vector<Image>& pictures, int levels) {
  while (!pictures.empty() && static_cast<int>(pictures.size()) < levels) {
    pictures.push_back(half_size(pictures.back()));
  }
}

StreakImage times(StreakImage image, double factor) {
  for (float& value : image.mean) value = static_cast<float>(factor * static_cast<double>(value));
  return image;
}

bool has_orders(const Manifest& manifest) {
  return nlohmann::json::parse(manifest.parameters).contains("max_order");
}

void put_shard(const StreakAtlas& atlas, AtlasLayer& layer, int view, const Shard& shard) {
  const int rows = rows_of_views(atlas);
  if (layer.coverage.empty()) {
    const int columns = static_cast<int>(atlas.lights.size());
    layer.point.push_back(make_image(columns * atlas.cell_width_px, rows));
    layer.coverage.push_back(make_image(atlas.cell_width_px, rows));
    if (!shard.env.mean.empty()) layer.env.push_back(make_image(atlas.cell_width_px, rows));
    const int harmonics = static_cast<int>(shard.transfer.size());
    if (harmonics > 0) layer.transfer.push_back(make_image(harmonics * atlas.cell_width_px, rows));
  }
  for (std::size_t i = 0; i < shard.light.size(); ++i) {
    put_cell(layer.point[0], cell_rect(atlas, view, static_cast<int>(i), 0), shard.light[i]);
  }
  const CellRect cell = cell_rect(atlas, view, 0, 0);
  if (!layer.env.empty())
    put_cell(layer.env[0], cell, atlas.rest_from_sky ? shard.coverage : shard.env);
  put_cell(layer.coverage[0], cell, shard.coverage);
  for (std::size_t i = 0; i < shard.transfer.size(); ++i) {
    put_cell(layer.transfer[0], cell_rect(atlas, view, static_cast<int>(i), 0), shard.transfer[i]);
  }
  if (atlas.rest_from_sky && !shard.transfer.empty())  // Y_00 is 1 / sqrt(4 pi)
    put_cell(layer.transfer[0], cell, times(shard.coverage, 0.5 / std::sqrt(std::numbers::pi)));
}

}  // namespace

void keep_one_band(const std::string& file, const std::string& wanted, Shard& shard) {
  const std::vector<double> weights = band_weights(file, wanted, shard.bands);
  if (shard.bands.size() == 1) return;
  for (StreakImage& image : shard.light) mix_bands(weights, image.mean);
  for (StreakImage& image : shard.transfer) mix_bands(weights, image.mean);
  mix_bands(weights, shard.env.mean);
}

std::vector<int> set_numbers(const StreakAtlas& atlas) {
  std::vector<int> numbers;
  for (const AtlasLayer& layer : atlas.layers) numbers.push_back(layer.oscillation);
  return numbers;
}

StreakAtlas places_of(const StreakAtlas& atlas) {
  return {.cell_width_px = atlas.cell_width_px,
          .levels = atlas.levels,
          .diameter_um = atlas.diameter_um,
          .mean_radius_m = atlas.mean_radius_m,
          .exposure_s = atlas.exposure_s,
          .fall_speed_m_s = atlas.fall_speed_m_s,
          .pixel_m = atlas.pixel_m,
          .database_sha256 = atlas.database_sha256,
          .views = atlas.views,
          .strokes = atlas.strokes};
}

CellRect cell_rect(const StreakAtlas& atlas, int view, int column, int level) {
  assert(view >= 0 && view < static_cast<int>(atlas.views.size()) && column >= 0);
  assert(level >= 0 && level < atlas.levels);
  const AtlasView& row = atlas.views[static_cast<std::size_t>(view)];
  const int width = atlas.cell_width_px >> level;
  return {.x = column * width,
          .y = row.row_px >> level,
          .width = width,
          .height = (row.height_px + (1 << level) - 1) >> level};
}

AtlasCell finest_cell(const StreakAtlas& atlas, int layer, int cell, int sky_cells) {
  assert(cell >= 0 && cell < cells_per_layer(atlas, sky_cells));
  const AtlasLayer& set = atlas.layers.at(static_cast<std::size_t>(layer));
  const int lights = static_cast<int>(atlas.lights.size());
  const auto picture = [&](const std::vector<Image>& levels, const char* kind) -> const Image& {
    if (!levels.empty()) return levels.front();
    throw std::runtime_error(fmt::format("atlas: oscillation {} has no picture of {}; expected one",
                                         set.oscillation, kind));
  };
  if (cell < lights) return {picture(set.point, "point light"), cell};
  if (cell == lights + sky_cells) return {picture(set.coverage, "coverage"), 0};
  if (sky_cells == 1) return {picture(set.env, "environment"), 0};
  return {picture(set.transfer, "harmonics"), cell - lights};
}

StreakAtlas pack_database(const std::string& database_folder, const PackOptions& options) {
  const Manifest manifest = read_manifest(database_folder);
  const Grid grid = grid_of(database_folder, manifest, options.diameter_um);
  StreakAtlas atlas = empty_atlas(manifest, grid);
  atlas.rest_from_sky = options.rest_from_sky && has_orders(manifest);
  for (const int oscillation : grid.oscillations) {
    AtlasLayer layer = {.oscillation = oscillation};
    for (std::size_t view = 0; view < atlas.views.size(); ++view) {
      const ShardRecord& record =
          record_of(manifest, grid, oscillation, atlas.views[view].elevation_deg);
      check_record(atlas, atlas.views[view], grid, record);
      Shard shard = read_whole_shard(database_folder, record);
      keep_one_band((std::filesystem::path(database_folder) / record.file).string(), options.band,
                    shard);
      const bool first = atlas.layers.empty() && view == 0;
      const AtlasLayer& model = atlas.layers.empty() ? layer : atlas.layers.front();
      const bool has_env = first ? !shard.env.mean.empty() : !model.env.empty();
      check_parts(atlas, has_env, (std::filesystem::path(database_folder) / record.file).string(),
                  shard);
      put_shard(atlas, layer, static_cast<int>(view), shard);
    }
    add_mips(layer.point, atlas.levels);
    add_mips(layer.env, atlas.levels);
    add_mips(layer.coverage, atlas.levels);
    add_mips(layer.transfer, atlas.levels);
    atlas.layers.push_back(std::move(layer));
  }
  return atlas;
}

}  // namespace pluvia
