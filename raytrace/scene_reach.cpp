// The search over the rain's box: scene_reach of scene_subset.h.

#include <algorithm>
#include <bitset>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <Eigen/Geometry>

#include "raytrace/depth_of_field.h"
#include "raytrace/drop_motion.h"
#include "raytrace/exit_field.h"
#include "raytrace/light.h"
#include "raytrace/rain_space.h"
#include "raytrace/scene_subset.h"
#include "raytrace/streak_placement.h"

namespace pluvia {

namespace {

constexpr double pi = std::numbers::pi;
// Where a cell is no longer halved but all that it may ask for is kept: a quarter of a degree, or
// half a millimetre beside a lamp.
constexpr double fine_rad = pi / 720;
constexpr double fine_m = 5e-4;

using ViewSet = std::bitset<181>;    // -90 .. 90 degrees, each once
using LightSet = std::bitset<1297>;  // the finest of light_grid

struct Asks {
  ViewSet views = {};
  LightSet lights = {};
};

struct Cell {
  Eigen::Vector3d centre = {0, 0, 0}, half = {0, 0, 0};
};

struct Plane {  // inside where normal . (x - camera) >= -beyond_m
  Eigen::Vector3d normal = {0, 0, 1};
  double beyond_m = 0;
};

// Farthest turn of the direction to a point `distance` away while one moves by at most `reach`.
double turn_rad(double reach, double distance) {
  return distance > reach ? std::asin(reach / distance) : pi;
}

struct Search {
  const Scene& scene;
  Eigen::Vector3d camera_m = {0, 0, 0};
  std::vector<int> views = {};  // ascending
  std::vector<Eigen::Vector3d> lights = {};
  Eigen::Vector3d against_fall = {0, 0, 1};
  Eigen::Vector3d forward = {0, 1, 0};
  std::vector<Plane> sides = {};
  Eigen::Vector3d path_m = {0, 0, 0};  // of a drop during the exposure
  double beyond_path_m = 0;            // no part of a streak is farther from its path
  Asks reached = {};

  bool may_be_seen(const Cell& cell) const;
  void add_views(double low_deg, double high_deg, Asks& asks) const;
  void add_lights(const Eigen::Vector3d& direction, double spread_rad, Asks& asks) const;
  Asks asks_of(const Eigen::Vector3d& middle, double reach_m, double& spread_rad) const;
  bool adds(const Asks& asks) const {
    return (asks.views & ~reached.views).any() || (asks.lights & ~reached.lights).any();
  }
  void add(const Asks& asks) {
    reached.views |= asks.views;
    reached.lights |= asks.lights;
  }
  void visit(const Cell& cell);
};

// The cell holds the middles of paths: an end is half a path away.
bool Search::may_be_seen(const Cell& cell) const {
  const Eigen::Vector3d from_camera = cell.centre - camera_m;
  const auto greatest = [&](const Eigen::Vector3d& normal) {
    return normal.dot(from_camera) + normal.cwiseAbs().dot(cell.half);
  };
  if (greatest(forward) < nearest_depth_m) return false;
  return std::all_of(sides.begin(), sides.end(), [&](const Plane& side) {
    const double streak_m = std::abs(side.normal.dot(path_m)) / 2 + beyond_path_m;
    return greatest(side.normal) >= -streak_m - side.beyond_m;
  });
}

// Both neighbours of every elevation in between (atlas/atlas_lookup.h: choose_cells).
void Search::add_views(double low_deg, double high_deg, Asks& asks) const {
  if (views.front() >= 0 && low_deg < 0) {  // no views of their own from below
    const double above_deg = high_deg > 0 ? 0 : -high_deg;
    high_deg = std::max(-low_deg, high_deg);
    low_deg = above_deg;
  }
  const auto upper = [&](double elevation_deg) {
    return std::upper_bound(views.begin(), views.end(), elevation_deg) - views.begin();
  };
  const auto last = static_cast<std::ptrdiff_t>(views.size()) - 1;
  const auto first_view = std::max<std::ptrdiff_t>(0, upper(low_deg) - 1);
  const auto last_view = std::min(last, upper(high_deg));
  for (auto i = first_view; i <= last_view; ++i) asks.views.set(static_cast<std::size_t>(i));
}

// The direction is folded: right is left, for the mirrored drop.
void Search::add_lights(const Eigen::Vector3d& direction, double spread_rad, Asks& asks) const {
  const Eigen::Vector3d folded(direction.x(), std::abs(direction.y()), direction.z());
  double nearest = -1;
  for (const Eigen::Vector3d& light : lights) nearest = std::max(nearest, folded.dot(light));
  // The renderer decides ties in float, within 1e-6 of squared chord (realtime/shaders); of an arc
  // cosine near 1 rounding makes 1e-8.
  constexpr double tie_rad = 1e-3;
  const double reach = std::acos(std::min(nearest, 1.0)) + 2 * spread_rad + tie_rad;
  const double least = reach < pi ? std::cos(reach) : -2;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    if (folded.dot(lights[i]) >= least) asks.lights.set(i);
  }
}

// All that streaks whose path's middle lies within reach_m of `middle` may ask for. spread: the
// largest turn of any direction there.
Asks Search::asks_of(const Eigen::Vector3d& middle, double reach_m, double& spread_rad) const {
  Asks asks;
  const Eigen::Vector3d to_camera = camera_m - middle;
  const Eigen::Vector3d across = to_camera - to_camera.dot(against_fall) * against_fall;
  const double view_turn = turn_rad(reach_m, to_camera.norm());
  const double azimuth_turn = turn_rad(reach_m, across.norm());
  const double view_rad = std::atan2(to_camera.dot(against_fall), across.norm());
  add_views((view_rad - view_turn) * 180 / pi, (view_rad + view_turn) * 180 / pi, asks);
  spread_rad = view_turn;
  // Seen along the fall, any azimuth will do: the turn of pi covers it.
  const Eigen::Vector3d x =
      across.norm() > 0 ? Eigen::Vector3d(across.normalized()) : against_fall.unitOrthogonal();
  const Eigen::Vector3d y = against_fall.cross(x);
  const bool flips = views.front() >= 0;
  for (const Light& light : scene.lights) {
    const Illumination lit = illumination(light, middle);
    const double turn = std::min(pi, turn_rad(reach_m, lit.distance_m) + azimuth_turn);
    spread_rad = std::max(spread_rad, turn);
    const Eigen::Vector3d& d = lit.toward;
    const Eigen::Vector3d seen(d.dot(x), d.dot(y), d.dot(against_fall));
    if (!flips || view_rad + view_turn >= 0) add_lights(seen, turn, asks);
    if (flips && view_rad - view_turn < 0) {
      add_lights({seen.x(), seen.y(), -seen.z()}, turn, asks);
    }
  }
  return asks;
}

void Search::visit(const Cell& cell) {
  if (!may_be_seen(cell)) return;
  const double reach_m = cell.half.norm();
  double spread_rad = 0;
  const Asks asks = asks_of(cell.centre, reach_m, spread_rad);
  if (!adds(asks)) return;
  if (spread_rad < fine_rad || reach_m < fine_m) {
    add(asks);
    return;
  }
  // What the middle alone asks for spares the search much.
  double unused = 0;
  if (may_be_seen({.centre = cell.centre})) add(asks_of(cell.centre, 0, unused));
  int longest = 0;
  cell.half.maxCoeff(&longest);
  Cell low = cell;
  low.half[longest] /= 2;
  Cell high = low;
  low.centre[longest] -= low.half[longest];
  high.centre[longest] += high.half[longest];
  visit(low);
  visit(high);
}

// The four sides of the picture, a pixel beyond its edge; with depth of field as far as circles
// reach (raytrace/depth_of_field.h).
std::vector<Plane> sides_of(const Camera& camera, const CameraFrame& frame) {
  std::vector<Plane> sides;
  const auto add = [&](const Eigen::Vector3d& across, int size_px) {
    const double reach_m = beside_view_m(camera, 0);
    const double slope = (size_px / 2.0 + (reach_m > 0 ? 4 : 1)) / frame.focal_px +
                         beside_view_m(camera, 1) - reach_m;
    for (const double sign : {-1.0, 1.0}) {
      const Eigen::Vector3d inward = slope * frame.forward + sign * across;
      sides.push_back({inward.normalized(), reach_m / inward.norm()});
    }
  };
  add(frame.right, camera.width_px);
  add(frame.up, camera.height_px);
  return sides;
}

// A streak's picture is two widths or less beside and beyond its path, drawn straight on the
// screen: where the path comes toward the camera, from depth z to z + path, the scale of a row
// exceeds that at the middle by (r + 2 + 1 / r) / 4, r the ratio of both depths, and z is
// nearest_depth_m at least.
double beyond_path(const Preset& preset, double pixel_m, double path_m) {
  const double ratio = 1 + path_m / nearest_depth_m;
  return (ratio + 2 + 1 / ratio) / 4 * 2 * preset.width_px * pixel_m;
}

// Where the centres of some drops may be at shutter-open.
struct Drops {
  RainSize size = {};
  Eigen::Vector3d low_m = {0, 0, 0}, high_m = {0, 0, 0};
};

// The rain's local space, or rather the box around it, and the single drops during a day.
std::vector<Drops> all_drops(const Scene& scene, const RainSpace& space,
                             const Eigen::Vector3d& camera_m) {
  std::vector<Drops> drops;
  for (const RainSizeSpace& size : space.sizes) {
    if (size.cell_m == 0) continue;
    // The corners of the square that holds the prism's cells, at both ends of the slab.
    const FallFrame& frame = size.frame;
    const LocalSpace local =
        local_space(space, static_cast<int>(&size - space.sizes.data()), camera_m, 0);
    const double reach_m = space.culling_radius_m + 2 * size.cell_m;
    Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = -low;
    for (int corner = 0; corner < 8; ++corner) {
      const double x = local.centre_m.x() + (corner & 1 ? reach_m : -reach_m);
      const double y = local.centre_m.y() + (corner & 2 ? reach_m : -reach_m);
      const double z = local.floor_m + (corner & 4 ? space.local_height_m : 0);
      const Eigen::Vector3d p = x * frame.x + y * frame.y + z * frame.z;
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    low = low.cwiseMax(scene.rain.box_min_m);
    high = high.cwiseMin(scene.rain.box_max_m);
    if ((low.array() <= high.array()).all()) drops.push_back({size.drops, low, high});
  }
  for (const SingleDrop& drop : scene.drops) {
    const Eigen::Vector3d end = drop.centre_m + 86400 * drop.velocity_m_s;
    drops.push_back({{.r0_m = drop.r0_m, .velocity_m_s = drop.velocity_m_s},
                     drop.centre_m.cwiseMin(end),
                     drop.centre_m.cwiseMax(end)});
  }
  return drops;
}

// The preset's pictures that show a drop of that size: of the nearest diameter.
StreakGeometry pictures_of(const Preset& preset, double r0_m) {
  const std::vector<int> known_um = diameters_of(preset);
  const int nearest_um = *std::min_element(known_um.begin(), known_um.end(), [&](int a, int b) {
    return std::abs(a - 2e6 * r0_m) < std::abs(b - 2e6 * r0_m);
  });
  const SizeRecord size = size_of(preset, nearest_um);
  return {.pixel_m = size.pixel_m, .exposure_s = size.span_s, .mean_radius_m = 5e-7 * nearest_um};
}

void search_drops(const Preset& preset, const Drops& drops, double exposure_s, Search& search) {
  const Eigen::Vector3d& velocity = drops.size.velocity_m_s;
  const StreakGeometry pictures = pictures_of(preset, drops.size.r0_m);
  const SegmentTimes times = segment_times(exposure_s, drops.size.r0_m, pictures);
  search.against_fall = -velocity.normalized();
  search.path_m = times.each_s * velocity;
  search.beyond_path_m = beyond_path(
      preset, pictures.pixel_m * drops.size.r0_m / pictures.mean_radius_m, search.path_m.norm());
  // From the middle of the first segment to that of the last.
  const Eigen::Vector3d first = search.path_m / 2;
  const Eigen::Vector3d last = first + (times.count - 1) * search.path_m;
  const Eigen::Vector3d low = drops.low_m + first.cwiseMin(last);
  const Eigen::Vector3d high = drops.high_m + first.cwiseMax(last);
  search.visit({.centre = (low + high) / 2, .half = (high - low) / 2});
}

// Of drops that go any way.
Reach everything(const Preset& preset) {
  Reach reach = {.views_deg = preset.view_elevations_deg, .lights = preset.lights};
  std::sort(reach.views_deg.begin(), reach.views_deg.end());
  return reach;
}

}  // namespace

Reach scene_reach(const Preset& preset, const Scene& scene) {
  constexpr int cameras_of_a_path = 64;
  if (needs_motion(scene.rain)) return everything(preset);
  const RainSpace space = make_rain_space(scene);
  Search search = {.scene = scene, .views = preset.view_elevations_deg};
  std::sort(search.views.begin(), search.views.end());
  for (const LightDirection& light : preset.lights) {
    search.lights.push_back(light_direction(light.elevation_deg, light.azimuth_deg));
  }
  for (const Camera& camera : camera_samples(scene, cameras_of_a_path)) {
    const CameraFrame frame = camera_frame(camera);
    search.camera_m = camera.position_m;
    search.forward = frame.forward;
    search.sides = sides_of(camera, frame);
    for (const Drops& drops : all_drops(scene, space, camera.position_m))
      search_drops(preset, drops, camera.exposure_s, search);
  }
  Reach reach;
  for (std::size_t i = 0; i < search.views.size(); ++i) {
    if (search.reached.views[i]) reach.views_deg.push_back(search.views[i]);
  }
  for (std::size_t i = 0; i < preset.lights.size(); ++i) {
    if (search.reached.lights[i]) reach.lights.push_back(preset.lights[i]);
  }
  return reach;
}

}  // namespace pluvia
