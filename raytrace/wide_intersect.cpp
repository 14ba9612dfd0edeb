#include "raytrace/wide_intersect.h"

#include <algorithm>
#include <cassert>

// Of Highway's instruction sets only these two: compiled here one after the other.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raytrace/wide_intersect.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_AVX3
#include "raytrace/wide_drop-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pluvia::HWY_NAMESPACE {

// Which lanes of the mask are set, one bit each.
HWY_INLINE unsigned bits_of(LaneMask mask) {
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(Tag(), mask, bits);
  return bits[0];
}

template <RaySide side>
void intersect_rays(const DropInstant& drop, std::span<const DropRay> rays,
                    std::optional<DropHit>* hits) {
  const DropLanes lanes(drop);
  const double scale = drop.surface.scale;
  for (std::size_t i = 0; i < rays.size(); i += lane_count) {
    const std::size_t count = std::min(lane_count, rays.size() - i);
    LaneVectors origins, directions;
    for (std::size_t k = 0; k < count; ++k) {
      origins.put(k, (rays[i + k].origin_m - drop.origin_m) / scale);
      directions.put(k, rays[i + k].direction);
    }
    const RayLanes ray = ray_lanes(load(origins), load(directions));
    const RootLanes root = first_root_lanes<side>(lanes, ray, hn::FirstN(Tag(), count));
    const MeetingLanes meeting = meeting_lanes(root.point);
    const LaneVectors positions = store(meeting.position), normals = store(meeting.normal);
    const unsigned found = bits_of(root.found);
    for (std::size_t k = 0; k < count; ++k) {
      if ((found >> k & 1) == 0) continue;
      DropHit& hit = hits[i + k].emplace();
      hit.position = drop.origin_m + scale * positions.at(k);
      hit.normal = normals.at(k);
      hit.distance = (hit.position - rays[i + k].origin_m).dot(rays[i + k].direction);
    }
  }
}

inline void see_points(const DropInstant& drop, std::span<const Eigen::Vector3d> directions,
                       const Eigen::Vector3d& to_camera, SurfacePoint* points) {
  const DropLanes lanes(drop);
  const Lanes3 camera = all(to_camera);
  for (std::size_t i = 0; i < directions.size(); i += lane_count) {
    const std::size_t count = std::min(lane_count, directions.size() - i);
    LaneVectors u;
    for (std::size_t k = 0; k < count; ++k) u.put(k, directions[i + k]);
    PointLanes point;
    point.u = load(u);
    point.surface = evaluate_lanes(lanes, point.u);
    const MeetingLanes at = meeting_lanes(point);
    const RootLanes root = first_root_lanes<RaySide::outside>(lanes, ray_lanes(at.position, camera),
                                                              hn::FirstN(Tag(), count));
    const LaneVectors positions = store(at.position), normals = store(at.normal);
    const unsigned hidden = bits_of(root.found);
    for (std::size_t k = 0; k < count; ++k) {
      points[i + k] = {drop.origin_m + drop.surface.scale * positions.at(k), normals.at(k),
                       (hidden >> k & 1) != 0};
    }
  }
}

}  // namespace pluvia::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif

#if HWY_ONCE
namespace pluvia {

namespace {

SurfacePoint surface_point(const DropInstant& drop, const Eigen::Vector3d& u,
                           const Eigen::Vector3d& to_camera) {
  SurfacePoint point;
  point.position_m = drop.origin_m + surface_radius_m(drop, u) * u;
  point.normal = surface_normal(drop, u);
  point.hidden = drop_occludes(drop, point.position_m, to_camera);
  return point;
}

template <RaySide side>
void intersect_wide(const DropInstant& drop, std::span<const DropRay> rays, Isa isa,
                    std::optional<DropHit>* hits) {
  if (isa == Isa::avx512) {
    N_AVX3::intersect_rays<side>(drop, rays, hits);
  } else {
    N_AVX2::intersect_rays<side>(drop, rays, hits);
  }
}

}  // namespace

std::vector<std::optional<DropHit>> intersect_drop_of(const DropInstant& drop,
                                                      std::span<const DropRay> rays, RaySide side,
                                                      Isa isa) {
  assert(cpu_has(isa));
  std::vector<std::optional<DropHit>> hits(rays.size());
  if (isa == Isa::scalar) {
    std::transform(rays.begin(), rays.end(), hits.begin(), [&](const DropRay& ray) {
      return intersect_drop(drop, ray.origin_m, ray.direction, side);
    });
  } else if (side == RaySide::outside) {
    intersect_wide<RaySide::outside>(drop, rays, isa, hits.data());
  } else {
    intersect_wide<RaySide::inside>(drop, rays, isa, hits.data());
  }
  return hits;
}

std::vector<SurfacePoint> surface_points_of(const DropInstant& drop,
                                            std::span<const Eigen::Vector3d> directions,
                                            const Eigen::Vector3d& to_camera, Isa isa) {
  assert(cpu_has(isa));
  std::vector<SurfacePoint> points(directions.size());
  if (isa == Isa::scalar) {
    std::transform(directions.begin(), directions.end(), points.begin(),
                   [&](const Eigen::Vector3d& u) { return surface_point(drop, u, to_camera); });
  } else if (isa == Isa::avx512) {
    N_AVX3::see_points(drop, directions, to_camera, points.data());
  } else {
    N_AVX2::see_points(drop, directions, to_camera, points.data());
  }
  return points;
}

}  // namespace pluvia
#endif
