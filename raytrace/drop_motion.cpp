#include "raytrace/drop_motion.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>

#include "raytrace/drop_step.h"
#include "raytrace/moving_parts.h"
#include "raytrace/rain_space.h"
#include "raytrace/scene_tops.h"

namespace pluvia {
namespace {

Eigen::Vector3d place_in_box(const MovingSize& size, std::uint32_t k, std::uint32_t fall,
                             const Eigen::Vector3d& size_m) {
  const auto bits = rain_hash(size.stream[0], k, fall);
  return {std::ldexp(bits[0], -32) * size_m.x(), std::ldexp(bits[1], -32) * size_m.y(),
          std::ldexp(bits[2], -32) * size_m.z()};
}

bool is_below(const MotionSurroundings& around, const Eigen::Vector3d& position_m) {
  const Eigen::Vector3d at = around.low_m + position_m;
  return at.z() <= height_at(around.top, at.x(), at.y());
}

// With the velocity of its terminal fall in the wind there; one inside an object has hit.
MovingDrop entering(const MovingSize& size, const MotionSurroundings& around,
                    const Eigen::Vector3d& position_m, std::uint32_t fall) {
  MovingDrop drop = {.position_m = position_m, .fall = fall};
  drop.velocity_m_s = size.fall_m_s + velocity_m_s(around.grid, around.low_m + position_m);
  if (is_below(around, position_m)) drop.since_hit_s = 0;
  return drop;
}

// At the top, as far below it as it has already sunk beyond the bottom.
MovingDrop fallen_again(const MovingDrop& drop, std::uint32_t k, const MovingSize& size,
                        const MotionSurroundings& around, double beyond_m) {
  Eigen::Vector3d at = place_in_box(size, k, drop.fall + 1, around.size_m);
  at.z() = around.size_m.z() - std::fmod(beyond_m, around.size_m.z());
  return entering(size, around, at, drop.fall + 1);
}

MovingDrop sunk(MovingDrop drop, std::uint32_t k, const MovingSize& size,
                const MotionSurroundings& around, double step_s) {
  drop.since_hit_s += step_s;
  const double beyond_m = -size.fall_m_s.z() * drop.since_hit_s - drop.position_m.z();
  return beyond_m > 0 ? fallen_again(drop, k, size, around, beyond_m) : drop;
}

MovingDrop met(MovingDrop drop, const SurfaceHit& hit, const Eigen::Vector3d& way_m,
               double restitution) {
  const double length_m = way_m.norm();
  const double back = length_m > 0 ? back_off_m / length_m : 0;
  drop.position_m += std::max(0.0, hit.share - back) * way_m;
  const Eigen::Vector3d off = bounced_m_s(drop.velocity_m_s, hit.normal, restitution);
  if (off.dot(hit.normal) > least_bounce_m_s)
    drop.velocity_m_s = off;
  else
    drop.since_hit_s = 0;
  return drop;
}

// Sides of the box that a way to a place has passed: what brings it in again on the other side.
Eigen::Vector3d around_the_box(const Eigen::Vector3d& to_m, const Eigen::Vector3d& size_m) {
  return {-std::floor(to_m.x() / size_m.x()) * size_m.x(),
          -std::floor(to_m.y() / size_m.y()) * size_m.y(), 0};
}

}  // namespace

bool needs_motion(const Rain& rain) {
  return !rain.wind.empty() && !rain.sizes.empty();
}

DropMotion make_drop_motion(const Scene& scene) {
  const Rain& rain = scene.rain;
  DropMotion motion;
  motion.wind = {.even_m_s = rain.wind_m_s, .primitives = rain.wind};
  motion.around.low_m = rain.box_min_m;
  motion.around.size_m = rain.box_max_m - rain.box_min_m;
  motion.around.restitution = rain.restitution;
  motion.around.top = box_top(scene);
  const double volume_m3 = motion.around.size_m.prod();
  double all = 0;
  for (const RainSize& drops : rain.sizes) all += drops.drops_per_m3 * volume_m3;
  if (!(all <= most_moving_drops))
    throw std::runtime_error(
        fmt::format("rain: {:.3g} drops in the box, moved by wind; expected at most {:.0f}: a "
                    "smaller box or less rain",
                    all, most_moving_drops));
  std::size_t first = 0;
  for (const RainSize& drops : rain.sizes) {
    MovingSize size = {.drops = drops, .fall_m_s = drops.velocity_m_s - rain.wind_m_s};
    size.stream = rain_hash(static_cast<std::uint32_t>(rain.seed),
                            static_cast<std::uint32_t>(rain.seed >> 32),
                            static_cast<std::uint32_t>(motion.sizes.size()));
    size.first = first;
    size.count =
        static_cast<std::size_t>(drops.drops_per_m3 * volume_m3 + std::ldexp(size.stream[2], -32));
    first += size.count;
    motion.sizes.push_back(size);
  }
  Scene posed = scene;
  start_drops(motion, posed);
  return motion;
}

void start_drops(DropMotion& motion, Scene& scene) {
  prepare_stage(motion, scene, 0);
  motion.steps = 0;
  motion.drops.clear();
  for (const MovingSize& size : motion.sizes) {
    for (std::uint32_t k = 0; k < size.count; ++k)
      motion.drops.push_back(
          entering(size, motion.around, place_in_box(size, k, 0, motion.around.size_m), 0));
  }
}

bool has_stages(const DropMotion& motion, const Scene& scene) {
  return !scene.moving.empty() ||
         std::any_of(motion.wind.primitives.begin(), motion.wind.primitives.end(),
                     [](const WindPrimitive& primitive) { return !primitive.path.empty(); });
}

bool prepare_stage(DropMotion& motion, Scene& scene, long step) {
  const long stage = has_stages(motion, scene) ? step / motion_stage_steps : 0;
  if (stage == motion.stage) return false;
  motion.stage = stage;
  const double time_s = static_cast<double>(stage * motion_stage_steps) * motion_step_s;
  pose(scene, time_s);
  MotionSurroundings& around = motion.around;
  if (!scene.moving.empty()) move_top(scene, around.top);
  around.grid = make_wind_grid(wind_at(motion.wind, time_s), around.low_m,
                               around.low_m + around.size_m, around.top);
  return true;
}

MovingDrop stepped(const MovingDrop& drop, std::uint32_t k, const MovingSize& size,
                   const MotionSurroundings& around, double step_s) {
  if (drop.since_hit_s >= 0) return sunk(drop, k, size, around, step_s);
  MovingDrop next = drop;
  if (is_below(around, drop.position_m)) {  // a moving part has come
    next.since_hit_s = 0;
    return next;
  }
  const Eigen::Vector3d middle = around.low_m + drop.position_m + step_s / 2 * drop.velocity_m_s;
  next.velocity_m_s =
      dragged_m_s(drop.velocity_m_s, velocity_m_s(around.grid, middle), size.fall_m_s, step_s);
  const Eigen::Vector3d way = step_s / 2 * (drop.velocity_m_s + next.velocity_m_s);
  const Eigen::Vector3d shift = around_the_box(drop.position_m + way, around.size_m);
  // The part of the way behind a side, seen from where it comes in; around a corner either side
  // may be passed first.
  for (int sides = 0; sides < 4; ++sides) {
    const Eigen::Vector3d in(sides & 1 ? shift.x() : 0, sides & 2 ? shift.y() : 0, 0);
    if (sides > 0 && (in.array() == 0).all()) continue;
    next.position_m = drop.position_m + in;
    const Eigen::Vector3d from = around.low_m + next.position_m;
    if (const auto hit = first_hit(around.top, from, from + way)) {
      next = met(next, *hit, way, around.restitution);
      next.position_m += around_the_box(next.position_m, around.size_m);
      return next;
    }
  }
  next.position_m = drop.position_m + shift + way;
  const double z_m = next.position_m.z();
  if (z_m < 0) return fallen_again(next, k, size, around, -z_m);
  if (z_m > around.size_m.z()) return fallen_again(next, k, size, around, z_m - around.size_m.z());
  if (is_below(around, next.position_m)) next.since_hit_s = 0;
  return next;
}

long steps_until(double time_s) {
  // A time that is a whole number of steps to 1e-6 of one has ended the last of them.
  return static_cast<long>(std::floor(time_s / motion_step_s + 1e-6));
}

void move_drops(DropMotion& motion, Scene& scene, double time_s) {
  if (steps_until(time_s) < motion.steps) start_drops(motion, scene);
  for (; motion.steps < steps_until(time_s); ++motion.steps) {
    prepare_stage(motion, scene, motion.steps);
    for (const MovingSize& size : motion.sizes) {
      for (std::size_t k = 0; k < size.count; ++k) {
        MovingDrop& drop = motion.drops[size.first + k];
        drop = stepped(drop, static_cast<std::uint32_t>(k), size, motion.around);
      }
    }
  }
}

DropNow drop_now(const DropMotion& motion, const MovingDrop& drop, const TopHeight& top,
                 double time_s) {
  const double late_s = time_s - static_cast<double>(motion.steps) * motion_step_s;
  DropNow now = {.velocity_m_s = drop.velocity_m_s, .hit_time_s = 1e30};
  if (now.velocity_m_s.norm() < least_speed_m_s) now.velocity_m_s = {0, 0, -least_speed_m_s};
  const Eigen::Vector3d at = motion.around.low_m + drop.position_m;
  if (drop.since_hit_s >= 0) {
    now.hit_time_s = -(drop.since_hit_s + late_s);
    now.centre_m = at - now.hit_time_s * now.velocity_m_s;
    return now;
  }
  now.centre_m = at + late_s * now.velocity_m_s;
  const double above_m = now.centre_m.z() - height_at(top, now.centre_m.x(), now.centre_m.y());
  const double fall_m_s = -now.velocity_m_s.z();
  if (above_m <= 0 || fall_m_s >= least_speed_m_s)
    now.hit_time_s = above_m / std::max(fall_m_s, least_speed_m_s);
  return now;
}

std::uint32_t bits_of(const MovingSize& size, std::uint32_t k, const MovingDrop& drop) {
  return rain_hash(size.stream[1], k, drop.fall)[0];
}

}  // namespace pluvia
