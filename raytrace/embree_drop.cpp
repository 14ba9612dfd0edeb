#include "raytrace/embree_drop.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include <Eigen/Geometry>

#include "raytrace/embree_device.h"

namespace pluvia {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

// Carries the double-precision ray past Embree's single-precision one. The Embree part stands
// first, so that the callback can get from its pointer to the whole.
struct DropContext {
  RTCIntersectContext embree;
  const DropInstant* drop;
  Eigen::Vector3d origin_m, direction;
  RaySide side;
  std::optional<DropHit> hit;
};

void drop_bounds(const RTCBoundsFunctionArguments* args) {
  const auto radius = *static_cast<const float*>(args->geometryUserPtr);
  args->bounds_o->lower_x = args->bounds_o->lower_y = args->bounds_o->lower_z = -radius;
  args->bounds_o->upper_x = args->bounds_o->upper_y = args->bounds_o->upper_z = radius;
}

void intersect_analytic_drop(const RTCIntersectFunctionNArguments* args) {
  if (!args->valid[0]) return;
  auto* context = reinterpret_cast<DropContext*>(args->context);
  context->hit =
      intersect_drop(*context->drop, context->origin_m, context->direction, context->side);
  if (!context->hit) return;
  auto* rayhit = reinterpret_cast<RTCRayHit*>(args->rayhit);
  rayhit->ray.tfar = static_cast<float>(context->hit->distance);
  rayhit->hit.geomID = args->geomID;
  rayhit->hit.primID = args->primID;
}

}  // namespace

struct EmbreeDrop::State {
  RTCScene scene = nullptr;
  float radius = 0;
};

EmbreeDrop::EmbreeDrop(double bounding_radius_m) : state_(std::make_unique<State>()) {
  const RTCDevice device = embree_device();
  state_->radius = std::nextafter(static_cast<float>(bounding_radius_m) * 1.001f, 1e30f);
  state_->scene = rtcNewScene(device);
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, 1);
  rtcSetGeometryUserData(geometry, &state_->radius);
  rtcSetGeometryBoundsFunction(geometry, drop_bounds, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersect_analytic_drop);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(state_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(state_->scene);
}

EmbreeDrop::~EmbreeDrop() {
  rtcReleaseScene(state_->scene);
}

std::optional<DropHit> EmbreeDrop::intersect(const DropInstant& drop,
                                             const Eigen::Vector3d& origin_m,
                                             const Eigen::Vector3d& direction, RaySide side) const {
  DropContext context = {};
  rtcInitIntersectContext(&context.embree);
  context.drop = &drop;
  context.origin_m = origin_m;
  context.direction = direction;
  context.side = side;
  RTCRayHit rayhit = make_rayhit(origin_m, direction, infinite);
  rtcIntersect1(state_->scene, &context.embree, &rayhit);
  return rayhit.hit.geomID == RTC_INVALID_GEOMETRY_ID ? std::nullopt : context.hit;
}

SphereMesh sphere_mesh(int levels) {
  // By halving the edges of an octahedron; shared corners are shared.
  SphereMesh mesh = {
      .corners = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
      .triangles = {
          {0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<unsigned, unsigned>, unsigned> middles;
    const auto middle = [&](unsigned a, unsigned b) {
      const auto [at, fresh] =
          middles.try_emplace(std::minmax(a, b), static_cast<unsigned>(mesh.corners.size()));
      if (fresh) mesh.corners.push_back((mesh.corners[a] + mesh.corners[b]).normalized());
      return at->second;
    };
    std::vector<std::array<unsigned, 3>> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const unsigned ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d middle = (mesh.corners[a] + mesh.corners[b] + mesh.corners[c]) / 3;
    mesh.gap = std::max(mesh.gap, 1 - middle.norm());
  }
  return mesh;
}

struct MeshDrop::State {
  RTCScene scene = nullptr;
  const SphereMesh* sphere = nullptr;
  std::vector<Eigen::Vector3d> normals = {};
};

MeshDrop::MeshDrop(const DropInstant& drop, const SphereMesh& mesh)
    : state_(std::make_unique<State>()) {
  const RTCDevice device = embree_device();
  state_->sphere = &mesh;
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* corners = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                              RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                              mesh.corners.size()));
  for (const Eigen::Vector3d& u : mesh.corners) {
    const Eigen::Vector3d p = drop.origin_m + surface_radius_m(drop, u) * u;
    for (int k = 0; k < 3; ++k) *corners++ = static_cast<float>(p[k]);
    state_->normals.push_back(surface_normal(drop, u));
  }
  auto* indices = static_cast<unsigned*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(unsigned), mesh.triangles.size()));
  for (const auto& triangle : mesh.triangles) {
    for (const unsigned corner : triangle) *indices++ = corner;
  }
  rtcCommitGeometry(geometry);
  state_->scene = rtcNewScene(device);
  rtcAttachGeometry(state_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(state_->scene);
}

MeshDrop::~MeshDrop() {
  rtcReleaseScene(state_->scene);
}

std::size_t MeshDrop::triangle_count() const {
  return state_->sphere->triangles.size();
}

std::optional<DropHit> MeshDrop::intersect(const Eigen::Vector3d& origin_m,
                                           const Eigen::Vector3d& direction) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit rayhit = make_rayhit(origin_m, direction, infinite);
  rtcIntersect1(state_->scene, &context, &rayhit);
  if (rayhit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const auto& triangle = state_->sphere->triangles[rayhit.hit.primID];
  const double u = rayhit.hit.u, v = rayhit.hit.v;
  DropHit hit;
  hit.distance = rayhit.ray.tfar;
  hit.position = origin_m + hit.distance * direction;
  hit.normal = ((1 - u - v) * state_->normals[triangle[0]] + u * state_->normals[triangle[1]] +
                v * state_->normals[triangle[2]])
                   .normalized();
  return hit;
}

std::optional<DropHit> MeshDrop::intersect_polished(const DropInstant& drop,
                                                    const Eigen::Vector3d& origin_m,
                                                    const Eigen::Vector3d& direction) const {
  const std::optional<DropHit> start = intersect(origin_m, direction);
  if (!start) return std::nullopt;
  const double r0 = drop.surface.scale;
  DropHit hit = *start;
  for (int step = 0; step < 8; ++step) {
    const Eigen::Vector3d from_centre = hit.position - drop.origin_m;
    const Eigen::Vector3d u = from_centre.normalized();
    hit.normal = surface_normal(drop, u);
    const double above_m = from_centre.norm() - surface_radius_m(drop, u);
    if (std::abs(above_m) < 1e-12 * r0) return hit;
    // Height above the surface grows along the ray as direction . normal / (u . normal).
    hit.distance -= above_m * u.dot(hit.normal) / direction.dot(hit.normal);
    hit.position = origin_m + hit.distance * direction;
    if (!(std::abs(hit.distance - start->distance) < 0.5 * r0 && hit.distance > 0)) break;
  }
  return std::nullopt;
}

}  // namespace pluvia
