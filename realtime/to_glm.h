// The one place where the scene's Eigen vectors become GLM's.
#pragma once

#include <Eigen/Core>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace pluvia {

inline glm::vec3 to_glm(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

inline glm::vec4 to_glm(const Eigen::Vector3d& v, double w) {
  return {to_glm(v), static_cast<float>(w)};
}

}  // namespace pluvia
