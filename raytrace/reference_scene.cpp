#include "raytrace/reference_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

#include <Eigen/Geometry>

#include "atlas/image_io.h"
#include "raytrace/light.h"
#include "raytrace/sky_light.h"

namespace pluvia {
namespace {

constexpr double pi = std::numbers::pi;

// Of the disc that a lamp of that radius is, seen from a distance.
double squared_sine(double radius_m, double distance_m) {
  const double sine = std::min(1.0, radius_m / distance_m);
  return sine * sine;
}

// Uniform over the solid angle of a cone about `axis`.
Eigen::Vector3d direction_in_cone(const Eigen::Vector3d& axis, double sine2,
                                  CounterRandom& random) {
  // 1 - cos without the cancellation of small cones.
  const double height = random.next() * sine2 / (1 + std::sqrt(1 - sine2));
  const double ring = std::sqrt(height * (2 - height)), turn = 2 * pi * random.next();
  const Eigen::Vector3d x = axis.unitOrthogonal(), y = axis.cross(x);
  return (1 - height) * axis + ring * (std::cos(turn) * x + std::sin(turn) * y);
}

// Of a light to a point of a surface, per unit pi: E cos, as far as nothing stands in between.
double lit_share(const ReferenceScene& scene, const MetSurface& point, const Light& light,
                 const Illumination& lit, CounterRandom& random) {
  Eigen::Vector3d toward = lit.toward;
  double distance_m = lit.distance_m, weight = 1;
  if (light.radius_m > 0 && light.kind != LightKind::sun && distance_m > light.radius_m) {
    const double sine2 = squared_sine(light.radius_m, distance_m);
    toward = direction_in_cone(lit.toward, sine2, random);
    // Radiance E / (pi sin^2) times the cone's solid angle, over E.
    weight = 2 / (1 + std::sqrt(1 - sine2));
    const double along = distance_m * lit.toward.dot(toward);
    const double half2 = light.radius_m * light.radius_m - distance_m * distance_m + along * along;
    distance_m = along - std::sqrt(std::max(0.0, half2));
  }
  const double cosine = point.normal.dot(toward);
  if (cosine <= 0) return 0;
  if (!light.shadow && !scene.options.all_shadows) return weight * cosine;
  const Ray ray = {above_surface(point, toward), toward};
  return scene.surfaces->is_blocked(ray, distance_m) ? 0 : weight * cosine;
}

}  // namespace

std::unique_ptr<ReferenceScene> make_reference_scene(const Scene& scene,
                                                     const std::vector<Drop>& drops,
                                                     const Preset& preset,
                                                     const ReferenceOptions& options) {
  if (scene.fog) throw std::runtime_error("[fog]; expected none: the reference has clear air");
  if (scene.darkening || scene.blur)
    throw std::runtime_error(
        "[darkening] or [blur]; expected neither: the reference shows surfaces as they are");
  if (scene.camera.depth_of_field)
    throw std::runtime_error("[depth_of_field]; expected none: the reference has a pinhole");
  auto made = std::make_unique<ReferenceScene>();
  made->camera = scene.camera;
  made->frame = camera_frame(scene.camera);
  made->mesh = scene.mesh;
  made->drops = moving_drops(scene, drops, preset);
  made->lights = scene.lights;
  for (Light& light : made->lights) light.position_m -= scene.camera.position_m;
  made->options = options;
  made->uniform_cd_m2 = made->ambient_cd_m2 = scene.environment.uniform_cd_m2;
  if (auto posed = posed_map(scene.environment)) {
    Image& map = made->map.radiance;
    map = std::move(*posed);
    for (float& value : map.values)
      value = static_cast<float>(scene.environment.scale_cd_m2 * value);
    made->ambient_cd_m2 = Eigen::Vector3d(mean_over_sphere(map).data());
  }
  made->surfaces = std::make_unique<SurfaceGeometry>(made->mesh, scene.camera.position_m);
  made->falling = std::make_unique<DropGeometry>(made->drops);
  return made;
}

Eigen::Vector3d environment_radiance(const ReferenceScene& scene,
                                     const Eigen::Vector3d& direction) {
  if (scene.map.radiance.values.empty()) return scene.uniform_cd_m2;
  Eigen::Vector3d radiance;
  look_up(scene.map, direction, {radiance.data(), 3});
  return radiance;
}

Eigen::Vector3d surface_radiance(const ReferenceScene& scene, const MetSurface& point,
                                 CounterRandom& random) {
  Eigen::Vector3d reflected = scene.ambient_cd_m2;
  for (const Light& light : scene.lights) {
    const Illumination lit = illumination(light, point.position_m);
    reflected += lit_share(scene, point, light, lit, random) / pi * lit.lux;
  }
  return point.material.emission_cd_m2 + point.material.base_color.cwiseProduct(reflected);
}

Eigen::Vector3d lamp_radiance(const ReferenceScene& scene, const Ray& ray, double surface_m,
                              double far_m) {
  Eigen::Vector3d sum = {0, 0, 0};
  const double cone_sine = std::sin(scene.options.cone_half_angle_rad);
  for (const Light& light : scene.lights) {
    const Illumination lit = illumination(light, ray.origin_m);
    const bool sphere = light.radius_m > 0 && light.kind != LightKind::sun;
    const double sine2 =
        sphere ? squared_sine(light.radius_m, lit.distance_m) : cone_sine * cone_sine;
    const double cosine = ray.direction.dot(lit.toward);
    if (cosine < std::sqrt(1 - sine2) || lit.distance_m > far_m) continue;
    const bool shaded = light.shadow || scene.options.all_shadows;
    // The disc of a light without a radius stands for its centre: what hides that hides all of it.
    const bool hidden =
        shaded && (sphere ? surface_m < lit.distance_m - light.radius_m
                          : scene.surfaces->is_blocked({ray.origin_m, lit.toward}, lit.distance_m));
    if (!hidden) sum += lit.lux / (pi * sine2);
  }
  return sum;
}

Ray camera_ray(const ReferenceScene& scene, const Eigen::Vector2d& place_px) {
  const double right = (place_px.x() - scene.camera.width_px / 2.0) / scene.frame.focal_px;
  const double up = (scene.camera.height_px / 2.0 - place_px.y()) / scene.frame.focal_px;
  return {{0, 0, 0},
          (scene.frame.forward + right * scene.frame.right + up * scene.frame.up).normalized()};
}

}  // namespace pluvia
