// A scene: what a frame shows, free of any renderer. Read from TOML (raytrace/toml_reader.h),
// geometry from glTF 2.0 through tinygltf. World axes: x east, y north, z up, metres; glTF's y-up
// is turned. Radiance is linear Rec.709 in cd/m^2; a lamp of I [cd] at distance r gives I / r^2
// lux.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "raytrace/density_map.h"
#include "raytrace/wind_field.h"

namespace pluvia {

struct DepthOfField {                                        // raytrace/depth_of_field.h
  double aperture_m = 0;                                     // diameter of the entrance pupil
  double focus_m = std::numeric_limits<double>::infinity();  // along the camera's axis
};

struct Camera {
  Eigen::Vector3d position_m = {0, 0, 1.6};
  Eigen::Vector3d target_m = {0, 1, 1.6};
  double vertical_fov_deg = 40;  // 1 .. 150
  int width_px = 640;
  int height_px = 360;
  double exposure_s = 1.0 / 60;
  double white_cd_m2 = 1;                           // the radiance that a PNG shows as white
  std::optional<DepthOfField> depth_of_field = {};  // nothing: a pinhole
};

constexpr double least_key_s = 1e-3;  // between keys of a path

struct CameraKey {
  double time_s = 0;
  Eigen::Vector3d position_m = {0, 0, 0}, target_m = {0, 1, 0};
  double focus_m = std::numeric_limits<double>::infinity();  // with depth of field
};

// The camera's axes (unit, right-handed: right x up = -forward) and its focal length f in pixels. A
// point at c from the camera is seen at
//   (width / 2 + f c.right / c.forward, height / 2 - f c.up / c.forward):
// x right, y down, pixel (i, j) covers [i, i+1] x [j, j+1].
struct CameraFrame {
  Eigen::Vector3d right = {1, 0, 0};
  Eigen::Vector3d up = {0, 0, 1};
  Eigen::Vector3d forward = {0, 1, 0};
  double focal_px = 1;
};

// z is up in the picture; for a view within 1e-6 of vertical, north (y) is, looking down, and
// south, looking up: what a camera shows that was tilted there from a view to the north.
CameraFrame camera_frame(const Camera& camera);

enum class LightKind { point, spot, sun };

struct Light {
  std::string name = {};
  Eigen::Vector3d position_m = {0, 0, 0};    // of a point light or a spot
  Eigen::Vector3d intensity_cd = {0, 0, 0};  // per Rec.709 channel; of a spot on its axis
  LightKind kind = LightKind::point;
  double radius_m = 0;                          // of the lamp: no drop is inside
  Eigen::Vector3d direction = {0, 0, -1};       // the way a spot's or the sun's light goes, unit
  double inner_half_angle_deg = 0;              // of a spot: full intensity inside
  double outer_half_angle_deg = 45;             // and none outside
  Eigen::Vector3d illuminance_lux = {0, 0, 0};  // of the sun, on a plane that faces it
  bool shadow = false;                          // surfaces stop it
};

struct EnvironmentLight {     // both given: an error; neither: black
  std::string map_file = {};  // lat-long (atlas/image_io.h), absolute after reading
  double scale_cd_m2 = 1;     // multiplies the map
  Eigen::Vector3d uniform_cd_m2 = {0, 0, 0};
  // Above 0, the file is a clip of maps (atlas/environment_clip.h), of so many in a second.
  double frames_per_s = 0;
  double start_s = 0;  // when its first map is seen
  long picture = 0;    // the map that the scene is posed at, from 0: clip_picture
};

// Which map of a clip is seen when the shutter opens at time_s: floor((time_s - start_s)
// frames_per_s), where a millionth of a picture early is in time; the first before the clip begins.
// 0 for a map that stands still. After the clip's end whoever reads it holds the last.
long clip_picture(const EnvironmentLight& environment, double time_s);

struct Material {
  Eigen::Vector3d base_color = {0.5, 0.5, 0.5};  // Lambert albedo, linear
  Eigen::Vector3d emission_cd_m2 = {0, 0, 0};
};

struct Mesh {  // triangles in world coordinates, counter-clockwise from outside
  std::vector<Eigen::Vector3f> positions_m = {};
  std::vector<Eigen::Vector3f> normals = {};  // unit, one per position
  std::vector<std::uint32_t> indices = {};    // 3 per triangle
  std::vector<Material> materials = {};
  std::vector<std::uint32_t> triangle_material = {};  // one per triangle
};

struct MovingKey {
  double time_s = 0;
  Eigen::Vector3d position_m = {0, 0, 0};  // of the part's own origin
  double heading_deg = 0;  // counter-clockwise as seen from above; 0: as its file has it
};

struct MovingPart {                  // a rigid body (raytrace/moving_parts.h)
  std::vector<MovingKey> path = {};  // ascending times
  std::vector<Eigen::Vector3f> positions_m = {}, normals = {};  // about its own origin
  std::size_t first_vertex = 0;  // of those of Scene::mesh that are its
  std::size_t first_index = 0, index_count = 0;
};

struct RainSize {  // drops of one size, all with one velocity
  double r0_m = 1.6e-3;
  double drops_per_m3 = 0;
  Eigen::Vector3d velocity_m_s = {0, 0, -8.49};  // with the wind; falls: z < 0
};

struct Rain {
  std::vector<RainSize> sizes = {};      // none: no rain
  Eigen::Vector3d wind_m_s = {0, 0, 0};  // in each velocity of sizes
  std::vector<WindPrimitive> wind = {};  // over that wind; any: drops move by steps
  double restitution = 0;                // of a bounce (raytrace/drop_motion.h), 0 .. 0.9
  // Drops are where their centre at shutter-open is inside; each side >= 1 mm.
  Eigen::Vector3d box_min_m = {-1e6, -1e6, -1e6};
  Eigen::Vector3d box_max_m = {1e6, 1e6, 1e6};
  DensityMap density =
      {};  // over the box, at its upper end; the sizes are what falls where it is white
  // How far from the camera drops are drawn (raytrace/rain_space.h); 0: as near as lost_share of
  // the visible rain allows.
  double culling_radius_m = 0;
  double local_height_m = 0;
  double lost_share = 0.05;
  double undrawn_per_m = 0;  // extinction of drops smaller than those of `sizes`, Q = 1
  std::uint64_t seed = 1;
};

struct SingleDrop {                      // falls until it hits a surface
  Eigen::Vector3d centre_m = {0, 0, 0};  // at time 0
  double r0_m = 1.6e-3;
  Eigen::Vector3d velocity_m_s = {0, 0, -8.49};
  int oscillation = 0;  // the oscillation set
};

// Effects: a scene has those whose table its file holds, and no other costs anything.
struct Fog {                    // raytrace/rain_fog.h
  double extinction_per_m = 0;  // of mist, besides what the rain takes
  double asymmetry = 0.884;     // mean cosine of scattering: a sphere of water, without diffraction
};

struct Glow {};  // the light that the fog scatters from lamps and suns

struct Darkening {  // of the scene without rain (realtime/darkening_pass.h); a look, no physics
  double desaturation = 0;  // 0 .. 1: the share of each colour that becomes grey of its luminance
  double brightness = 1;    // multiplies, > 0 .. 1
};

struct Blur {           // of the scene without rain (realtime/blur_pass.h); a look, no physics
  double sigma_px = 0;  // of a Gaussian
};

struct Splashes {};  // of drops that hit surfaces (raytrace/splash.h)

struct Scene {
  Camera camera = {};                       // without a path, always; with one, at its first key
  std::vector<CameraKey> camera_path = {};  // ascending times
  std::vector<Light> lights = {};
  EnvironmentLight environment = {};
  std::string geometry_file = {};       // absolute after reading; empty: no surface
  Mesh mesh = {};                       // what stands still, then the moving parts as posed
  std::vector<MovingPart> moving = {};  // in the order of their vertices in the mesh
  Rain rain = {};
  std::vector<SingleDrop> drops = {};  // beside the rain's
  std::optional<Fog> fog = {};
  std::optional<Glow> glow = {};  // only with fog
  std::optional<Splashes> splashes = {};
  std::optional<Darkening> darkening = {};
  std::optional<Blur> blur = {};
};

// The file's tables and their keys (r: required):
//   [camera]       position_m r, target_m r, vertical_fov_deg, width_px, height_px, exposure_s,
//                  white_cd_m2; or, instead of position_m and target_m, a path of two or more
//                  [[camera.key]] time_s r, position_m r, target_m r, focus_m, times ascending
//   [depth_of_field]  one of aperture_m (diameter) and f_number (of a picture 24 mm high);
//                  focus_m (none: infinity), or key by key where a key has one
//   [[light]]      kind ("point", "spot" or "sun"), name, shadow;
//                  point and spot: position_m r, intensity_cd r, radius_m;
//                  spot: direction r, inner_half_angle_deg, outer_half_angle_deg;
//                  sun: direction r, illuminance_lux r
//   [environment]  map and scale_cd_m2, or uniform_cd_m2; frames_per_s where the map is a clip (a
//                  video, a folder of pictures, or a pattern such as "sky/*.exr"), start_s
//   [geometry]     file r: glTF 2.0, .gltf or .glb (raytrace/gltf_mesh.h)
//   [[moving]]     file r: glTF as above, one triangle or more; two or more [[moving.key]]
//                  time_s r, position_m r, heading_deg, times ascending: surfaces that move, posed
//                  at time 0 after reading
//   [rain]         one of drops_per_m3, drops_per_m2_s (through a level plane), rate_mm_h;
//                  density_map (a grey picture over the box, which must then be given, north up);
//                  box_min_m, box_max_m, culling_radius_m, local_height_m, lost_share, seed,
//                  fall_direction (of any length; downward);
//                  without rate_mm_h one size: mean_radius_m, fall_speed_m_s (Beard's for it);
//                  with it several: distribution ("marshall-palmer" or "willis"), sizes (1 .. 16),
//                  least_diameter_mm; each has Beard's fall speed
//   [wind]         velocity_m_s r: uniform, carries every drop of the rain along; or besides it
//                  [[wind.primitive]] (raytrace/wind_field.h) kind r ("uniform", "source", "sink",
//                  "vortex" or "tornado"), axis (of any length), core_radius_m; uniform:
//                  speed_m_s r; the others: position_m r, strength_m2_s r; tornado: inflow,
//                  height_m; or, instead of axis, speed or strength and position, a path of two or
//                  more [[wind.primitive.key]] with these and time_s r, times ascending. With one
//                  that is not uniform and steady drops move by steps (raytrace/drop_motion.h):
//                  [rain] needs a box, and bounce with restitution (0 .. 0.9)
//   [fog]          extinction_per_m, asymmetry (-0.99 .. 0.99)
//   [glow]         lamps and suns shine in the fog; needs [fog]
//   [darkening]    desaturation, brightness
//   [blur]         sigma_px r
//   [splashes]     where drops hit; needs [rain] or a [[drop]]
//   [[drop]]       centre_m r (at time 0), radius_m, velocity_m_s, oscillation: a drop by itself
// [camera] is required; without the others a scene has no light, no surface, no rain. Paths are
// relative to the file; those of the result are absolute. Throws std::runtime_error with
// FILE:LINE:COL for anything missing, unknown, out of range or not finite.
Scene read_scene(const std::string& file);

// scene.camera as its path (raytrace/key_path.h) has it at a time. Target and position never come
// closer than 1 mm: the target is pushed ahead where they would. The focus goes evenly in 1 /
// focus_m from key to key.
Camera camera_at(const Scene& scene, double time_s);

// Cameras along the path, evenly in time: scene.camera alone without a path.
std::vector<Camera> camera_samples(const Scene& scene, int count);

}  // namespace pluvia
