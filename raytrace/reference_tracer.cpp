#include "raytrace/reference_tracer.h"

#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Geometry>

namespace pluvia {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr int sure_order = 20;  // up to it a beam always goes on
// What leaves a drop with less power goes on with the probability of its share of this.
constexpr double sure_power = 2e-3;

struct Walker {
  Beam beam = {};
  Eigen::Vector3d position_m = {0, 0, 0};
  RaySide side = RaySide::outside;
  int order = 0;
};

void scale_power(Beam& beam, double factor) {
  beam.field *= std::sqrt(factor);
}

struct DropFollower {
  const DropInstant& drop;
  double refractive_index;
  int split_order;
  CounterRandom& random;
  const std::function<void(const DropExit&)>& escape;
  std::vector<Walker> open = {};

  // Two beams leave an interface; both are followed, or one.
  void split(const Walker& at, const Eigen::Vector3d& outward) {
    const bool outside = at.side == RaySide::outside;
    const Eigen::Vector3d normal = outside ? outward : Eigen::Vector3d(-outward);
    const double ratio = outside ? 1 / refractive_index : refractive_index;
    const Split parts = split_at_interface(at.beam, normal, ratio);
    const double reflected = power(parts.reflected);
    const double whole = reflected + (parts.totally_reflected ? 0 : power(parts.refracted));
    if (at.order <= split_order) {
      push(at, parts.reflected, at.side);
      if (!parts.totally_reflected) push(at, parts.refracted, across(at.side));
    } else if (parts.totally_reflected || random.next() * whole < reflected) {
      push(at, parts.reflected, at.side, parts.totally_reflected ? 1 : whole / reflected);
    } else {
      push(at, parts.refracted, across(at.side), whole / power(parts.refracted));
    }
  }

  static RaySide across(RaySide side) {
    return side == RaySide::outside ? RaySide::inside : RaySide::outside;
  }

  void push(const Walker& from, const Beam& beam, RaySide side, double factor = 1) {
    if (beam.field.isZero(0)) return;
    Walker next = {beam, from.position_m, side, from.order};
    if (side == RaySide::inside) ++next.order;
    if (next.order > sure_order) {
      const double survival = 1 - 0.5 / next.order;
      if (random.next() >= survival) return;
      factor /= survival;
    }
    scale_power(next.beam, factor);
    open.push_back(next);
  }

  // To the next interface, or away.
  void advance(Walker walker) {
    const auto hit = intersect_drop(drop, walker.position_m, walker.beam.direction, walker.side);
    const double toward = hit ? hit->normal.dot(walker.beam.direction) : 0;
    const bool outside = walker.side == RaySide::outside;
    if (hit && (outside ? toward < 0 : toward > 0)) {
      walker.position_m = hit->position;
      split(walker, hit->normal);
    } else if (outside) {
      escape({walker.order, walker.position_m, walker.beam});
    }  // inside, a beam that grazes its own start to rounding carries no measurable power
  }
};

Beam turned(const Beam& beam, const Eigen::Matrix3d& rotation) {
  return {rotation * beam.direction, rotation * beam.field};
}

struct Leaving {  // a drop, in the world
  int drop = -1;
  Eigen::Vector3d origin_m = {0, 0, 0};
  Beam beam = {};
};

struct Tracer {
  const ReferenceScene& scene;
  Moment& moment;
  CounterRandom& random;

  void follow(const DropMeeting& meeting, const Beam& beam, int split_order,
              const std::function<void(const Leaving&)>& leave) const {
    const FallingDrop& drop = scene.drops.drops[static_cast<std::size_t>(meeting.drop)];
    const Eigen::Vector3d centre_m = drop.centre_m + drop.velocity_m_s * moment.time_s();
    follow_drop(moment.shape(drop.shape), meeting.hit,
                turned(beam, drop.world_from_drop.transpose()), scene.options.refractive_index,
                split_order, random, [&](const DropExit& exit) {
                  const int most = scene.options.most_order;
                  if (most > 0 && exit.order > most) return;
                  leave({meeting.drop, centre_m + drop.world_from_drop * exit.position_m,
                         turned(exit.beam, drop.world_from_drop)});
                });
  }

  // Light along a beam that has left a drop, from all that it meets from there on.
  Eigen::Vector3d radiance(Leaving at) const {
    Eigen::Vector3d sum = {0, 0, 0};
    while (at.drop >= 0) {
      const double share = power(at.beam);
      if (share < sure_power) {
        if (random.next() * sure_power >= share) return sum;
        scale_power(at.beam, sure_power / share);
      }
      at = step(at, sum);
    }
    return sum;
  }

  Eigen::Vector3d seen_from_drop(MetSurface point) const {
    if (!scene.options.drops_see_emission) point.material.emission_cd_m2.setZero();
    return surface_radiance(scene, point, random);
  }

  // Adds what is seen before the next drop, and goes through that one by a single way.
  Leaving step(const Leaving& at, Eigen::Vector3d& sum) const {
    const double share = power(at.beam);
    const Ray ray = {at.origin_m, at.beam.direction};
    const auto surface = scene.surfaces->nearest(ray, infinite);
    const double surface_m = surface ? surface->distance_m : infinite;
    const auto next = scene.falling->nearest(ray, moment, surface_m, at.drop);
    sum += share * lamp_radiance(scene, ray, surface_m, next ? next->hit.distance : infinite);
    Leaving further;
    if (next) {
      follow(*next, at.beam, -1, [&](const Leaving& exit) { further = exit; });
    } else {
      sum += share *
             (surface ? seen_from_drop(*surface) : environment_radiance(scene, at.beam.direction));
    }
    return further;
  }
};

}  // namespace

void follow_drop(const DropInstant& drop, const DropHit& hit, const Beam& beam,
                 double refractive_index, int split_order, CounterRandom& random,
                 const std::function<void(const DropExit&)>& escape) {
  DropFollower follower{drop, refractive_index, split_order, random, escape};
  follower.split({beam, hit.position, RaySide::outside, 0}, hit.normal);
  while (!follower.open.empty()) {
    const Walker walker = follower.open.back();
    follower.open.pop_back();
    follower.advance(walker);
  }
}

Eigen::Vector3d background_radiance(const ReferenceScene& scene, const Ray& ray,
                                    CounterRandom& random) {
  const auto surface = scene.surfaces->nearest(ray, infinite);
  return surface ? surface_radiance(scene, *surface, random)
                 : environment_radiance(scene, ray.direction);
}

Eigen::Vector3d drop_radiance(const ReferenceScene& scene, const Ray& ray,
                              const DropMeeting& meeting, Moment& moment, CounterRandom& random) {
  const Tracer tracer{scene, moment, random};
  Eigen::Vector3d sum = {0, 0, 0};
  tracer.follow(meeting, unpolarised_beam(ray.direction), scene.options.split_order,
                [&](const Leaving& exit) { sum += tracer.radiance(exit); });
  return sum;
}

CameraSample trace_camera_ray(const ReferenceScene& scene, const Ray& ray, double time_s,
                              CounterRandom& random) {
  Moment moment(scene.drops, time_s);
  const auto surface = scene.surfaces->nearest(ray, infinite);
  const auto drop =
      scene.falling->nearest(ray, moment, surface ? surface->distance_m : infinite, -1);
  if (drop) return {drop_radiance(scene, ray, *drop, moment, random), drop->drop};
  return {surface ? surface_radiance(scene, *surface, random)
                  : environment_radiance(scene, ray.direction)};
}

}  // namespace pluvia
