// The manifest of a streak database: manifest.json to struct and back.

#include <algorithm>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <tuple>

#include <fmt/format.h>

#include "atlas/atomic_file.h"
#include "atlas/json_place.h"
#include "atlas/streak_database.h"

namespace pluvia {
namespace {

constexpr const char* generate_again = "run `pluvia generate` again";
constexpr int highest_size_px =
    1 << 20;  // beyond any picture; keeps products of two within 64 bits

std::string manifest_file(const std::string& folder) {
  return (std::filesystem::path(folder) / "manifest.json").string();
}

nlohmann::ordered_json json_of(const ShardRecord& record) {
  return {{"file", record.file},
          {"sha256", record.sha256},
          {"diameter_um", record.key.diameter_um},
          {"oscillation", record.key.oscillation},
          {"view_elevation_deg", record.key.view_elevation_deg},
          {"width_px", record.width_px},
          {"height_px", record.height_px},
          {"path_top_row", record.path_top_row},
          {"path_bottom_row", record.path_bottom_row},
          {"images", record.images},
          {"estimated_relative_error", record.estimated_relative_error}};
}

ShardRecord record_at(const JsonPlace& place) {
  const int any = std::numeric_limits<int>::max();
  ShardRecord record;
  record.file = text_at(member(place, "file"));
  record.sha256 = text_at(member(place, "sha256"));
  if (record.sha256.size() != 64) {
    throw_at(member(place, "sha256"), "\"" + record.sha256 + "\"; expected 64 hexadecimal digits");
  }
  record.key = {.diameter_um = integer_at(member(place, "diameter_um"), 1, any),
                .oscillation = integer_at(member(place, "oscillation"), 0, any),
                .view_elevation_deg = integer_at(member(place, "view_elevation_deg"), -90, 90)};
  record.width_px = integer_at(member(place, "width_px"), 1, highest_size_px);
  record.height_px = integer_at(member(place, "height_px"), 1, highest_size_px);
  record.path_top_row = number_at(member(place, "path_top_row"));
  record.path_bottom_row = number_at(member(place, "path_bottom_row"));
  for (const JsonPlace& image : elements(member(place, "images"))) {
    record.images.push_back(text_at(image));
  }
  const JsonPlace errors = member(place, "estimated_relative_error");
  for (const JsonPlace& error : elements(errors)) {
    record.estimated_relative_error.push_back(number_at(error));
  }
  if (record.estimated_relative_error.size() != record.images.size()) {
    throw_at(errors, fmt::format("{} numbers; expected one for each of {} images",
                                 record.estimated_relative_error.size(), record.images.size()));
  }
  return record;
}

nlohmann::ordered_json json_of(const SizeRecord& size) {
  return {{"diameter_um", size.diameter_um},
          {"mean_radius_m", size.mean_radius_m},
          {"fall_speed_m_s", size.fall_speed_m_s},
          {"span_s", size.span_s},
          {"pixel_m", size.pixel_m}};
}

nlohmann::ordered_json json_of(const std::vector<Band>& bands) {
  auto array = nlohmann::ordered_json::array();
  for (const Band& band : bands) {
    array.push_back({{"name", band.name},
                     {"wavelength_nm", band.wavelength_nm},
                     {"refractive_index", band.refractive_index}});
  }
  return array;
}

void read_sizes(const JsonPlace& sizes, Manifest& manifest) {
  for (const JsonPlace& place : elements(sizes)) {
    const int lowest = manifest.sizes.empty() ? 1 : manifest.sizes.back().diameter_um + 1;
    manifest.sizes.push_back({.diameter_um = integer_at(member(place, "diameter_um"), lowest,
                                                        std::numeric_limits<int>::max()),
                              .mean_radius_m = positive_at(member(place, "mean_radius_m")),
                              .fall_speed_m_s = positive_at(member(place, "fall_speed_m_s")),
                              .span_s = positive_at(member(place, "span_s")),
                              .pixel_m = positive_at(member(place, "pixel_m"))});
  }
  if (manifest.sizes.empty()) throw_at(sizes, "empty; expected at least one size");
}

void read_bands(const JsonPlace& bands, Manifest& manifest) {
  for (const JsonPlace& place : elements(bands)) {
    manifest.bands.push_back({.name = text_at(member(place, "name")),
                              .wavelength_nm = positive_at(member(place, "wavelength_nm")),
                              .refractive_index = positive_at(member(place, "refractive_index"))});
    const std::size_t count = manifest.bands.size();
    if (count > 1 && manifest.bands[count - 2].name >= manifest.bands.back().name) {
      throw_at(member(place, "name"),
               "\"" + manifest.bands.back().name + "\"; expected ascending names, each once");
    }
  }
}

// One size: values of the manifest's own; several: a list.
void read_all_sizes(const JsonPlace& document, Manifest& manifest) {
  manifest.exposure_s = positive_at(member(document, "exposure_s"));
  if (document.value->contains("sizes")) {
    read_sizes(member(document, "sizes"), manifest);
    read_bands(member(document, "bands"), manifest);
    return;
  }
  manifest.mean_radius_m = positive_at(member(document, "mean_radius_m"));
  manifest.fall_speed_m_s = positive_at(member(document, "fall_speed_m_s"));
  manifest.pixel_m = positive_at(member(document, "pixel_m"));
}

void put_sizes(const Manifest& manifest, nlohmann::ordered_json& document) {
  if (manifest.sizes.empty()) {
    document["mean_radius_m"] = manifest.mean_radius_m;
    document["exposure_s"] = manifest.exposure_s;
    document["fall_speed_m_s"] = manifest.fall_speed_m_s;
    document["pixel_m"] = manifest.pixel_m;
    return;
  }
  document["exposure_s"] = manifest.exposure_s;
  document["bands"] = json_of(manifest.bands);
  document["sizes"] = nlohmann::ordered_json::array();
  for (const SizeRecord& size : manifest.sizes) document["sizes"].push_back(json_of(size));
}

bool has_size(const Manifest& manifest, int diameter_um) {
  return manifest.sizes.empty() ||
         std::any_of(manifest.sizes.begin(), manifest.sizes.end(),
                     [&](const SizeRecord& size) { return size.diameter_um == diameter_um; });
}

Manifest manifest_at(const JsonPlace& document) {
  check_version(document, Manifest::version);
  Manifest manifest;
  manifest.preset = text_at(member(document, "preset"));
  const JsonPlace parameters = member(document, "parameters");
  if (!parameters.value->is_object()) throw_at(parameters, "not an object; expected an object");
  manifest.parameters = parameters.value->dump();
  const JsonPlace seed = member(document, "seed");
  if (!seed.value->is_number_unsigned()) {
    throw_at(seed, seed.value->dump() + "; expected an integer 0 .. 2^64 - 1");
  }
  manifest.seed = seed.value->get<unsigned long long>();
  manifest.instruction_set = text_at(member(document, "instruction_set"));
  read_all_sizes(document, manifest);
  if (document.value->contains("planned")) {
    for (const JsonPlace& place : elements(member(document, "planned"))) {
      if (!manifest.planned.insert(text_at(place)).second) {
        throw_at(place, text_at(place) + " again; expected each shard once");
      }
    }
  }
  for (const JsonPlace& place : elements(member(document, "shards"))) {
    manifest.shards.push_back(record_at(place));
    const std::size_t count = manifest.shards.size();
    if (!has_size(manifest, manifest.shards.back().key.diameter_um)) {
      throw_at(member(place, "diameter_um"), fmt::format("{}; expected one of the sizes",
                                                         manifest.shards.back().key.diameter_um));
    }
    if (count > 1 && !comes_before(manifest.shards[count - 2].key, manifest.shards.back().key)) {
      throw_at(place, shard_name(manifest.shards.back().key) + " after " +
                          shard_name(manifest.shards[count - 2].key) +
                          "; expected ascending diameter, oscillation, view, each once");
    }
  }
  return manifest;
}

}  // namespace

bool comes_before(const ShardKey& a, const ShardKey& b) {
  const auto order = [](const ShardKey& key) {
    return std::tuple(key.diameter_um, key.oscillation, key.view_elevation_deg);
  };
  return order(a) < order(b);
}

SizeRecord size_of(const Manifest& manifest, int diameter_um) {
  if (manifest.sizes.empty()) {
    return {.diameter_um = diameter_um,
            .mean_radius_m = manifest.mean_radius_m,
            .fall_speed_m_s = manifest.fall_speed_m_s,
            .span_s = manifest.exposure_s,
            .pixel_m = manifest.pixel_m};
  }
  for (const SizeRecord& size : manifest.sizes) {
    if (size.diameter_um == diameter_um) return size;
  }
  throw std::invalid_argument(
      fmt::format("diameter_um = {}; expected one of the manifest's sizes", diameter_um));
}

void write_manifest(const std::string& folder, const Manifest& manifest) {
  const std::string file = manifest_file(folder);
  nlohmann::ordered_json document = {
      {"version", Manifest::version},
      {"preset", manifest.preset},
      {"parameters", parse_json(file + ": parameters", manifest.parameters)},
      {"seed", manifest.seed},
      {"instruction_set", manifest.instruction_set}};
  put_sizes(manifest, document);
  if (!manifest.planned.empty()) document["planned"] = manifest.planned;
  document["shards"] = nlohmann::ordered_json::array();
  for (const ShardRecord& record : manifest.shards) document["shards"].push_back(json_of(record));
  const std::string text = document.dump(2) + "\n";
  // What cannot be read back must not be written: a NaN has turned into null here, for one.
  const nlohmann::ordered_json again = parse_json(file, text);
  manifest_at({.value = &again, .file = file});
  write_file_atomically(file, text);
}

Manifest read_manifest(const std::string& folder) {
  const std::string file = manifest_file(folder);
  const nlohmann::ordered_json document = parse_json(file, read_file(file));
  return manifest_at({.value = &document, .file = file});
}

std::optional<ManifestDifference> first_difference(const Manifest& found,
                                                   const Manifest& expected) {
  const auto theirs = nlohmann::json::parse(found.parameters);
  const auto ours = nlohmann::json::parse(expected.parameters);
  const auto text = [](const nlohmann::json& object, const std::string& key) {
    return object.contains(key) ? object[key].dump() : "absent";
  };
  std::vector<ManifestDifference> pairs = {{"preset", found.preset, expected.preset}};
  for (const auto& item : ours.items()) {
    pairs.push_back({item.key(), text(theirs, item.key()), item.value().dump()});
  }
  for (const auto& item : theirs.items()) {
    pairs.push_back({item.key(), item.value().dump(), text(ours, item.key())});
  }
  pairs.push_back({"seed", std::to_string(found.seed), std::to_string(expected.seed)});
  pairs.push_back({"instruction_set", found.instruction_set, expected.instruction_set});
  const auto add = [&](const char* name, double a, double b) {
    pairs.push_back({name, fmt::to_string(a), fmt::to_string(b)});
  };
  add("mean_radius_m", found.mean_radius_m, expected.mean_radius_m);
  add("exposure_s", found.exposure_s, expected.exposure_s);
  add("fall_speed_m_s", found.fall_speed_m_s, expected.fall_speed_m_s);
  add("pixel_m", found.pixel_m, expected.pixel_m);
  pairs.push_back({"bands", json_of(found.bands).dump(), json_of(expected.bands).dump()});
  for (const SizeRecord& size : found.sizes) {
    if (!has_size(expected, size.diameter_um)) continue;
    pairs.push_back(
        {"size", json_of(size).dump(), json_of(size_of(expected, size.diameter_um)).dump()});
  }
  for (const ManifestDifference& pair : pairs) {
    if (pair.found != pair.expected) return pair;
  }
  return std::nullopt;
}

bool shard_is_whole(const std::string& folder, const ShardRecord& record) {
  const std::filesystem::path file = std::filesystem::path(folder) / record.file;
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return false;
  return sha256(read_file(file.string())) == record.sha256;
}

std::string whole_shard_bytes(const std::string& folder, const ShardRecord& record) {
  const std::string file = (std::filesystem::path(folder) / record.file).string();
  if (!std::filesystem::exists(file)) {
    throw std::runtime_error(fmt::format(
        "{}: missing; expected the shard that the manifest lists. {}", file, generate_again));
  }
  std::string bytes = read_file(file);
  if (sha256(bytes) != record.sha256) {
    throw std::runtime_error(fmt::format("{}: SHA-256 is not the manifest's; expected {}. {}", file,
                                         record.sha256, generate_again));
  }
  return bytes;
}

Shard read_whole_shard(const std::string& folder, const ShardRecord& record) {
  whole_shard_bytes(folder, record);
  const std::string file = (std::filesystem::path(folder) / record.file).string();
  Shard shard = read_shard(file);
  if (shard.key != record.key || shard.width_px != record.width_px ||
      shard.height_px != record.height_px) {
    throw std::runtime_error(fmt::format("{}: {} of {} x {} pixels; expected {} of {} x {}", file,
                                         shard_name(shard.key), shard.width_px, shard.height_px,
                                         shard_name(record.key), record.width_px,
                                         record.height_px));
  }
  return shard;
}

}  // namespace pluvia
