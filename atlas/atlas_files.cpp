// The atlas on disk. Layers are written first and atlas.json, which holds their hashes, last: an
// interrupted rewrite shows as a layer that does not belong to its table.

#include <filesystem>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "atlas/atlas_layout.h"
#include "atlas/atomic_file.h"
#include "atlas/exr_parts.h"
#include "atlas/json_place.h"
#include "atlas/streak_atlas.h"

namespace pluvia {
namespace {

constexpr const char* pack_again = "run `pluvia pack` again";
constexpr int highest_size_px = 1 << 20;
constexpr int highest_transfer_degree = 8;  // that a preset can ask for

std::string path_in(const std::string& folder, const std::string& name) {
  return (std::filesystem::path(folder) / name).string();
}

std::string layer_name(int oscillation) {
  return fmt::format("osc{:02d}.exr", oscillation);
}

void add_parts(std::vector<ExrPart>& parts, const char* kind, const std::vector<Image>& pictures) {
  for (std::size_t level = 0; level < pictures.size(); ++level) {
    parts.push_back({.name = fmt::format("{}_mip{}", kind, level),
                     .width = pictures[level].width,
                     .height = pictures[level].height,
                     .channels = {{.name = "Y", .values = pictures[level].values}}});
  }
}

std::string layer_bytes(const std::string& file, const AtlasLayer& layer) {
  std::vector<ExrPart> parts;
  add_parts(parts, "point", layer.point);
  add_parts(parts, "env", layer.env);
  add_parts(parts, "coverage", layer.coverage);
  for (const ExrPart& part : parts) check_radiances(file, part);
  const std::size_t positive = parts.size();
  add_parts(parts, "transfer", layer.transfer);
  for (std::size_t i = positive; i < parts.size(); ++i) check_signed_values(file, parts[i]);
  return exr_bytes(parts);
}

nlohmann::ordered_json tables_of(const StreakAtlas& atlas) {
  nlohmann::ordered_json document = {{"version", StreakAtlas::version},
                                     {"cell_width_px", atlas.cell_width_px},
                                     {"levels", atlas.levels},
                                     {"diameter_um", atlas.diameter_um},
                                     {"mean_radius_m", atlas.mean_radius_m},
                                     {"exposure_s", atlas.exposure_s},
                                     {"fall_speed_m_s", atlas.fall_speed_m_s},
                                     {"pixel_m", atlas.pixel_m},
                                     {"database_sha256", atlas.database_sha256},
                                     {"lights", nlohmann::ordered_json::array()},
                                     {"views", nlohmann::ordered_json::array()},
                                     {"layers", nlohmann::ordered_json::array()}};
  if (atlas.rest_from_sky) document["rest_from_sky"] = true;
  if (atlas.transfer_degree >= 0) document["transfer_degree"] = atlas.transfer_degree;
  for (const LightDirection& light : atlas.lights) {
    document["lights"].push_back(
        {{"elevation_deg", light.elevation_deg}, {"azimuth_deg", light.azimuth_deg}});
  }
  for (const AtlasView& view : atlas.views) {
    document["views"].push_back({{"elevation_deg", view.elevation_deg},
                                 {"height_px", view.height_px},
                                 {"row_px", view.row_px},
                                 {"path_top_row", view.path_top_row},
                                 {"path_bottom_row", view.path_bottom_row}});
  }
  return document;
}

void read_views(const JsonPlace& document, StreakAtlas& atlas) {
  for (const JsonPlace& place : elements(member(document, "views"))) {
    const int lowest = atlas.views.empty() ? -90 : atlas.views.back().elevation_deg + 1;
    const int row = rows_of_views(atlas);
    atlas.views.push_back({.elevation_deg = integer_at(member(place, "elevation_deg"), lowest, 90),
                           .height_px = integer_at(member(place, "height_px"), 1, highest_size_px),
                           .row_px = integer_at(member(place, "row_px"), row, row),
                           .path_top_row = number_at(member(place, "path_top_row")),
                           .path_bottom_row = number_at(member(place, "path_bottom_row"))});
    const AtlasView& view = atlas.views.back();
    if (!(view.path_bottom_row > view.path_top_row))
      throw_at(member(place, "path_bottom_row"),
               fmt::format("{}; expected more than path_top_row {}", view.path_bottom_row,
                           view.path_top_row));
  }
  if (atlas.views.empty()) throw_at(member(document, "views"), "empty; expected at least one view");
}

void read_lights(const JsonPlace& document, StreakAtlas& atlas) {
  for (const JsonPlace& place : elements(member(document, "lights"))) {
    atlas.lights.push_back({.elevation_deg = integer_at(member(place, "elevation_deg"), -90, 90),
                            .azimuth_deg = integer_at(member(place, "azimuth_deg"), 0, 180)});
  }
  if (atlas.lights.empty())
    throw_at(member(document, "lights"), "empty; expected at least one light");
}

StreakAtlas tables_at(const JsonPlace& document) {
  const int any = std::numeric_limits<int>::max();
  StreakAtlas atlas;
  atlas.cell_width_px = integer_at(member(document, "cell_width_px"), 1, highest_size_px);
  if (!is_power_of_two(atlas.cell_width_px)) {
    throw_at(member(document, "cell_width_px"),
             fmt::format("{}; expected a power of two", atlas.cell_width_px));
  }
  int most_levels = 1;
  while (atlas.cell_width_px >> most_levels >= 1) ++most_levels;
  atlas.levels = integer_at(member(document, "levels"), 1, most_levels);
  atlas.diameter_um = integer_at(member(document, "diameter_um"), 1, any);
  atlas.mean_radius_m = positive_at(member(document, "mean_radius_m"));
  atlas.exposure_s = positive_at(member(document, "exposure_s"));
  atlas.fall_speed_m_s = positive_at(member(document, "fall_speed_m_s"));
  atlas.pixel_m = positive_at(member(document, "pixel_m"));
  atlas.database_sha256 = text_at(member(document, "database_sha256"));
  if (document.value->contains("rest_from_sky"))
    atlas.rest_from_sky = truth_at(member(document, "rest_from_sky"));
  if (document.value->contains("transfer_degree"))
    atlas.transfer_degree =
        integer_at(member(document, "transfer_degree"), 0, highest_transfer_degree);
  read_lights(document, atlas);
  read_views(document, atlas);
  return atlas;
}

// The `levels` pictures of one kind, from the front of parts.
std::vector<Image> take_pictures(const std::string& file, std::vector<ExrPart>& parts,
                                 const char* kind, const StreakAtlas& atlas, int columns) {
  std::vector<Image> pictures;
  for (int level = 0; level < atlas.levels; ++level) {
    const std::string name = fmt::format("{}_mip{}", kind, level);
    const std::int64_t width = std::int64_t{columns} * atlas.cell_width_px >> level;
    const int height = rows_of_views(atlas) >> level;
    if (parts.empty() || parts.front().name != name || parts.front().width != width ||
        parts.front().height != height || parts.front().channels.size() != 1 ||
        parts.front().channels[0].name != "Y") {
      throw std::runtime_error(fmt::format(
          "{}: part {}: missing or of another shape; expected {} x {} pixels, channel Y. {}", file,
          name, width, height, pack_again));
    }
    if (std::string_view(kind) == "transfer")
      check_signed_values(file, parts.front());
    else
      check_radiances(file, parts.front());
    pictures.push_back({.width = static_cast<int>(width),
                        .height = height,
                        .channels = 1,
                        .values = std::move(parts.front().channels[0].values)});
    parts.erase(parts.begin());
  }
  return pictures;
}

AtlasLayer read_layer(const std::string& folder, const JsonPlace& place, const StreakAtlas& atlas) {
  const int lowest = atlas.layers.empty() ? 0 : atlas.layers.back().oscillation + 1;
  AtlasLayer layer = {.oscillation = integer_at(member(place, "oscillation"), lowest,
                                                std::numeric_limits<int>::max())};
  const std::string file = path_in(folder, text_at(member(place, "file")));
  const std::string bytes = read_file(file);
  std::vector<ExrPart> parts = parse_exr(file, bytes);
  const int columns = static_cast<int>(atlas.lights.size());
  layer.point = take_pictures(file, parts, "point", atlas, columns);
  if (!parts.empty() && parts.front().name == "env_mip0") {
    layer.env = take_pictures(file, parts, "env", atlas, 1);
  }
  layer.coverage = take_pictures(file, parts, "coverage", atlas, 1);
  if (atlas.transfer_degree >= 0) {
    const int harmonics = (atlas.transfer_degree + 1) * (atlas.transfer_degree + 1);
    layer.transfer = take_pictures(file, parts, "transfer", atlas, harmonics);
  }
  if (!parts.empty()) {
    throw std::runtime_error(fmt::format(
        "{}: part {}: unknown; expected point, env, coverage and what atlas.json names only", file,
        parts.front().name));
  }
  if (sha256(bytes) != text_at(member(place, "sha256"))) {
    throw std::runtime_error(fmt::format(
        "{}: SHA-256 is not that of atlas.json; expected files of one run. {}", file, pack_again));
  }
  return layer;
}

}  // namespace

void write_atlas(const std::string& folder, const StreakAtlas& atlas) {
  make_folder(folder);
  nlohmann::ordered_json document = tables_of(atlas);
  for (const AtlasLayer& layer : atlas.layers) {
    const std::string name = layer_name(layer.oscillation);
    const std::string bytes = layer_bytes(path_in(folder, name), layer);
    write_file_atomically(path_in(folder, name), bytes);
    document["layers"].push_back(
        {{"oscillation", layer.oscillation}, {"file", name}, {"sha256", sha256(bytes)}});
  }
  write_file_atomically(path_in(folder, "atlas.json"), document.dump(2) + "\n");
}

StreakAtlas read_atlas(const std::string& folder) {
  const std::string file = path_in(folder, "atlas.json");
  const nlohmann::ordered_json document = parse_json(file, read_file(file));
  const JsonPlace root = {.value = &document, .file = file};
  check_version(root, StreakAtlas::version);
  StreakAtlas atlas = tables_at(root);
  const JsonPlace layers = member(root, "layers");
  for (const JsonPlace& place : elements(layers)) {
    atlas.layers.push_back(read_layer(folder, place, atlas));
  }
  if (atlas.layers.empty()) throw_at(layers, "empty; expected at least one layer");
  return atlas;
}

}  // namespace pluvia
