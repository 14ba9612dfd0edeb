// All ways in which light can leave the drop toward the camera through one point of its surface,
// followed backward: the camera's ray meets the surface there, splits at every interface, and each
// ray that escapes is a direction from which light would reach the camera, with the share of power
// that arrives.
//
// Order p = number of segments inside the drop (0 reflection, 1 refraction, 2 one internal
// reflection ..). A ray that leaves a concave drop and meets it again goes on splitting. Paths are
// told apart by their signature: a hash of the choices (reflected, transmitted) at the interfaces
// met.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "oscillation/drop_shape.h"

namespace pluvia {

// A choice makes of a signature s: s x signature_factor + the term of the choice.
constexpr std::uint64_t signature_factor = 0x9E3779B97F4A7C15u;
constexpr std::uint64_t transmitted_term = 0xD1B54A32D192ED03u;
constexpr std::uint64_t reflected_term = 1;

struct PathOptions {
  double refractive_index = 1.333;  // water over air, >= 1
  int max_order = 3;                // orders 0 .. max_order
  double min_power = 1e-7;          // a beam below this share of the power is given up, and counted
};

// An exit of throughput 0 carries no light; it continues a path's map beyond the place where the
// path breaks off: total reflection (the direction is the tangent to which refracted rays tend) or
// a second meeting with the drop (the direction of the ray that meets it).
struct PathExit {
  std::uint64_t signature = 1;
  int order = 0;
  Eigen::Vector3d direction = {0, 0, 1};  // unit, from the drop toward the light
  double throughput = 0;                  // share of power for unpolarised light, 0 .. 1
  // The last interface, where direction and throughput come from (leave_interface). What meets it
  // is smooth also where it turns to total reflection; what leaves it is not.
  bool refracted = false;                // there, else reflected outside
  Eigen::Vector3d incident = {0, 0, 1};  // unit direction of the beam that meets it
  Eigen::Vector3d normal = {0, 0, 1};    // unit, against `incident`
  double power_s = 0, power_p = 0;  // of that beam; both 0 where the light meets the drop again
};

// What leaves an interface, from what meets it (inputs need not be of exactly unit length).
struct InterfaceExit {
  Eigen::Vector3d direction = {0, 0, 1};
  double throughput = 0;
  double margin = 1;  // squared cosine of refraction: < 0 where reflection is total
};
InterfaceExit leave_interface(bool refracted, const Eigen::Vector3d& incident,
                              const Eigen::Vector3d& normal, double power_s, double power_p,
                              double refractive_index);

// What did not escape within the options: the sum of all throughputs, of given_up and of
// beyond_order is 1 up to rounding. lost counts power of rays that grazed their own starting point
// (normally 0).
struct PathRemainder {
  double beyond_order = 0;
  double given_up = 0;
  double lost = 0;
};

// Appends the exits of one camera ray that meets the drop at `position` with outward `normal` (both
// relative to the drop's origin) in a fixed order.
//
// With normal . to_camera <= 0 the point lies beyond the outline and no light comes from there: the
// exits are the analytic continuation of the map past the outline (optics.h), so that a cell of the
// field which the outline cuts still has a smooth map. Reflected light is not tested for meeting
// the drop again and its throughput exceeds 1; refracted light has negative throughput. The
// remainder is zero then.
PathRemainder trace_exits(const DropInstant& drop, const Eigen::Vector3d& position_m,
                          const Eigen::Vector3d& normal, const Eigen::Vector3d& to_camera,
                          const PathOptions& options, std::vector<PathExit>& exits);

}  // namespace pluvia
