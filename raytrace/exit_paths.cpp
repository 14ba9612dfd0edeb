#include "raytrace/exit_paths.h"

#include "raytrace/drop_intersect.h"
#include "raytrace/optics.h"

namespace pluvia {

namespace {

// Two different choices lead to different 64-bit numbers (multiplication by an odd constant is a
// bijection), and equal sequences to equal ones.
std::uint64_t extend(std::uint64_t signature, bool transmitted) {
  return signature * signature_factor + (transmitted ? transmitted_term : reflected_term);
}

// A beam that has just left an interface.
struct Walker {
  Beam beam = {};
  PathExit last = {};  // the interface that the beam has left, and how
  Eigen::Vector3d position = {0, 0, 0};
  std::uint64_t signature = 1;
  int order = 0;
  RaySide side = RaySide::outside;
};

struct Tracer {
  const DropInstant& drop;
  const PathOptions& options;
  std::vector<PathExit>& exits;
  double sign = 1;  // of throughputs: -1 beyond the outline
  PathRemainder remainder = {};
  std::vector<Walker> open = {};

  void push(const Walker& from, const Beam& beam, bool transmitted) {
    Walker next = from;
    next.beam = beam;
    next.last.refracted = transmitted;
    next.signature = extend(from.signature, transmitted);
    if (transmitted) {
      next.side = from.side == RaySide::outside ? RaySide::inside : RaySide::outside;
    }
    if (next.side == RaySide::inside) ++next.order;
    const double share = power(beam);
    if (next.order > options.max_order) {
      remainder.beyond_order += share;
    } else if (share < options.min_power) {
      remainder.given_up += share;
    } else {
      open.push_back(next);
    }
  }

  // Splits `walker` at an interface; the outward normal is turned against the beam.
  void meet(Walker walker, const Eigen::Vector3d& position, const Eigen::Vector3d& outward) {
    const bool outside = walker.side == RaySide::outside;
    Eigen::Vector3d normal = outside ? outward : Eigen::Vector3d(-outward);
    if (normal.dot(walker.beam.direction) >= 0) {
      remainder.lost += power(walker.beam);  // a tangent touch, to rounding
      return;
    }
    const double ratio = outside ? 1 / options.refractive_index : options.refractive_index;
    const Split split = split_at_interface(walker.beam, normal, ratio);
    walker.position = position;
    note_interface(walker, normal, split);
    push(walker, split.reflected, false);
    if (!split.totally_reflected) {
      push(walker, split.refracted, true);
    } else if (!outside) {
      walker.signature = extend(walker.signature, true);
      walker.last.refracted = true;
      leave(walker, split.refracted.direction, 0);
    }
  }

  void note_interface(Walker& walker, const Eigen::Vector3d& normal, const Split& split) const {
    walker.last.incident = walker.beam.direction;
    walker.last.normal = normal;
    walker.last.power_s = sign * split.power_s;
    walker.last.power_p = sign * split.power_p;
  }

  void leave(const Walker& walker, const Eigen::Vector3d& direction, double throughput) {
    PathExit exit = walker.last;
    exit.signature = walker.signature;
    exit.order = walker.order;
    exit.direction = direction;
    exit.throughput = throughput;
    exits.push_back(exit);
  }

  // The first interface of a ray beyond the outline.
  void continue_past_outline(Walker walker, const Eigen::Vector3d& position,
                             const Eigen::Vector3d& outward) {
    const Split split = split_at_interface(walker.beam, outward, 1 / options.refractive_index);
    note_interface(walker, outward, split);
    Walker reflected = walker;
    reflected.signature = extend(walker.signature, false);
    leave(reflected, split.reflected.direction, power(split.reflected));
    sign = -1;
    walker.position = position;
    push(walker, split.refracted, true);
  }

  void advance(const Walker& walker) {
    const auto hit = intersect_drop(drop, walker.position, walker.beam.direction, walker.side);
    if (hit) {
      if (walker.side == RaySide::outside) {
        Walker dark = walker;
        dark.last.power_s = dark.last.power_p = 0;
        leave(dark, walker.beam.direction, 0);
      }
      meet(walker, hit->position, hit->normal);
    } else if (walker.side == RaySide::outside) {
      leave(walker, walker.beam.direction, sign * power(walker.beam));
    } else {
      remainder.lost += power(walker.beam);
    }
  }
};

}  // namespace

InterfaceExit leave_interface(bool refracted, const Eigen::Vector3d& incident,
                              const Eigen::Vector3d& normal, double power_s, double power_p,
                              double refractive_index) {
  const Eigen::Vector3d d = incident.normalized(), n = normal.normalized();
  const double ci = -d.dot(n);
  InterfaceExit exit;
  if (!refracted) {
    const FresnelPower r = fresnel_reflectance(ci, 1 / refractive_index);
    exit.direction = d + 2 * ci * n;
    exit.throughput = power_s * r.s + power_p * r.p;
    return exit;
  }
  exit.margin = squared_cosine_refracted(ci, refractive_index);
  exit.direction = refracted_direction(d, n, refractive_index);
  const FresnelPower r = fresnel_reflectance(ci, refractive_index);
  exit.throughput = power_s * (1 - r.s) + power_p * (1 - r.p);
  return exit;
}

PathRemainder trace_exits(const DropInstant& drop, const Eigen::Vector3d& position_m,
                          const Eigen::Vector3d& normal, const Eigen::Vector3d& to_camera,
                          const PathOptions& options, std::vector<PathExit>& exits) {
  Tracer tracer{.drop = drop, .options = options, .exits = exits};
  Walker camera;
  camera.beam = unpolarised_beam(-to_camera);
  const bool beyond_outline = normal.dot(to_camera) <= 0;
  if (beyond_outline) {
    tracer.continue_past_outline(camera, position_m, normal);
  } else {
    tracer.meet(camera, position_m, normal);
  }
  while (!tracer.open.empty()) {
    const Walker walker = tracer.open.back();
    tracer.open.pop_back();
    tracer.advance(walker);
  }
  return beyond_outline ? PathRemainder{} : tracer.remainder;
}

}  // namespace pluvia
