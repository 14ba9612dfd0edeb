// The drops of a frame for the reference tracer: every one an analytic, oscillating surface that
// falls through the exposure, all of them in one Embree scene.
//
// Bounds. A centre moves on a line, and no point of a drop is ever farther from it than its reach
// (drop_reach_m, whatever the phases): the box around the reach at shutter-open, moved linearly to
// where it is at shutter-close, holds the drop at every moment between.
//
// Precision. Positions are relative to the camera, in double; Embree's float rays only find boxes,
// which are widened by what float loses. The surface is met in double, in the drop's own frame,
// from a double ray that travels beside the float one.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "raytrace/drop_field.h"
#include "raytrace/drop_intersect.h"
#include "raytrace/preset.h"
#include "raytrace/scene.h"

namespace pluvia {

struct FallingDrop {
  std::uint64_t id = 0;                  // of the drop list
  Eigen::Vector3d centre_m = {0, 0, 0};  // from the camera, at shutter-open
  Eigen::Vector3d velocity_m_s = {0, 0, -1};
  Eigen::Matrix3d world_from_drop = Eigen::Matrix3d::Identity();
  int shape = 0;     // of FallingDrops::shapes
  double end_s = 0;  // after shutter-open: its hit, at most the exposure
};

struct FallingDrops {
  std::vector<DropShape> shapes = {};  // time 0 is shutter-open
  std::vector<double> reach_m = {};    // of each shape
  std::vector<FallingDrop> drops = {};
  double exposure_s = 0;
};

// Of the list, those that the renderer draws too: that have not hit at shutter-open, whose path in
// the exposure stays out of the slab nearest_depth_m before and behind the camera plane
// (raytrace/streak_placement.h), and whose middle is in no lamp. Axes as a drop's picture has them,
// seen from the camera at the middle of the exposure. Throws as drop_shape does.
FallingDrops moving_drops(const Scene& scene, const std::vector<Drop>& drops, const Preset& preset);

// The surfaces at one time, made when they are asked for.
class Moment {
 public:
  Moment(const FallingDrops& drops, double time_s) : drops_(drops), time_s_(time_s) {}
  double time_s() const { return time_s_; }
  const DropInstant& shape(int index);

 private:
  const FallingDrops& drops_;
  double time_s_ = 0;
  std::deque<std::pair<int, DropInstant>> made_ = {};  // addresses stay
};

struct Ray {  // in the world, from the camera
  Eigen::Vector3d origin_m = {0, 0, 0};
  Eigen::Vector3d direction = {0, 1, 0};  // unit
};

// A ray in the frame of a drop, its centre at the origin.
Ray seen_from(const FallingDrop& drop, double time_s, const Ray& ray);

struct DropMeeting {
  int drop = -1;     // of FallingDrops::drops; -1: none
  DropHit hit = {};  // in its frame
};

class DropGeometry {
 public:
  // The drops must outlive it. Throws std::runtime_error when Embree cannot start.
  explicit DropGeometry(const FallingDrops& drops);
  ~DropGeometry();
  DropGeometry(const DropGeometry&) = delete;
  DropGeometry& operator=(const DropGeometry&) = delete;

  // The first drop that the ray meets from outside before far_m, other than `skip`. Thread-safe.
  std::optional<DropMeeting> nearest(const Ray& ray, Moment& moment, double far_m, int skip) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// The ray against one drop, from outside; nothing after its end.
std::optional<DropHit> meet_drop(const FallingDrops& drops, int drop, const Ray& ray,
                                 Moment& moment);

}  // namespace pluvia
