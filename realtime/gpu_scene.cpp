#include "realtime/gpu_scene.h"

#include "atlas/image_io.h"
#include "realtime/to_glm.h"

namespace pluvia {

std::vector<GpuLight> gpu_lights(const Scene& scene) {
  std::vector<GpuLight> lights;
  for (const PointLight& light : scene.lights)
    lights.push_back(
        {to_glm(light.position_m - scene.camera.position_m, 1), to_glm(light.intensity_cd, 0)});
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
