#include "raytrace/reference_files.h"

#include <array>
#include <cstring>
#include <span>
#include <stdexcept>
#include <type_traits>

#include <fmt/format.h>

#include "atlas/atomic_file.h"
#include "atlas/exr_parts.h"

namespace pluvia {
namespace {

constexpr const char* kind = "pluvia reference sums 2";
constexpr const char* names[] = {"R", "G", "B"};

template <typename T>
void append(std::string& bytes, const T& value) {
  static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

template <typename T>
void append_all(std::string& bytes, std::span<const T> values) {
  append(bytes, values.size());
  for (const T& value : values) append(bytes, value);
}

// The inverse: the hash before them has told that they are whole.
template <typename T>
void take(const char*& at, T& value) {
  std::memcpy(&value, at, sizeof(value));
  at += sizeof(value);
}

template <typename T>
void take_all(const char*& at, std::vector<T>& values) {
  std::size_t count = 0;
  take(at, count);
  values.resize(count);
  for (T& value : values) take(at, value);
}

template <typename Derived>
void append_matrix(std::string& bytes, const Eigen::MatrixBase<Derived>& matrix) {
  for (Eigen::Index k = 0; k < matrix.size(); ++k) append(bytes, matrix.derived().data()[k]);
}

void append_camera(std::string& bytes, const ReferenceScene& scene) {
  const Camera& camera = scene.camera;
  append_matrix(bytes, scene.frame.right);
  append_matrix(bytes, scene.frame.up);
  append_matrix(bytes, scene.frame.forward);
  append_matrix(bytes, camera.position_m);
  append(bytes, scene.frame.focal_px);
  append(bytes, camera.width_px);
  append(bytes, camera.height_px);
  append(bytes, camera.exposure_s);
  append(bytes, camera.white_cd_m2);
}

void append_mesh(std::string& bytes, const Mesh& mesh) {
  append(bytes, mesh.positions_m.size());
  for (const Eigen::Vector3f& position : mesh.positions_m) append_matrix(bytes, position);
  for (const Eigen::Vector3f& normal : mesh.normals) append_matrix(bytes, normal);
  append_all<std::uint32_t>(bytes, mesh.indices);
  append_all<std::uint32_t>(bytes, mesh.triangle_material);
  for (const Material& material : mesh.materials) {
    append_matrix(bytes, material.base_color);
    append_matrix(bytes, material.emission_cd_m2);
  }
}

void append_lights(std::string& bytes, const ReferenceScene& scene) {
  append(bytes, scene.lights.size());
  for (const Light& light : scene.lights) {
    append(bytes, light.kind);
    for (const auto& vector :
         {light.position_m, light.intensity_cd, light.direction, light.illuminance_lux})
      append_matrix(bytes, vector);
    for (const double value :
         {light.radius_m, light.inner_half_angle_deg, light.outer_half_angle_deg})
      append(bytes, value);
    append(bytes, light.shadow);
  }
  append_matrix(bytes, scene.uniform_cd_m2);
  append(bytes, scene.map.radiance.width);
  append_all<float>(bytes, scene.map.radiance.values);
}

void append_shape(std::string& bytes, const DropShape& shape) {
  append(bytes, shape.modes.size());
  for (const Mode& mode : shape.modes) {
    append(bytes, mode.n);
    append(bytes, mode.m);
    append(bytes, mode.amplitude);
    append(bytes, mode.phase_rad);
  }
  for (const double value :
       {shape.mean_radius_m, shape.phi_drop_rad, shape.density_kg_m3, shape.surface_tension_n_m})
    append(bytes, value);
  append_all<double>(bytes, shape.equilibrium_cos);
  append(bytes, shape.keep_volume);
  append(bytes, shape.keep_centroid);
}

void append_drops(std::string& bytes, const FallingDrops& drops) {
  for (const DropShape& shape : drops.shapes) append_shape(bytes, shape);
  append(bytes, drops.drops.size());
  for (const FallingDrop& drop : drops.drops) {
    append(bytes, drop.id);
    append_matrix(bytes, drop.centre_m);
    append_matrix(bytes, drop.velocity_m_s);
    append_matrix(bytes, drop.world_from_drop);
    append(bytes, drop.shape);
    append(bytes, drop.end_s);
  }
}

template <typename Sums>  // const or not
auto layers_of(Sums& sums) {
  return std::array{&sums.surface,  &sums.surface_squares, &sums.rain,      &sums.rain_squares,
                    &sums.coverage, &sums.samples,         &sums.luminance, &sums.spread};
}

template <typename Fields, typename Visit>  // const or not
void each_field(Fields& stratum, const Visit& visit) {
  visit(stratum.drop);
  for (auto& side : stratum.low) visit(side);
  for (auto& side : stratum.halvings) visit(side);
  visit(stratum.samples);
  for (auto& squares : stratum.squares) visit(squares);
}

std::string head_of(const std::string& fingerprint) {
  return fmt::format("{}\n{}\n", kind, fingerprint);
}

constexpr std::size_t hash_size = 64;  // hexadecimal digits

void add_channel(ExrPart& part, const std::string& name, const std::vector<double>& values,
                 std::size_t first, std::size_t stride) {
  ExrChannel channel = {.name = name};
  for (std::size_t i = first; i < values.size(); i += stride)
    channel.values.push_back(static_cast<float>(values[i]));
  part.channels.push_back(std::move(channel));
}

}  // namespace

void write_reference(const std::string& file, const ReferenceSums& sums) {
  const ReferenceLayer rain = layer_of(sums.rain, sums.rain_squares, sums.passes);
  ReferenceLayer whole = layer_of(sums.surface, sums.surface_squares, sums.passes);
  for (std::size_t i = 0; i < rain.mean.size(); ++i) {
    whole.mean[i] += rain.mean[i];
    whole.variance[i] += rain.variance[i];
  }
  std::vector<double> coverage = sums.coverage;
  for (double& value : coverage) value /= sums.passes;
  ExrPart part = {.name = "reference",
                  .width = sums.width,
                  .height = sums.height,
                  .attributes = {{"passes", sums.passes}}};
  for (std::size_t c = 0; c < 3; ++c) {
    add_channel(part, names[c], whole.mean, c, 3);
    add_channel(part, fmt::format("variance.{}", names[c]), whole.variance, c, 3);
    add_channel(part, fmt::format("rain.{}", names[c]), rain.mean, c, 3);
    add_channel(part, fmt::format("rain.variance.{}", names[c]), rain.variance, c, 3);
  }
  add_channel(part, "coverage", coverage, 0, 1);
  add_channel(part, "samples", sums.samples, 0, 1);
  write_file_atomically(file, exr_bytes({part}));
}

std::string reference_fingerprint(const ReferenceScene& scene, const ReferenceSettings& settings) {
  std::string bytes;
  append_camera(bytes, scene);
  append_mesh(bytes, scene.mesh);
  append_lights(bytes, scene);
  append_drops(bytes, scene.drops);
  append(bytes, scene.options.refractive_index);
  append(bytes, scene.options.cone_half_angle_rad);
  append(bytes, scene.options.split_order);
  append(bytes, scene.options.most_order);
  append(bytes, scene.options.all_shadows);
  append(bytes, scene.options.drops_see_emission);
  append(bytes, settings.learning_passes);
  append(bytes, settings.surface_samples);
  append(bytes, settings.samples_per_px);
  append(bytes, settings.seed);
  return sha256(bytes);
}

void write_sums(const std::string& file, const std::string& fingerprint,
                const ReferenceSums& sums) {
  std::string body;
  append(body, sums.width);
  append(body, sums.height);
  append(body, sums.learned);
  append(body, sums.passes);
  for (const std::vector<double>* layer : layers_of(sums)) append_all<double>(body, *layer);
  append(body, sums.strata.size());
  for (const Stratum& stratum : sums.strata) each_field(stratum, [&](auto& v) { append(body, v); });
  write_file_atomically(file, head_of(fingerprint) + sha256(body) + body);
}

ReferenceSums read_sums(const std::string& file, const std::string& fingerprint) {
  const std::string bytes = read_file(file);
  const std::string head = head_of(fingerprint);
  if (!bytes.starts_with(head))
    throw std::runtime_error(file +
                             ": sums of another picture; expected those of this scene, frame and "
                             "flags, or no such file");
  const std::size_t body_at = head.size() + hash_size;
  const bool whole =
      bytes.size() >= body_at && sha256(std::string_view(bytes).substr(body_at)) ==
                                     std::string_view(bytes).substr(head.size(), hash_size);
  if (!whole) throw std::runtime_error(file + ": damaged; expected a whole file, or none");
  const char* at = bytes.data() + body_at;
  ReferenceSums sums;
  take(at, sums.width);
  take(at, sums.height);
  take(at, sums.learned);
  take(at, sums.passes);
  for (std::vector<double>* layer : layers_of(sums)) take_all(at, *layer);
  std::size_t strata = 0;
  take(at, strata);
  sums.strata.resize(strata);
  for (Stratum& stratum : sums.strata) each_field(stratum, [&](auto& v) { take(at, v); });
  return sums;
}

}  // namespace pluvia
