#include "raytrace/reference_drops.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "raytrace/embree_device.h"
#include "raytrace/light.h"
#include "raytrace/physical_rain.h"
#include "raytrace/streak_placement.h"

namespace pluvia {
namespace {

bool is_drawn(const Scene& scene, const CameraFrame& camera, const Drop& drop) {
  if (!(drop.hit_time_s > 0)) return false;
  const Eigen::Vector3d path = drop.velocity_m_s * scene.camera.exposure_s;
  const double first = (drop.centre_m - scene.camera.position_m).dot(camera.forward);
  const double last = first + path.dot(camera.forward);
  if (std::min(first, last) < nearest_depth_m && std::max(first, last) > -nearest_depth_m)
    return false;
  const Eigen::Vector3d middle = drop.centre_m + path / 2;
  return std::none_of(scene.lights.begin(), scene.lights.end(), [&](const Light& light) {
    return inside_lamp(light, illumination(light, middle), drop.r0_m);
  });
}

// What float loses of the places that rays and boxes meet at: an origin and a direction rounded to
// 2^-24 each, and the steps of the box test, over the span that a ray can have between drops.
double float_loss_m(const FallingDrops& drops) {
  double farthest = 0;
  for (const FallingDrop& drop : drops.drops) {
    const Eigen::Vector3d last = drop.centre_m + drop.velocity_m_s * drops.exposure_s;
    farthest = std::max({farthest, drop.centre_m.norm(), last.norm()});
  }
  return 2 * farthest * std::ldexp(1.0, -20);
}

struct Query {
  RTCIntersectContext embree;  // first, so that the callback gets from its pointer to the whole
  const FallingDrops* drops;
  const Ray* ray;
  Moment* moment;
  double far_m;
  int skip;
  DropMeeting nearest;
};

void intersect_moving_drop(const RTCIntersectFunctionNArguments* args) {
  if (!args->valid[0]) return;
  auto* query = reinterpret_cast<Query*>(args->context);
  const auto index = static_cast<int>(args->primID);
  if (index == query->skip) return;
  const auto hit = meet_drop(*query->drops, index, *query->ray, *query->moment);
  if (!hit || hit->distance >= query->far_m) return;
  query->far_m = hit->distance;
  query->nearest = {index, *hit};
  auto* rayhit = reinterpret_cast<RTCRayHit*>(args->rayhit);
  rayhit->ray.tfar = std::nextafter(static_cast<float>(hit->distance), 1e30f);
  rayhit->hit.geomID = args->geomID;
  rayhit->hit.primID = args->primID;
}

}  // namespace

FallingDrops moving_drops(const Scene& scene, const std::vector<Drop>& drops,
                          const Preset& preset) {
  FallingDrops moving = {.exposure_s = scene.camera.exposure_s};
  const CameraFrame camera = camera_frame(scene.camera);
  std::map<std::pair<int, double>, int> shapes;
  for (const Drop& drop : drops) {
    if (!is_drawn(scene, camera, drop)) continue;
    const auto [shape, fresh] =
        shapes.try_emplace({drop.oscillation, drop.r0_m}, static_cast<int>(moving.shapes.size()));
    if (fresh) {
      moving.shapes.push_back(drop_shape(preset, drop.oscillation, drop.r0_m));
      moving.reach_m.push_back(drop_reach_m(moving.shapes.back()));
    }
    const Eigen::Vector3d centre_m = drop.centre_m - scene.camera.position_m;
    const Eigen::Vector3d middle = centre_m + drop.velocity_m_s * (moving.exposure_s / 2);
    moving.drops.push_back(
        {.id = drop.id,
         .centre_m = centre_m,
         .velocity_m_s = drop.velocity_m_s,
         .world_from_drop = drop_axes(camera, drop.velocity_m_s, -middle.normalized()),
         .shape = shape->second,
         .end_s = std::min(moving.exposure_s, drop.hit_time_s)});
  }
  return moving;
}

const DropInstant& Moment::shape(int index) {
  for (const auto& [known, instant] : made_) {
    if (known == index) return instant;
  }
  made_.emplace_back(index, drop_at(drops_.shapes[static_cast<std::size_t>(index)], time_s_));
  return made_.back().second;
}

Ray seen_from(const FallingDrop& drop, double time_s, const Ray& ray) {
  const Eigen::Vector3d centre_m = drop.centre_m + drop.velocity_m_s * time_s;
  return {drop.world_from_drop.transpose() * (ray.origin_m - centre_m),
          drop.world_from_drop.transpose() * ray.direction};
}

std::optional<DropHit> meet_drop(const FallingDrops& drops, int index, const Ray& ray,
                                 Moment& moment) {
  const FallingDrop& drop = drops.drops[static_cast<std::size_t>(index)];
  if (moment.time_s() >= drop.end_s) return {};
  const Ray own = seen_from(drop, moment.time_s(), ray);
  const double reach_m = drops.reach_m[static_cast<std::size_t>(drop.shape)];
  const double along = own.origin_m.dot(own.direction);
  if ((own.origin_m - along * own.direction).squaredNorm() > reach_m * reach_m) return {};
  if (along > reach_m) return {};
  const auto hit =
      intersect_drop(moment.shape(drop.shape), own.origin_m, own.direction, RaySide::outside);
  // Two drops of a random rain may overlap: a ray that starts inside one does not meet it.
  if (!hit || hit->distance < 0 || hit->normal.dot(own.direction) >= 0) return {};
  return hit;
}

struct DropGeometry::State {
  const FallingDrops& drops;
  double loss_m = 0;
  RTCScene scene = nullptr;

  static void bounds(const RTCBoundsFunctionArguments* args) {
    const auto* state = static_cast<const State*>(args->geometryUserPtr);
    const FallingDrop& drop = state->drops.drops[args->primID];
    const Eigen::Vector3d centre =
        drop.centre_m + drop.velocity_m_s * (args->timeStep * state->drops.exposure_s);
    const double half = state->drops.reach_m[static_cast<std::size_t>(drop.shape)] + state->loss_m;
    const auto low = [&](int k) {
      return std::nextafter(static_cast<float>(centre[k] - half), -1e30f);
    };
    const auto high = [&](int k) {
      return std::nextafter(static_cast<float>(centre[k] + half), 1e30f);
    };
    *args->bounds_o = {low(0), low(1), low(2), 0, high(0), high(1), high(2), 0};
  }
};

DropGeometry::DropGeometry(const FallingDrops& drops)
    : state_(new State{.drops = drops, .loss_m = float_loss_m(drops)}) {
  const RTCDevice device = embree_device();
  state_->scene = rtcNewScene(device);
  rtcSetSceneFlags(state_->scene, RTC_SCENE_FLAG_ROBUST);
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryTimeStepCount(geometry, 2);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(drops.drops.size()));
  rtcSetGeometryUserData(geometry, state_.get());
  rtcSetGeometryBoundsFunction(geometry, State::bounds, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersect_moving_drop);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(state_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(state_->scene);
}

DropGeometry::~DropGeometry() {
  rtcReleaseScene(state_->scene);
}

std::optional<DropMeeting> DropGeometry::nearest(const Ray& ray, Moment& moment, double far_m,
                                                 int skip) const {
  Query query = {};
  rtcInitIntersectContext(&query.embree);
  query.drops = &state_->drops;
  query.ray = &ray;
  query.moment = &moment;
  query.far_m = far_m;
  query.skip = skip;
  RTCRayHit rayhit = make_rayhit(ray.origin_m, ray.direction, far_m);
  const double exposure_s = state_->drops.exposure_s;
  rayhit.ray.time = static_cast<float>(std::clamp(moment.time_s() / exposure_s, 0.0, 1.0));
  rtcIntersect1(state_->scene, &query.embree, &rayhit);
  if (query.nearest.drop < 0) return {};
  return query.nearest;
}

}  // namespace pluvia
