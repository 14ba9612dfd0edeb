#include "raytrace/embree_device.h"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace pluvia {

RTCDevice embree_device() {
  static const RTCDevice device = rtcNewDevice(nullptr);
  if (!device) throw std::runtime_error("embree: no device; expected a working Embree 3 library");
  return device;
}

RTCRayHit make_rayhit(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction,
                      double far_m) {
  RTCRayHit r = {};
  r.ray.org_x = static_cast<float>(origin_m.x());
  r.ray.org_y = static_cast<float>(origin_m.y());
  r.ray.org_z = static_cast<float>(origin_m.z());
  r.ray.dir_x = static_cast<float>(direction.x());
  r.ray.dir_y = static_cast<float>(direction.y());
  r.ray.dir_z = static_cast<float>(direction.z());
  r.ray.tfar = std::nextafter(static_cast<float>(far_m), std::numeric_limits<float>::infinity());
  r.ray.mask = 0xffffffffu;
  r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return r;
}

}  // namespace pluvia
