#include "atlas/refraction_masks.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "atlas/atomic_file.h"
#include "atlas/exr_parts.h"
#include "atlas/json_place.h"

namespace pluvia {
namespace {

constexpr int most = 1 << 16;  // of any count

std::string path_in(const std::string& folder, const char* name) {
  return (std::filesystem::path(folder) / name).string();
}

const std::vector<std::string>& names_of(int channels) {
  static const std::vector<std::string> one = {"Y"}, four = {"X", "Y", "Z", "W"};
  return channels == 1 ? one : four;
}

ExrPart part_of(const char* name, const Image& image) {
  ExrPart part = {.name = name, .width = image.width, .height = image.height};
  const auto channels = static_cast<std::size_t>(image.channels);
  for (std::size_t c = 0; c < channels; ++c) {
    part.channels.push_back({.name = names_of(image.channels)[c]});
    for (std::size_t i = c; i < image.values.size(); i += channels)
      part.channels.back().values.push_back(image.values[i]);
  }
  return part;
}

Image image_of(const std::string& file, const ExrPart& part, const Image& shape) {
  const auto& names = names_of(shape.channels);
  const bool fits = part.width == shape.width && part.height == shape.height &&
                    part.channels.size() == names.size();
  if (!fits)
    throw std::runtime_error(fmt::format(
        "{}: part {}: {} x {} pixels, {} channels; expected {} x {}, {} channels", file, part.name,
        part.width, part.height, part.channels.size(), shape.width, shape.height, shape.channels));
  check_signed_values(file, part);
  Image image = make_image(shape.width, shape.height, shape.channels);
  for (std::size_t c = 0; c < names.size(); ++c) {
    const auto channel =
        std::find_if(part.channels.begin(), part.channels.end(),
                     [&](const ExrChannel& known) { return known.name == names[c]; });
    if (channel == part.channels.end())
      throw std::runtime_error(
          fmt::format("{}: part {}: no channel {}; expected it", file, part.name, names[c]));
    for (std::size_t i = 0; i < channel->values.size(); ++i)
      image.values[i * names.size() + c] = channel->values[i];
  }
  return image;
}

// Width, height and channels as the tables say; no values.
Image shape_of_exits(const RefractionMasks& masks) {
  return {masks.orders * masks.size_px, static_cast<int>(mask_count(masks)) * masks.size_px, 4, {}};
}

Image shape_of_outlines(const RefractionMasks& masks, int angles) {
  return {angles, static_cast<int>(mask_count(masks)) / masks.phases * masks.instants, 1, {}};
}

std::vector<int> ascending_at(const JsonPlace& place, int lowest, int highest) {
  std::vector<int> values;
  for (const JsonPlace& element : elements(place)) {
    values.push_back(integer_at(element, lowest, highest));
    lowest = values.back() + 1;
  }
  if (values.empty()) throw_at(place, "empty; expected at least one");
  return values;
}

}  // namespace

std::size_t mask_count(const RefractionMasks& masks) {
  return masks.diameters_um.size() * masks.oscillations.size() * masks.view_elevations_deg.size() *
         static_cast<std::size_t>(masks.phases);
}

std::size_t mask_index(const RefractionMasks& masks, const MaskPlace& place) {
  const std::size_t drop = place.diameter * masks.oscillations.size() + place.oscillation;
  const std::size_t seen = drop * masks.view_elevations_deg.size() + place.view;
  return seen * static_cast<std::size_t>(masks.phases) + place.phase;
}

std::array<float, 4> mask_texel(const RefractionMasks& masks, std::size_t mask, int order,
                                int column, int row) {
  const int x = order * masks.size_px + column;
  const int y = static_cast<int>(mask) * masks.size_px + row;
  return {masks.exits.at(x, y, 0), masks.exits.at(x, y, 1), masks.exits.at(x, y, 2),
          masks.exits.at(x, y, 3)};
}

void write_refraction_masks(const std::string& folder, const RefractionMasks& masks) {
  make_folder(folder);
  const std::string bytes =
      exr_bytes({part_of("exits", masks.exits), part_of("outlines", masks.outlines)});
  write_file_atomically(path_in(folder, "masks.exr"), bytes);
  const nlohmann::ordered_json document = {{"version", RefractionMasks::version},
                                           {"size_px", masks.size_px},
                                           {"orders", masks.orders},
                                           {"phases", masks.phases},
                                           {"instants", masks.instants},
                                           {"angles", masks.outlines.width},
                                           {"refractive_index", masks.refractive_index},
                                           {"cone_half_angle_rad", masks.cone_half_angle_rad},
                                           {"diameters_um", masks.diameters_um},
                                           {"durations_s", masks.durations_s},
                                           {"oscillations", masks.oscillations},
                                           {"view_elevations_deg", masks.view_elevations_deg},
                                           {"sha256", sha256(bytes)}};
  write_file_atomically(path_in(folder, "masks.json"), document.dump(2) + "\n");
}

RefractionMasks read_refraction_masks(const std::string& folder) {
  const std::string file = path_in(folder, "masks.json");
  const nlohmann::ordered_json document = parse_json(file, read_file(file));
  const JsonPlace root = {.value = &document, .file = file};
  check_version(root, RefractionMasks::version);
  RefractionMasks masks;
  masks.size_px = integer_at(member(root, "size_px"), 1, 4096);
  masks.orders = integer_at(member(root, "orders"), 1, 16);
  masks.phases = integer_at(member(root, "phases"), 1, most);
  masks.instants = integer_at(member(root, "instants"), 1, most);
  const int angles = integer_at(member(root, "angles"), 3, most);
  masks.refractive_index = positive_at(member(root, "refractive_index"));
  masks.cone_half_angle_rad = positive_at(member(root, "cone_half_angle_rad"));
  masks.diameters_um = ascending_at(member(root, "diameters_um"), 1, 20000);
  for (const JsonPlace& place : elements(member(root, "durations_s")))
    masks.durations_s.push_back(positive_at(place));
  if (masks.durations_s.size() != masks.diameters_um.size())
    throw_at(member(root, "durations_s"),
             fmt::format("{} durations; expected {}, one for each diameter",
                         masks.durations_s.size(), masks.diameters_um.size()));
  masks.oscillations = ascending_at(member(root, "oscillations"), 0, most);
  masks.view_elevations_deg = ascending_at(member(root, "view_elevations_deg"), -90, 90);
  if (mask_count(masks) > most_masks)
    throw_at(root, fmt::format("{} masks; expected at most {}", mask_count(masks), most_masks));
  const std::string pictures = path_in(folder, "masks.exr"), bytes = read_file(pictures);
  if (sha256(bytes) != text_at(member(root, "sha256")))
    throw std::runtime_error(
        fmt::format("{}: not what {} was written for; expected its hash. run `pluvia masks` again",
                    pictures, file));
  const std::vector<ExrPart> parts = parse_exr(pictures, bytes);
  if (parts.size() != 2)
    throw std::runtime_error(fmt::format("{}: {} parts; expected 2", pictures, parts.size()));
  masks.exits = image_of(pictures, parts[0], shape_of_exits(masks));
  masks.outlines = image_of(pictures, parts[1], shape_of_outlines(masks, angles));
  return masks;
}

}  // namespace pluvia
