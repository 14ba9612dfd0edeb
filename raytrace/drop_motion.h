// Rain that wind carries where no closed form leads: drops with a place and a velocity, moved by
// fixed steps from time 0. Made only for a scene with wind primitives (raytrace/wind_field.h);
// rain in an even wind has the closed form of raytrace/rain_space.h and no state.
//
// Box. All drops are in the rain's box, as many at all times as it holds in still air. At time 0
// they are spread evenly and move with the wind. A drop that leaves through a side comes in through
// the opposite one at the same height; one that leaves through the bottom, or is blown out of the
// top, comes in at the top at a place of its own. A drop ends where it hits, and comes in at the
// top again when it would have fallen to the bottom of the box in still air: so the rain above a
// roof is as dense as beside it, and as in the closed form.
//
// Steps of motion_step_s (drop_step.h), with the wind of the step's middle place from a grid
// (wind_grid.h). What changes with time (keys of the wind, moving parts of the scene) is renewed
// every motion_stage_steps. Between two steps a drop goes straight on. Everything is a function of
// scene and time: same seed, same drops, however the time was reached; going back begins at 0
// again.
//
// Surfaces are top heights seen from straight above on 5 cm (top_height.h), swept along each step
// (drop_step.h): no drop passes a wall, however fast. What lies under a roof is solid. A drop
// bounces with Rain::restitution while it leaves the surface faster than least_bounce_m_s, else it
// ends. Its way ends within back_off_m before the surface; what is left of the step is lost.
//
// The hashes (rain_hash) of drop k of a size in its n-th fall: stream = rain_hash(seed's low word,
// its high word, index of the size); place = rain_hash(stream[0], k, n) 2^-32 of the box's sides;
// bits = rain_hash(stream[1], k, n)[0]. Number of drops: floor(their mean + stream[2] 2^-32).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "raytrace/scene.h"
#include "raytrace/top_height.h"
#include "raytrace/wind_grid.h"

namespace pluvia {

constexpr double motion_step_s = 1.0 / 120;
constexpr int motion_stage_steps = 4;
constexpr double least_bounce_m_s = 0.5;
constexpr double back_off_m = 1e-3;
constexpr double most_moving_drops = 2e6;  // 64 MB of a shader's 128

struct MovingDrop {
  Eigen::Vector3d position_m = {0, 0, 0};    // from the box's low corner; of a drop that has hit:
                                             // where
  double since_hit_s = -1;                   // < 0: it falls
  Eigen::Vector3d velocity_m_s = {0, 0, 0};  // of a drop that has hit: as it hit
  std::uint32_t fall = 0;                    // n
};

struct MovingSize {
  RainSize drops = {};
  Eigen::Vector3d fall_m_s = {0, 0, -1};  // in still air
  std::array<std::uint32_t, 3> stream = {};
  std::size_t first = 0, count = 0;  // of DropMotion::drops
};

struct MotionSurroundings {                               // of one stage
  Eigen::Vector3d low_m = {0, 0, 0}, size_m = {1, 1, 1};  // the box
  TopHeight top = {};
  WindGrid grid = {};
  double restitution = 0;
};

struct DropMotion {
  Wind wind = {};
  MotionSurroundings around = {};
  long stage = -1;  // that `around` is of
  std::vector<MovingSize> sizes = {};
  std::vector<MovingDrop> drops = {};  // in order of sizes
  long steps = 0;                      // from time 0
};

// Whether the scene's rain needs a state.
bool needs_motion(const Rain& rain);

// The rain at time 0, with the moving parts posed then. Throws std::runtime_error for more than
// most_moving_drops.
DropMotion make_drop_motion(const Scene& scene);

// Back to time 0. Poses the scene's moving parts.
void start_drops(DropMotion& motion, Scene& scene);

// What the step from `step` on needs: `around` for its stage. Poses the scene's moving parts.
// Whether anything has changed.
bool prepare_stage(DropMotion& motion, Scene& scene, long step);

// Whether wind or surfaces change with time.
bool has_stages(const DropMotion& motion, const Scene& scene);

// One drop, one step of step_s. k: its number in its size.
MovingDrop stepped(const MovingDrop& drop, std::uint32_t k, const MovingSize& size,
                   const MotionSurroundings& around, double step_s = motion_step_s);

// How many steps have begun and ended at a time.
long steps_until(double time_s);

// Moves all drops to the last step before a time, from the beginning where that lies behind. Poses
// the scene's moving parts.
void move_drops(DropMotion& motion, Scene& scene, double time_s);

// A drop at a time within the step after its last one: it goes straight on. A falling one hits
// where its height above the surface of `top` straight below is fallen through, 1e30 for one that
// rises; of one that has hit, the centre is where it would be had it gone on. A velocity below
// least_speed_m_s, which has no direction to speak of, is that speed straight down.
constexpr double least_speed_m_s = 1e-3;
struct DropNow {
  Eigen::Vector3d centre_m = {0, 0, 0}, velocity_m_s = {0, 0, 0};
  double hit_time_s = 0;  // from now; <= 0: it has hit
};
DropNow drop_now(const DropMotion& motion, const MovingDrop& drop, const TopHeight& top,
                 double time_s);

// 32 bits of the drop's own.
std::uint32_t bits_of(const MovingSize& size, std::uint32_t k, const MovingDrop& drop);

}  // namespace pluvia
