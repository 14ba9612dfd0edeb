#include "raytrace/moving_parts.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "raytrace/key_path.h"

namespace pluvia {
namespace {

bool pose_part(const MovingPart& part, double time_s, Mesh& mesh) {
  const Eigen::Vector3d place_m = along_path(part.path, time_s, &MovingKey::position_m);
  const double heading_deg = along_path(part.path, time_s, &MovingKey::heading_deg);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(heading_deg * std::numbers::pi / 180, Eigen::Vector3d::UnitZ())
          .toRotationMatrix();
  bool moved = false;
  for (std::size_t i = 0; i < part.positions_m.size(); ++i) {
    const Eigen::Vector3d position_m = place_m + turn * part.positions_m[i].cast<double>();
    const Eigen::Vector3d normal = turn * part.normals[i].cast<double>();
    const std::size_t vertex = part.first_vertex + i;
    const Eigen::Vector3f posed = position_m.cast<float>(), faced = normal.cast<float>();
    moved = moved || posed != mesh.positions_m[vertex] || faced != mesh.normals[vertex];
    mesh.positions_m[vertex] = posed;
    mesh.normals[vertex] = faced;
  }
  return moved;
}

}  // namespace

void add_moving_part(Scene& scene, const Mesh& shape, const std::vector<MovingKey>& path) {
  Mesh& mesh = scene.mesh;
  MovingPart part = {.path = path,
                     .positions_m = shape.positions_m,
                     .normals = shape.normals,
                     .first_vertex = mesh.positions_m.size(),
                     .first_index = mesh.indices.size(),
                     .index_count = shape.indices.size()};
  const auto first_material = static_cast<std::uint32_t>(mesh.materials.size());
  mesh.positions_m.insert(mesh.positions_m.end(), shape.positions_m.begin(),
                          shape.positions_m.end());
  mesh.normals.insert(mesh.normals.end(), shape.normals.begin(), shape.normals.end());
  for (const std::uint32_t index : shape.indices)
    mesh.indices.push_back(static_cast<std::uint32_t>(part.first_vertex) + index);
  mesh.materials.insert(mesh.materials.end(), shape.materials.begin(), shape.materials.end());
  for (const std::uint32_t material : shape.triangle_material)
    mesh.triangle_material.push_back(first_material + material);
  pose_part(part, 0, mesh);
  scene.moving.push_back(std::move(part));
}

bool pose(Scene& scene, double time_s) {
  bool moved = false;
  for (const MovingPart& part : scene.moving) moved = pose_part(part, time_s, scene.mesh) || moved;
  return moved;
}

Scene scene_at(Scene scene, double time_s) {
  scene.camera = camera_at(scene, time_s);
  scene.environment.picture = clip_picture(scene.environment, time_s);
  pose(scene, time_s);
  return scene;
}

std::size_t resting_vertices(const Scene& scene) {
  return scene.moving.empty() ? scene.mesh.positions_m.size() : scene.moving.front().first_vertex;
}

std::size_t resting_indices(const Scene& scene) {
  return scene.moving.empty() ? scene.mesh.indices.size() : scene.moving.front().first_index;
}

Bounds reach_of(const MovingPart& part) {
  Bounds path;
  for (std::size_t i = 0; i + 1 < part.path.size(); ++i) {
    for (const Eigen::Vector3d& p : path_hull(part.path, i, &MovingKey::position_m)) path.add(p);
  }
  path.add(part.path.back().position_m);
  // Whatever its heading, it is inside its circle about z.
  double radius_m = 0, low_m = 1e300, high_m = -1e300;
  for (const Eigen::Vector3f& position : part.positions_m) {
    const Eigen::Vector3d p = position.cast<double>();
    radius_m = std::max(radius_m, std::hypot(p.x(), p.y()));
    low_m = std::min(low_m, p.z());
    high_m = std::max(high_m, p.z());
  }
  return {path.low_m + Eigen::Vector3d(-radius_m, -radius_m, low_m),
          path.high_m + Eigen::Vector3d(radius_m, radius_m, high_m)};
}

Bounds surface_bounds(const Scene& scene) {
  Bounds all;
  for (std::size_t i = 0; i < resting_vertices(scene); ++i)
    all.add(scene.mesh.positions_m[i].cast<double>());
  for (const MovingPart& part : scene.moving) {
    const Bounds reach = reach_of(part);
    all.add(reach.low_m);
    all.add(reach.high_m);
  }
  return all;
}

}  // namespace pluvia
