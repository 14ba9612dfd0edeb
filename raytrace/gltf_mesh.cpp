#include "raytrace/gltf_mesh.h"

#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "raytrace/gltf_file.h"

namespace pluvia {
namespace {

double factor(const GltfSource& source, const char* name, double value, double high) {
  if (!(value >= 0 && value <= high))
    refuse_gltf(source.file, fmt::format("{} {}", name, value), fmt::format("0 .. {}", high));
  return value;
}

Material read_material(const GltfSource& source, const tinygltf::Material& from) {
  Material material;
  double strength_cd_m2 = 1;
  if (const auto found = from.extensions.find(gltf_emissive_strength);
      found != from.extensions.end() && found->second.Has("emissiveStrength")) {
    const tinygltf::Value& strength = found->second.Get("emissiveStrength");
    if (!strength.IsNumber())
      refuse_gltf(source.file, "emissiveStrength is no number", "cd/m^2, >= 0");
    strength_cd_m2 = strength.GetNumberAsDouble();
  }
  factor(source, "emissiveStrength", strength_cd_m2, 1e10);
  const auto& color = from.pbrMetallicRoughness.baseColorFactor;
  if (color.size() < 3 || from.emissiveFactor.size() != 3)
    refuse_gltf(source.file, "material \"" + from.name + "\" has an incomplete colour",
                "3 numbers");
  for (int c = 0; c < 3; ++c) {
    const auto i = static_cast<std::size_t>(c);
    material.base_color[c] = factor(source, "baseColorFactor", color[i], 1);
    material.emission_cd_m2[c] =
        strength_cd_m2 * factor(source, "emissiveFactor", from.emissiveFactor[i], 1);
  }
  return material;
}

Eigen::Matrix4d local_transform(const GltfSource& source, const tinygltf::Node& node) {
  Eigen::Affine3d transform = Eigen::Affine3d::Identity();
  const auto vector = [](const std::vector<double>& v) { return Eigen::Vector3d(v.data()); };
  if (node.matrix.size() == 16) return Eigen::Matrix4d(node.matrix.data());
  if (node.translation.size() == 3) transform.translate(vector(node.translation));
  if (node.rotation.size() == 4) {
    const Eigen::Quaterniond rotation(Eigen::Vector4d(node.rotation.data()));
    if (!(std::abs(rotation.norm() - 1) < 1e-3))
      refuse_gltf(source.file,
                  fmt::format("node \"{}\": rotation of length {}", node.name, rotation.norm()),
                  "a unit quaternion");
    transform.rotate(rotation.normalized());
  }
  if (node.scale.size() == 3) transform.scale(vector(node.scale));
  return transform.matrix();
}

// glTF's axes in the world: x = X, y = -Z, z = Y.
Eigen::Matrix4d world_from_gltf() {
  Eigen::Matrix4d turn = Eigen::Matrix4d::Zero();
  turn(0, 0) = turn(2, 1) = turn(3, 3) = 1;
  turn(1, 2) = -1;
  return turn;
}

struct Corners {  // one primitive in the world
  std::vector<Eigen::Vector3d> positions = {};
  std::vector<Eigen::Vector3d> normals = {};  // empty: flat
  std::vector<std::uint32_t> indices = {};
};

std::uint32_t add_vertex(Mesh& mesh, const Eigen::Vector3d& position,
                         const Eigen::Vector3d& normal) {
  mesh.positions_m.push_back(position.cast<float>());
  mesh.normals.push_back(normal.cast<float>());
  return static_cast<std::uint32_t>(mesh.positions_m.size() - 1);
}

void add_triangles(Mesh& mesh, const Corners& corners, std::uint32_t material) {
  const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
  const bool flat = corners.normals.empty();
  if (!flat)
    for (std::size_t i = 0; i < corners.positions.size(); ++i)
      add_vertex(mesh, corners.positions[i], corners.normals[i]);
  for (std::size_t t = 0; t < corners.indices.size(); t += 3) {
    const std::uint32_t* index = &corners.indices[t];
    const auto& a = corners.positions[index[0]];
    const auto& b = corners.positions[index[1]];
    const auto& c = corners.positions[index[2]];
    const Eigen::Vector3d area = (b - a).cross(c - a);
    if (!(area.norm() > 0)) continue;
    for (int i = 0; i < 3; ++i)
      mesh.indices.push_back(flat ? add_vertex(mesh, corners.positions[index[i]], area.normalized())
                                  : first + index[i]);
    mesh.triangle_material.push_back(material);
  }
}

// To the world. A transform that mirrors turns the triangles over.
Corners read_corners(const GltfSource& source, const tinygltf::Primitive& primitive,
                     const Eigen::Matrix4d& transform) {
  const auto position = primitive.attributes.find("POSITION");
  if (position == primitive.attributes.end())
    refuse_gltf(source.file, "a primitive without POSITION", "one");
  Corners corners;
  const Eigen::Matrix3d linear = transform.topLeftCorner<3, 3>();
  const Eigen::Vector3d offset = transform.topRightCorner<3, 1>();
  for (const auto& p : read_gltf_vectors(source, position->second, "POSITION")) {
    corners.positions.push_back(linear * p + offset);
    if (!corners.positions.back().allFinite() || corners.positions.back().norm() > 1e6)
      refuse_gltf(source.file, "a transform moves a position beyond 1e6 m", "nearer ones");
  }
  corners.indices = read_gltf_indices(source, primitive.indices, corners.positions.size());
  if (linear.determinant() < 0)
    for (std::size_t t = 0; t < corners.indices.size(); t += 3)
      std::swap(corners.indices[t + 1], corners.indices[t + 2]);
  const auto normal = primitive.attributes.find("NORMAL");
  if (normal == primitive.attributes.end()) return corners;
  const Eigen::Matrix3d cofactors = linear.inverse().transpose();
  for (const auto& n : read_gltf_vectors(source, normal->second, "NORMAL")) {
    if (!(n.norm() > 0.5 && n.norm() < 2))
      refuse_gltf(source.file, fmt::format("a normal of length {}", n.norm()), "1");
    corners.normals.push_back((cofactors * n).normalized());
  }
  if (corners.normals.size() != corners.positions.size())
    refuse_gltf(source.file, fmt::format("{} normals", corners.normals.size()),
                fmt::format("{}, one per position", corners.positions.size()));
  return corners;
}

void add_mesh(Mesh& mesh, const GltfSource& source, const tinygltf::Mesh& from,
              const Eigen::Matrix4d& transform) {
  const auto default_material = static_cast<std::uint32_t>(source.model.materials.size());
  for (const tinygltf::Primitive& primitive : from.primitives) {
    if (primitive.mode != -1 && primitive.mode != TINYGLTF_MODE_TRIANGLES)
      refuse_gltf(source.file, fmt::format("a primitive of mode {}", primitive.mode),
                  "4, triangles");
    std::uint32_t material = default_material;
    if (primitive.material >= 0) {
      gltf_element(source, source.model.materials, primitive.material, "material");
      material = static_cast<std::uint32_t>(primitive.material);
    }
    add_triangles(mesh, read_corners(source, primitive, transform), material);
  }
}

struct Visit {
  int node = 0;
  Eigen::Matrix4d parent = Eigen::Matrix4d::Identity();
};

// The default scene's nodes, parents first. A stack of our own: a long chain must not use up the
// program's.
void add_nodes(Mesh& mesh, const GltfSource& source, const std::vector<int>& roots) {
  std::vector<bool> seen(source.model.nodes.size(), false);
  std::vector<Visit> stack;
  for (auto root = roots.rbegin(); root != roots.rend(); ++root)
    stack.push_back({*root, world_from_gltf()});
  while (!stack.empty()) {
    const Visit visit = stack.back();
    stack.pop_back();
    const auto& node = gltf_element(source, source.model.nodes, visit.node, "node");
    const auto index = static_cast<std::size_t>(visit.node);
    if (seen[index])
      refuse_gltf(source.file, fmt::format("node {} is reached twice", visit.node), "a tree");
    seen[index] = true;
    const Eigen::Matrix4d transform = visit.parent * local_transform(source, node);
    const double volume = transform.topLeftCorner<3, 3>().determinant();
    if (!transform.allFinite() || !std::isnormal(volume))
      refuse_gltf(source.file,
                  fmt::format("node {} has a transform of determinant {}", visit.node, volume),
                  "one that can be inverted");
    if (node.mesh >= 0)
      add_mesh(mesh, source, gltf_element(source, source.model.meshes, node.mesh, "mesh"),
               transform);
    for (auto child = node.children.rbegin(); child != node.children.rend(); ++child)
      stack.push_back({*child, transform});
  }
}

}  // namespace

Mesh read_gltf_mesh(const std::string& file) {
  const GltfSource source = load_gltf(file);
  Mesh mesh;
  for (const auto& material : source.model.materials)
    mesh.materials.push_back(read_material(source, material));
  mesh.materials.push_back({.base_color = {1, 1, 1}, .emission_cd_m2 = {0, 0, 0}});
  const int scene = source.model.defaultScene < 0 ? 0 : source.model.defaultScene;
  add_nodes(mesh, source, gltf_element(source, source.model.scenes, scene, "scene").nodes);
  return mesh;
}

}  // namespace pluvia
