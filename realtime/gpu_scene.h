// Lights and the camera as shaders read them.
#pragma once

#include <vector>

#include <glm/vec4.hpp>

#include "atlas/image.h"
#include "raytrace/scene.h"

namespace pluvia {

struct GpuLight {  // Light of lights.glsl
  glm::vec4 place = {};
  glm::vec4 intensity = {};
  glm::vec4 axis = {};
  glm::vec4 more = {};
};

std::vector<GpuLight> gpu_lights(const Scene& scene);

struct GpuCamera {  // w: focal length, width, height in px
  glm::vec4 right = {}, up = {}, forward = {};
};

GpuCamera gpu_camera(const Camera& camera);

// Mean radiance of the scene's environment over the sphere, cd/m^2; map: as read, nullptr where the
// scene names none.
glm::vec4 mean_environment(const EnvironmentLight& environment, const Image* map);

}  // namespace pluvia
