// What the reference tracer follows rays in: the surfaces, drops, lights and environment of one
// frame, all relative to the camera. It shares with the renderer the scene (raytrace/scene.h:
// places, materials, what a light does to a point, raytrace/light.h) and the list of drops
// (raytrace/drop_field.h), and nothing of how either is shaded.
//
// Surfaces are Lambert's: emission + albedo (ambient + sum_lights E cos / pi), ambient the mean of
// the environment, as a scene's materials are defined; light reflected between surfaces is in
// neither picture. Lights with `shadow` are stopped by surfaces (all of them with all_shadows);
// drops stop no light. A lamp of radius r is a sphere of radiance I / (pi r^2): its shade is soft.
// A drop sees a light without a radius, or the sun, as a disc of cone_half_angle_rad with the same
// illuminance E, radiance E / (pi sin^2), as the streak database has it. The camera itself sees no
// lamp that has no surface, and lamps hide nothing. Where a scene gives a lamp twice, as a light
// and as a surface that glows, drops see both, unless their sight of glowing surfaces is switched
// off.
#pragma once

#include <memory>
#include <vector>

#include "raytrace/counter_random.h"
#include "raytrace/environment_map.h"
#include "raytrace/reference_drops.h"
#include "raytrace/reference_surfaces.h"
#include "raytrace/scene.h"

namespace pluvia {

struct ReferenceOptions {
  double refractive_index = 1.333;
  double cone_half_angle_rad = 0.0873;  // 1e-4 .. pi / 4
  int split_order = 3;  // up to it a camera's ray splits at each interface; beyond, roulette
  int most_order = 0;   // light that has more segments inside a drop is left out, as a database
                        // leaves it out, to tell what that costs; 0: none is
  bool all_shadows = false;
  bool drops_see_emission = true;  // of surfaces
};

struct ReferenceScene {
  Camera camera = {};
  CameraFrame frame = {};
  Mesh mesh = {};
  FallingDrops drops = {};
  std::vector<Light> lights = {};  // from the camera
  EnvironmentMap map = {};         // empty: `uniform` instead
  Eigen::Vector3d uniform_cd_m2 = {0, 0, 0};
  Eigen::Vector3d ambient_cd_m2 = {0, 0, 0};
  ReferenceOptions options = {};
  std::unique_ptr<SurfaceGeometry> surfaces = {};  // of `mesh`
  std::unique_ptr<DropGeometry> falling = {};      // of `drops`
};

// scene.camera: of the frame. On the heap, for its parts refer to each other. Throws
// std::runtime_error for a scene with fog, which is not followed, an environment map that cannot be
// read, and as moving_drops does.
std::unique_ptr<ReferenceScene> make_reference_scene(const Scene& scene,
                                                     const std::vector<Drop>& drops,
                                                     const Preset& preset,
                                                     const ReferenceOptions& options);

// Radiance from a direction where nothing else is, cd/m^2.
Eigen::Vector3d environment_radiance(const ReferenceScene& scene, const Eigen::Vector3d& direction);

// Of a point of a surface; a lamp with a radius is met at one random place.
Eigen::Vector3d surface_radiance(const ReferenceScene& scene, const MetSurface& point,
                                 CounterRandom& random);

// Radiance of the lamps that a ray sees which leaves a drop, as far as far_m, where another drop
// is. surface_m: the distance of the first surface, or infinity.
Eigen::Vector3d lamp_radiance(const ReferenceScene& scene, const Ray& ray, double surface_m,
                              double far_m);

// The ray through a place of the picture (pixel (i, j) covers [i, i+1] x [j, j+1]).
Ray camera_ray(const ReferenceScene& scene, const Eigen::Vector2d& place_px);

}  // namespace pluvia
