// Light that reaches the camera along a ray, through all orders of every drop it meets.
//
// A beam with its polarisation (raytrace/optics.h) is followed backward. At an interface of the
// first drop it splits into what is reflected and what is refracted, both of which are followed, up
// to order split_order (segments inside the drop); beyond it, and in every further drop, one of the
// two is chosen with the probability of its share of the power. Beyond order 20 a beam goes on with
// probability 1 - 1/(2 order) and counts as many times more: total reflection may hold light for
// long, the share that is still inside falls as 1/order, so with these the expected work and the
// variance are both finite. All choices are unbiased: nothing is cut off.
//
// What leaves a drop goes on into the scene: lamps by their discs, then another drop, or a surface,
// or the environment.
#pragma once

#include <functional>

#include "raytrace/optics.h"
#include "raytrace/reference_scene.h"

namespace pluvia {

struct DropExit {
  int order = 0;
  Eigen::Vector3d position_m = {0, 0, 0};  // in the drop's frame, as is the beam
  Beam beam = {};
};

// All ways out of a drop for a beam that meets it from outside (position and outward normal in its
// frame). split_order -1: one way, chosen. Calls escape for each.
void follow_drop(const DropInstant& drop, const DropHit& hit, const Beam& beam,
                 double refractive_index, int split_order, CounterRandom& random,
                 const std::function<void(const DropExit&)>& escape);

// Without any drop: surfaces or the environment.
Eigen::Vector3d background_radiance(const ReferenceScene& scene, const Ray& ray,
                                    CounterRandom& random);

// Of a camera's ray that meets that drop there.
Eigen::Vector3d drop_radiance(const ReferenceScene& scene, const Ray& ray,
                              const DropMeeting& meeting, Moment& moment, CounterRandom& random);

// The plain way: whatever the ray meets first.
struct CameraSample {
  Eigen::Vector3d radiance = {0, 0, 0};
  int drop = -1;  // that it met first; -1: none
};
CameraSample trace_camera_ray(const ReferenceScene& scene, const Ray& ray, double time_s,
                              CounterRandom& random);

}  // namespace pluvia
