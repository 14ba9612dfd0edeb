#include "raytrace/scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "oscillation/fall_speed.h"
#include "oscillation/size_distribution.h"
#include "raytrace/depth_of_field.h"
#include "raytrace/gltf_mesh.h"
#include "raytrace/moving_parts.h"
#include "raytrace/toml_reader.h"
#include "raytrace/wind_reader.h"

namespace pluvia {
namespace {

constexpr Range place_m = {-1e6, 1e6};       // beyond it a float is coarser than 6 cm
constexpr Range radiance_cd_m2 = {0, 1e10};  // the sun's disc has 1.6e9
constexpr double min_box_m = 1e-3;
constexpr Range focus_range_m = {nearest_focus_m, farthest_focus_m};

std::string absolute_beside(const std::string& file, const std::string& path) {
  return std::filesystem::absolute(path_beside(file, path)).lexically_normal().string();
}

void refuse_target_at_position(const TomlReader& reader, const std::string& name,
                               const Eigen::Vector3d& position_m, const Eigen::Vector3d& target_m) {
  if ((target_m - position_m).norm() < 1e-6)
    reader.refuse("target_m",
                  fmt::format("{0}.target_m is {0}.position_m; expected another point", name));
}

DepthOfField read_depth_of_field(TomlReader reader, double vertical_fov_deg) {
  DepthOfField lens;
  if (reader.has("f_number") == reader.has("aperture_m"))
    reader.refuse("focus_m",
                  fmt::format("depth_of_field has {} f_number and aperture_m; expected one of them",
                              reader.has("f_number") ? "both" : "neither of"));
  double f_number = 0;
  reader.optional("f_number", f_number, {0.5, 128});
  if (f_number > 0) lens.aperture_m = aperture_of_f_number_m(f_number, vertical_fov_deg);
  reader.optional("aperture_m", lens.aperture_m, {0, 1}, "m");
  reader.optional("focus_m", lens.focus_m, focus_range_m, "m");
  reader.finish();
  return lens;
}

template <class Key>
void add_key(const TomlReader& table, const std::string& name, const Key& key,
             std::vector<Key>& path) {
  if (!path.empty() && !(key.time_s >= path.back().time_s + least_key_s))
    table.refuse("time_s", fmt::format("{}.time_s = {}; expected {} s or more after the one before",
                                       name, key.time_s, least_key_s));
  path.push_back(key);
}

std::vector<CameraKey> read_camera_path(TomlReader& reader,
                                        const std::optional<DepthOfField>& lens) {
  std::vector<CameraKey> path;
  for (TomlReader& table : reader.tables("key")) {
    CameraKey key;
    table.required("time_s", key.time_s, {0, 1e7}, "s");
    table.required("position_m", key.position_m, place_m);
    table.required("target_m", key.target_m, place_m);
    if (lens) key.focus_m = lens->focus_m;
    table.optional("focus_m", key.focus_m, focus_range_m, "m");
    if (table.has("focus_m") && !lens)
      table.refuse("focus_m",
                   fmt::format("camera.key[{}].focus_m without an aperture; expected a table "
                               "[depth_of_field]",
                               path.size()));
    table.finish();
    const std::string name = fmt::format("camera.key[{}]", path.size());
    refuse_target_at_position(table, name, key.position_m, key.target_m);
    add_key(table, name, key, path);
  }
  if (path.size() == 1)
    reader.refuse("key", "camera has 1 key; expected 2 or more, or position_m and target_m");
  return path;
}

// document: may have a table [depth_of_field].
Camera read_camera(TomlReader& document, std::vector<CameraKey>& path) {
  Camera camera;
  TomlReader reader = document.table("camera");
  reader.optional("vertical_fov_deg", camera.vertical_fov_deg, {1, 150}, "deg");
  if (document.has("depth_of_field"))
    camera.depth_of_field =
        read_depth_of_field(document.table("depth_of_field"), camera.vertical_fov_deg);
  path = read_camera_path(reader, camera.depth_of_field);
  if (path.empty()) {
    reader.required("position_m", camera.position_m, place_m);
    reader.required("target_m", camera.target_m, place_m);
    refuse_target_at_position(reader, "camera", camera.position_m, camera.target_m);
  } else {
    camera.position_m = path.front().position_m;
    camera.target_m = path.front().target_m;
    if (camera.depth_of_field) camera.depth_of_field->focus_m = path.front().focus_m;
  }
  reader.optional("width_px", camera.width_px, 1, 16384);
  reader.optional("height_px", camera.height_px, 1, 16384);
  reader.optional("exposure_s", camera.exposure_s, {0, 1, true}, "s");
  reader.optional("white_cd_m2", camera.white_cd_m2, {0, 1e10, true}, "cd/m^2");
  reader.finish();
  return camera;
}

LightKind light_kind(TomlReader& reader) {
  std::string kind = "point";
  reader.optional("kind", kind);
  if (kind == "point") return LightKind::point;
  if (kind == "spot") return LightKind::spot;
  if (kind == "sun") return LightKind::sun;
  reader.refuse("kind", fmt::format("light.kind = \"{}\"; expected \"point\", \"spot\" or "
                                    "\"sun\"",
                                    kind));
}

Light read_light(TomlReader reader) {
  Light light;
  light.kind = light_kind(reader);
  reader.optional("name", light.name);
  reader.optional("shadow", light.shadow);
  if (light.kind == LightKind::sun) {
    reader.required("illuminance_lux", light.illuminance_lux, {0, 1e7});
  } else {
    reader.required("position_m", light.position_m, place_m);
    reader.required("intensity_cd", light.intensity_cd, {0, 1e9});
    reader.optional("radius_m", light.radius_m, {0, 10}, "m");
  }
  if (light.kind != LightKind::point) {
    reader.required("direction", light.direction, {-1e3, 1e3});
    if (!(light.direction.norm() > 1e-6))
      reader.refuse("direction", "light.direction is zero; expected the way the light goes");
    light.direction.normalize();
  }
  if (light.kind == LightKind::spot) {
    reader.optional("outer_half_angle_deg", light.outer_half_angle_deg, {1, 90}, "deg");
    light.inner_half_angle_deg = 0.8 * light.outer_half_angle_deg;
    reader.optional("inner_half_angle_deg", light.inner_half_angle_deg,
                    {0, light.outer_half_angle_deg}, "deg");
  }
  reader.finish();
  return light;
}

EnvironmentLight read_environment(TomlReader reader) {
  EnvironmentLight environment;
  reader.optional("map", environment.map_file);
  reader.optional("scale_cd_m2", environment.scale_cd_m2, {0, 1e10}, "cd/m^2");
  reader.optional("uniform_cd_m2", environment.uniform_cd_m2, radiance_cd_m2);
  reader.optional("frames_per_s", environment.frames_per_s, {1e-3, 1000}, "1/s");
  reader.optional("start_s", environment.start_s, {-1e6, 1e6}, "s");
  reader.finish();
  const bool map = reader.has("map");
  if (map && environment.map_file.empty())
    reader.refuse("map", "environment.map = \"\"; expected the path of a picture");
  if (map && reader.has("uniform_cd_m2"))
    reader.refuse("uniform_cd_m2", "environment has map and uniform_cd_m2; expected one of them");
  if (!map && reader.has("scale_cd_m2"))
    reader.refuse("scale_cd_m2", "environment.scale_cd_m2 without a map; expected map beside it");
  for (const char* key : {"frames_per_s", "start_s"}) {
    if (reader.has(key) && !(map && reader.has("frames_per_s")))
      reader.refuse(key, fmt::format("environment.{} without {}; expected a clip of maps", key,
                                     map ? "frames_per_s" : "a map"));
  }
  if (map) environment.map_file = absolute_beside(reader.file(), environment.map_file);
  return environment;
}

double beard_m_s(double r0_m) {
  return fall_speed_m_s(std::min(2 * r0_m, largest_diameter_m));
}

// One size, by number.
std::vector<RainSize> read_one_size(TomlReader& reader, const Eigen::Vector3d& direction,
                                    const Eigen::Vector3d& wind_m_s) {
  RainSize size;
  reader.optional("mean_radius_m", size.r0_m, {1e-5, 5e-3}, "m");
  double speed_m_s = beard_m_s(size.r0_m);
  reader.optional("fall_speed_m_s", speed_m_s, {0, 50, true}, "m/s");
  size.velocity_m_s = speed_m_s * direction + wind_m_s;
  if (reader.has("drops_per_m3")) {
    reader.required("drops_per_m3", size.drops_per_m3, {0, 1e13}, "drops/m^3");
  } else {
    double flux = 0;
    reader.required("drops_per_m2_s", flux, {0, 1e13}, "drops/(m^2 s)");
    size.drops_per_m3 = flux / -size.velocity_m_s.z();
  }
  if (size.drops_per_m3 == 0) return {};
  return {size};
}

std::vector<RainSize> read_distribution(TomlReader& reader, const Eigen::Vector3d& direction,
                                        const Eigen::Vector3d& wind_m_s, double& undrawn_per_m) {
  SizeDistribution rain;
  reader.required("rate_mm_h", rain.rate_mm_h, {0, 300}, "mm/h");
  std::string law = "marshall-palmer";
  reader.optional("distribution", law);
  if (law != "marshall-palmer" && law != "willis")
    reader.refuse("distribution",
                  fmt::format("rain.distribution = \"{}\"; expected \"marshall-palmer\" or "
                              "\"willis\"",
                              law));
  rain.law = law == "willis" ? SizeLaw::willis : SizeLaw::marshall_palmer;
  int count = 4;
  reader.optional("sizes", count, 1, 16);
  double least_mm = 0.5;
  reader.optional("least_diameter_mm", least_mm, {0.05, 6}, "mm");
  std::vector<RainSize> sizes;
  undrawn_per_m = 0;
  if (rain.rate_mm_h == 0) return sizes;
  if (rain.rate_mm_h < 0.01)
    reader.refuse("rate_mm_h", fmt::format("rain.rate_mm_h = {}; expected 0 or 0.01 .. 300 mm/h",
                                           rain.rate_mm_h));
  undrawn_per_m = extinction_per_m(rain) - extinction_per_m(rain, 1e-3 * least_mm);
  for (const SizeClass& drops : size_classes(rain, count, 1e-3 * least_mm))
    sizes.push_back({.r0_m = drops.diameter_m / 2,
                     .drops_per_m3 = drops.drops_per_m3,
                     .velocity_m_s = drops.fall_speed_m_s * direction + wind_m_s});
  return sizes;
}

void read_box(TomlReader& reader, Rain& rain) {
  reader.optional("box_min_m", rain.box_min_m, place_m);
  reader.optional("box_max_m", rain.box_max_m, place_m);
  const Eigen::Vector3d size = rain.box_max_m - rain.box_min_m;
  for (int i = 0; i < 3; ++i) {
    if (!(size[i] >= min_box_m))
      reader.refuse("box_max_m",
                    fmt::format("rain.box_max_m[{0}] = {1}; expected {2} m or more above "
                                "box_min_m[{0}] = {3}",
                                i, rain.box_max_m[i], min_box_m, rain.box_min_m[i]));
  }
}

void read_density(TomlReader& reader, Rain& rain) {
  std::string picture;
  reader.optional("density_map", picture);
  if (picture.empty()) return;
  if (!reader.has("box_min_m") || !reader.has("box_max_m"))
    reader.refuse("density_map",
                  "rain.density_map without a box; expected box_min_m and box_max_m");
  rain.density = read_density_map(absolute_beside(reader.file(), picture), rain.box_min_m.head<2>(),
                                  rain.box_max_m.head<2>(), rain.box_max_m.z());
}

// Drops that move by steps are all of those in the box, spread evenly over its top.
void refuse_endless_rain(TomlReader& reader) {
  if (!reader.has("box_min_m") || !reader.has("box_max_m"))
    reader.refuse("box_min_m",
                  "rain without a box in the wind of primitives; expected box_min_m and box_max_m");
  if (reader.has("density_map"))
    reader.refuse("density_map",
                  "rain.density_map in the wind of primitives; expected neither or one of them");
  for (const char* key : {"culling_radius_m", "local_height_m", "lost_share"}) {
    if (reader.has(key))
      reader.refuse(key,
                    fmt::format("rain.{} in the wind of primitives, where all drops of the box "
                                "are drawn; expected the box alone",
                                key));
  }
}

// What of the rain does not fall, or too fast for a closed form of 1e7 s.
void refuse_odd_velocities(const TomlReader& reader, const Rain& rain) {
  for (const RainSize& size : rain.sizes) {
    const Eigen::Vector3d& v = size.velocity_m_s;
    if (v.z() < -0.01 && v.norm() <= 200) continue;
    reader.refuse("fall_direction",
                  fmt::format("rain: drops of {:.3g} mm move at ({:.4g}, {:.4g}, {:.4g}) m/s; "
                              "expected a fall of 0.01 m/s or more, at most 200 m/s in all",
                              2e3 * size.r0_m, v.x(), v.y(), v.z()));
  }
}

// wind: a rain that has its wind alone.
Rain read_rain(TomlReader reader, const Rain& wind) {
  Rain rain = wind;
  Eigen::Vector3d direction(0, 0, -1);
  reader.optional("fall_direction", direction, {-1e3, 1e3});
  if (!(direction.z() < 0))
    reader.refuse("fall_direction",
                  fmt::format("rain.fall_direction[2] = {}; expected less than 0", direction.z()));
  direction.normalize();
  int ways = 0;
  for (const char* key : {"drops_per_m3", "drops_per_m2_s", "rate_mm_h"})
    ways += reader.has(key) ? 1 : 0;
  if (ways != 1)
    reader.refuse("seed", fmt::format("rain has {} of drops_per_m3, drops_per_m2_s and rate_mm_h; "
                                      "expected one of them",
                                      ways));
  rain.sizes = reader.has("rate_mm_h")
                   ? read_distribution(reader, direction, rain.wind_m_s, rain.undrawn_per_m)
                   : read_one_size(reader, direction, rain.wind_m_s);
  unsigned long long seed = rain.seed;
  reader.optional("seed", seed);
  rain.seed = seed;
  read_box(reader, rain);
  if (!rain.wind.empty()) refuse_endless_rain(reader);
  read_density(reader, rain);
  reader.optional("culling_radius_m", rain.culling_radius_m, {0, 1e4, true}, "m");
  reader.optional("local_height_m", rain.local_height_m, {0.01, 1e4}, "m");
  reader.optional("lost_share", rain.lost_share, {0.001, 0.9});
  reader.finish();
  refuse_odd_velocities(reader, rain);
  return rain;
}

Fog read_fog(TomlReader reader) {
  Fog fog;
  reader.optional("extinction_per_m", fog.extinction_per_m, {0, 10}, "1/m");
  reader.optional("asymmetry", fog.asymmetry, {-0.99, 0.99});
  reader.finish();
  return fog;
}

Darkening read_darkening(TomlReader reader) {
  Darkening darkening;
  reader.optional("desaturation", darkening.desaturation, {0, 1});
  reader.optional("brightness", darkening.brightness, {0, 1, true});
  reader.finish();
  return darkening;
}

Blur read_blur(TomlReader reader) {
  Blur blur;
  reader.required("sigma_px", blur.sigma_px, {0, 64, true}, "px");
  reader.finish();
  return blur;
}

struct MovingShape {
  Mesh mesh = {};
  std::vector<MovingKey> path = {};
};

MovingShape read_moving(TomlReader reader, std::size_t number) {
  MovingShape moving;
  std::string file;
  reader.required("file", file);
  for (TomlReader& table : reader.tables("key")) {
    MovingKey key;
    table.required("time_s", key.time_s, {0, 1e7}, "s");
    table.required("position_m", key.position_m, place_m);
    table.optional("heading_deg", key.heading_deg, {-1e5, 1e5}, "deg");
    table.finish();
    add_key(table, fmt::format("moving[{}].key[{}]", number, moving.path.size()), key, moving.path);
  }
  if (moving.path.size() < 2)
    reader.refuse("key", fmt::format("moving[{}] has {} [[moving.key]]; expected 2 or more", number,
                                     moving.path.size()));
  reader.finish();
  moving.mesh = read_gltf_mesh(absolute_beside(reader.file(), file));
  if (moving.mesh.indices.empty())
    reader.refuse("file", fmt::format("moving[{}].file = \"{}\" has no triangle with an area; "
                                      "expected one or more",
                                      number, file));
  return moving;
}

SingleDrop read_drop(TomlReader reader) {
  SingleDrop drop;
  reader.required("centre_m", drop.centre_m, place_m);
  reader.optional("radius_m", drop.r0_m, {1e-5, 5e-3}, "m");
  drop.velocity_m_s = {0, 0, -beard_m_s(drop.r0_m)};
  reader.optional("velocity_m_s", drop.velocity_m_s, {-200, 200});
  reader.optional("oscillation", drop.oscillation, 0, 99);
  reader.finish();
  if (!(drop.velocity_m_s.norm() >= 0.01))
    reader.refuse("velocity_m_s",
                  fmt::format("drop.velocity_m_s has length {}; expected 0.01 m/s or more",
                              drop.velocity_m_s.norm()));
  return drop;
}

}  // namespace

Scene read_scene(const std::string& file) {
  const toml::table document = read_toml(file);
  TomlReader reader(document, file, "");
  Scene scene;
  scene.camera = read_camera(reader, scene.camera_path);
  for (TomlReader& light : reader.tables("light")) scene.lights.push_back(read_light(light));
  if (reader.has("environment")) scene.environment = read_environment(reader.table("environment"));
  Rain wind;
  if (reader.has("wind")) read_wind(reader.table("wind"), wind);
  if (reader.has("rain")) scene.rain = read_rain(reader.table("rain"), wind);
  for (TomlReader& drop : reader.tables("drop")) scene.drops.push_back(read_drop(drop));
  if (reader.has("fog")) scene.fog = read_fog(reader.table("fog"));
  if (reader.has("glow")) {
    reader.table("glow").finish();
    if (!scene.fog) reader.refuse("glow", "glow without fog; expected a table [fog]");
    scene.glow.emplace();
  }
  if (reader.has("darkening")) scene.darkening = read_darkening(reader.table("darkening"));
  if (reader.has("blur")) scene.blur = read_blur(reader.table("blur"));
  if (reader.has("splashes")) {
    reader.table("splashes").finish();
    if (!reader.has("rain") && scene.drops.empty())
      reader.refuse("splashes", "splashes without rain; expected a table [rain] or a [[drop]]");
    scene.splashes.emplace();
  }
  if (reader.has("geometry")) {
    TomlReader geometry = reader.table("geometry");
    geometry.required("file", scene.geometry_file);
    geometry.finish();
    scene.geometry_file = absolute_beside(file, scene.geometry_file);
  }
  std::vector<MovingShape> moving;
  for (TomlReader& part : reader.tables("moving"))
    moving.push_back(read_moving(part, moving.size()));
  reader.finish();
  if (!scene.geometry_file.empty()) scene.mesh = read_gltf_mesh(scene.geometry_file);
  for (const MovingShape& part : moving) add_moving_part(scene, part.mesh, part.path);
  return scene;
}

}  // namespace pluvia
