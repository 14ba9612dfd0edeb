#include "raytrace/reference_surfaces.h"

#include <cmath>

#include <Eigen/Geometry>

#include "raytrace/embree_device.h"

namespace pluvia {

struct SurfaceGeometry::State {
  const Mesh& mesh;
  RTCScene scene = nullptr;  // null: no surface
};

SurfaceGeometry::SurfaceGeometry(const Mesh& mesh, const Eigen::Vector3d& camera_m)
    : state_(new State{.mesh = mesh}) {
  if (mesh.indices.empty()) return;
  const RTCDevice device = embree_device();
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* corner = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                             RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                             mesh.positions_m.size()));
  for (const Eigen::Vector3f& position : mesh.positions_m) {
    const Eigen::Vector3d from_camera = position.cast<double>() - camera_m;
    for (int k = 0; k < 3; ++k) *corner++ = static_cast<float>(from_camera[k]);
  }
  auto* indices = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(std::uint32_t), mesh.indices.size() / 3));
  std::copy(mesh.indices.begin(), mesh.indices.end(), indices);
  rtcCommitGeometry(geometry);
  state_->scene = rtcNewScene(device);
  rtcSetSceneFlags(state_->scene, RTC_SCENE_FLAG_ROBUST);
  rtcAttachGeometry(state_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(state_->scene);
}

SurfaceGeometry::~SurfaceGeometry() {
  if (state_->scene) rtcReleaseScene(state_->scene);
}

std::optional<MetSurface> SurfaceGeometry::nearest(const Ray& ray, double far_m) const {
  if (!state_->scene) return {};
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit rayhit = make_rayhit(ray.origin_m, ray.direction, far_m);
  rtcIntersect1(state_->scene, &context, &rayhit);
  if (rayhit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  const Mesh& mesh = state_->mesh;
  const std::uint32_t* corner = &mesh.indices[3 * std::size_t{rayhit.hit.primID}];
  const double u = rayhit.hit.u, v = rayhit.hit.v;
  MetSurface point;
  point.distance_m = rayhit.ray.tfar;
  point.position_m = ray.origin_m + point.distance_m * ray.direction;
  point.normal =
      ((1 - u - v) * mesh.normals[corner[0]].cast<double>() +
       u * mesh.normals[corner[1]].cast<double>() + v * mesh.normals[corner[2]].cast<double>())
          .normalized();
  point.facet = Eigen::Vector3d(rayhit.hit.Ng_x, rayhit.hit.Ng_y, rayhit.hit.Ng_z).normalized();
  if (point.facet.dot(ray.direction) > 0) point.facet = -point.facet;
  point.material = mesh.materials[mesh.triangle_material[rayhit.hit.primID]];
  return point;
}

bool SurfaceGeometry::is_blocked(const Ray& ray, double far_m) const {
  if (!state_->scene) return false;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay embree = make_rayhit(ray.origin_m, ray.direction, far_m).ray;
  rtcOccluded1(state_->scene, &context, &embree);
  return embree.tfar < 0;
}

Eigen::Vector3d above_surface(const MetSurface& point, const Eigen::Vector3d& toward) {
  const double lift_m = 1e-5 * (1 + point.position_m.norm());
  return point.position_m + (point.facet.dot(toward) < 0 ? -lift_m : lift_m) * point.facet;
}

}  // namespace pluvia
