#include "raytrace/scene.h"

#include <cmath>
#include <filesystem>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "raytrace/gltf_mesh.h"
#include "raytrace/toml_reader.h"

namespace pluvia {
namespace {

constexpr Range place_m = {-1e6, 1e6};       // beyond it a float is coarser than 6 cm
constexpr Range radiance_cd_m2 = {0, 1e10};  // the sun's disc has 1.6e9
constexpr double max_drops = 5e6;
constexpr double min_box_m = 1e-3;

std::string absolute_beside(const std::string& file, const std::string& path) {
  return std::filesystem::absolute(path_beside(file, path)).lexically_normal().string();
}

Camera read_camera(TomlReader reader) {
  Camera camera;
  reader.required("position_m", camera.position_m, place_m);
  reader.required("target_m", camera.target_m, place_m);
  reader.optional("vertical_fov_deg", camera.vertical_fov_deg, {1, 150}, "deg");
  reader.optional("width_px", camera.width_px, 1, 16384);
  reader.optional("height_px", camera.height_px, 1, 16384);
  reader.optional("exposure_s", camera.exposure_s, {0, 1, true}, "s");
  reader.optional("white_cd_m2", camera.white_cd_m2, {0, 1e10, true}, "cd/m^2");
  reader.finish();
  if ((camera.target_m - camera.position_m).norm() < 1e-6)
    reader.refuse("target_m", "camera.target_m is camera.position_m; expected another point");
  return camera;
}

PointLight read_light(TomlReader reader) {
  PointLight light;
  reader.optional("name", light.name);
  reader.required("position_m", light.position_m, place_m);
  reader.required("intensity_cd", light.intensity_cd, {0, 1e9});
  reader.finish();
  return light;
}

EnvironmentLight read_environment(TomlReader reader) {
  EnvironmentLight environment;
  reader.optional("map", environment.map_file);
  reader.optional("scale_cd_m2", environment.scale_cd_m2, {0, 1e10}, "cd/m^2");
  reader.optional("uniform_cd_m2", environment.uniform_cd_m2, radiance_cd_m2);
  reader.finish();
  const bool map = reader.has("map");
  if (map && environment.map_file.empty())
    reader.refuse("map", "environment.map = \"\"; expected the path of a picture");
  if (map && reader.has("uniform_cd_m2"))
    reader.refuse("uniform_cd_m2", "environment has map and uniform_cd_m2; expected one of them");
  if (!map && reader.has("scale_cd_m2"))
    reader.refuse("scale_cd_m2", "environment.scale_cd_m2 without a map; expected map beside it");
  if (map) environment.map_file = absolute_beside(reader.file(), environment.map_file);
  return environment;
}

Rain read_rain(TomlReader reader) {
  Rain rain;
  unsigned long long seed = rain.seed;
  reader.required("drops_per_m3", rain.drops_per_m3, {0, 1e9}, "drops/m^3");
  reader.optional("mean_radius_m", rain.mean_radius_m, {1e-5, 5e-3}, "m");
  reader.optional("fall_speed_m_s", rain.fall_speed_m_s, {0, 50, true}, "m/s");
  reader.optional("box_min_m", rain.box_min_m, place_m);
  reader.optional("box_max_m", rain.box_max_m, place_m);
  reader.optional("seed", seed);
  reader.finish();
  rain.seed = seed;
  const Eigen::Vector3d size = rain.box_max_m - rain.box_min_m;
  for (int i = 0; i < 3; ++i) {
    if (!(size[i] >= min_box_m))
      reader.refuse("box_max_m",
                    fmt::format("rain.box_max_m[{0}] = {1}; expected {2} m or more above "
                                "box_min_m[{0}] = {3}",
                                i, rain.box_max_m[i], min_box_m, rain.box_min_m[i]));
  }
  const double drops = rain.drops_per_m3 * size.prod();
  if (drops > max_drops)
    reader.refuse("drops_per_m3", fmt::format("rain.drops_per_m3 = {} gives {:.0f} drops in the "
                                              "box; expected at most {:.0f}",
                                              rain.drops_per_m3, drops, max_drops));
  return rain;
}

}  // namespace

CameraFrame camera_frame(const Camera& camera) {
  const Eigen::Vector3d forward = (camera.target_m - camera.position_m).normalized();
  const bool vertical = std::hypot(forward.x(), forward.y()) < 1e-6;
  const Eigen::Vector3d hint =
      vertical ? Eigen::Vector3d(0, forward.z() < 0 ? 1 : -1, 0) : Eigen::Vector3d(0, 0, 1);
  CameraFrame frame;
  frame.forward = forward;
  frame.right = forward.cross(hint).normalized();
  frame.up = frame.right.cross(forward);
  const double half_fov = camera.vertical_fov_deg * std::numbers::pi / 360;
  frame.focal_px = camera.height_px / (2 * std::tan(half_fov));
  return frame;
}

Scene read_scene(const std::string& file) {
  const toml::table document = read_toml(file);
  TomlReader reader(document, file, "");
  Scene scene;
  scene.camera = read_camera(reader.table("camera"));
  for (TomlReader& light : reader.tables("light")) scene.lights.push_back(read_light(light));
  if (reader.has("environment")) scene.environment = read_environment(reader.table("environment"));
  if (reader.has("rain")) scene.rain = read_rain(reader.table("rain"));
  if (reader.has("geometry")) {
    TomlReader geometry = reader.table("geometry");
    geometry.required("file", scene.geometry_file);
    geometry.finish();
    scene.geometry_file = absolute_beside(file, scene.geometry_file);
  }
  reader.finish();
  if (!scene.geometry_file.empty()) scene.mesh = read_gltf_mesh(scene.geometry_file);
  return scene;
}

}  // namespace pluvia
