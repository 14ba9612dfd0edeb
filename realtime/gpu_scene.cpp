#include "realtime/gpu_scene.h"

#include "atlas/image_io.h"
#include "raytrace/light.h"
#include "realtime/to_glm.h"

namespace pluvia {

std::vector<GpuLight> gpu_lights(const Scene& scene, const std::vector<ShadowSlot>& slots) {
  std::vector<GpuLight> lights;
  for (const Light& light : scene.lights) {
    GpuLight gpu = {.axis = {0, 0, 0, -2}, .more = {1, -1, 0, 0}};
    if (light.kind == LightKind::sun) {
      gpu.place = to_glm(-light.direction, 0);
      gpu.intensity = to_glm(light.illuminance_lux, 0);
    } else {
      gpu.place = to_glm(light.position_m - scene.camera.position_m, 1);
      gpu.intensity = to_glm(light.intensity_cd, light.radius_m);
    }
    if (light.kind == LightKind::spot) {
      const SpotCosines rim = spot_cosines(light);
      gpu.axis = to_glm(light.direction, rim.outer);
      gpu.more.x = static_cast<float>(1 / (rim.inner - rim.outer));
    }
    if (!slots.empty()) {
      const ShadowSlot& slot = slots[lights.size()];
      gpu.more.y = static_cast<float>(slot.first_map);
      gpu.more.z = static_cast<float>(slot.maps);
      gpu.more.w = static_cast<float>(slot.texel);
    }
    lights.push_back(gpu);
  }
  return lights;
}

GpuCamera gpu_camera(const Camera& camera) {
  const CameraFrame frame = camera_frame(camera);
  return {to_glm(frame.right, frame.focal_px), to_glm(frame.up, camera.width_px),
          to_glm(frame.forward, camera.height_px)};
}

glm::vec4 mean_environment(const EnvironmentLight& environment, const Image* map) {
  if (!map) return to_glm(environment.uniform_cd_m2, 0);
  const std::vector<double> mean = mean_over_sphere(*map);
  return to_glm(environment.scale_cd_m2 * Eigen::Vector3d(mean[0], mean[1], mean[2]), 0);
}

}  // namespace pluvia
