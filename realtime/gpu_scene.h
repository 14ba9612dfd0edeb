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

struct ShadowSlot {    // where a light's shadow maps are (realtime/shadow_pass.h)
  int first_map = -1;  // -1: none
  int maps = 0;
  double texel = 0;  // of a map, in m for the sun, else in m at 1 m from the light
};

// For scene.camera as it is now. slots: one for each light, or none at all.
std::vector<GpuLight> gpu_lights(const Scene& scene, const std::vector<ShadowSlot>& slots);

struct GpuCamera {  // w: focal length, width, height in px
  glm::vec4 right = {}, up = {}, forward = {};
};

GpuCamera gpu_camera(const Camera& camera);

// Mean radiance of the scene's environment over the sphere, cd/m^2; map: as read, nullptr where the
// scene names none.
glm::vec4 mean_environment(const EnvironmentLight& environment, const Image* map);

}  // namespace pluvia
