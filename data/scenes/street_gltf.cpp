#include <algorithm>
#include <cstring>

#include <tiny_gltf.h>

#include "data/scenes/street_shapes.h"

namespace street {
namespace {

struct Look {
  const char* name;
  std::array<double, 3> albedo;
  std::array<double, 3> emission_color;  // largest component 1, or 0
  double emission_cd_m2;
};

// Albedos of materials from tables of building physics, halved where the rain wets them. The
// rooms' radiances span a curtain to a bare bulb; lamp covers are frosted and far larger than the
// source.
constexpr std::array<Look, surfaces> looks = {{
    {"asphalt", {0.060, 0.060, 0.065}, {0, 0, 0}, 0},
    {"patch", {0.050, 0.050, 0.052}, {0, 0, 0}, 0},
    {"paint", {0.30, 0.30, 0.28}, {0, 0, 0}, 0},
    {"kerb", {0.11, 0.11, 0.105}, {0, 0, 0}, 0},
    {"paving", {0.08, 0.078, 0.075}, {0, 0, 0}, 0},
    {"brick", {0.10, 0.055, 0.05}, {0, 0, 0}, 0},
    {"plaster", {0.16, 0.14, 0.115}, {0, 0, 0}, 0},
    {"stone", {0.12, 0.115, 0.105}, {0, 0, 0}, 0},
    {"sooty", {0.07, 0.066, 0.066}, {0, 0, 0}, 0},
    {"trim", {0.15, 0.145, 0.135}, {0, 0, 0}, 0},
    {"roof", {0.09, 0.08, 0.08}, {0, 0, 0}, 0},
    {"door", {0.08, 0.12, 0.08}, {0, 0, 0}, 0},
    {"glass", {0.05, 0.055, 0.06}, {0, 0, 0}, 0},
    {"dim room", {0.1, 0.1, 0.1}, {1, 0.55, 0.22}, 2},
    {"lit room", {0.1, 0.1, 0.1}, {1, 0.62, 0.30}, 5},
    {"bright room", {0.1, 0.1, 0.1}, {1, 0.74, 0.45}, 15},
    {"shop", {0.1, 0.1, 0.1}, {1, 0.84, 0.60}, 5},
    {"metal", {0.12, 0.12, 0.13}, {0, 0, 0}, 0},
    {"car red", {0.25, 0.05, 0.05}, {0, 0, 0}, 0},
    {"car blue", {0.06, 0.09, 0.18}, {0, 0, 0}, 0},
    {"car grey", {0.30, 0.30, 0.31}, {0, 0, 0}, 0},
    {"tyre", {0.05, 0.05, 0.05}, {0, 0, 0}, 0},
    {"lamp sodium", {0.3, 0.3, 0.3}, {1, 0.55, 0.16}, 300},
    {"lamp white", {0.3, 0.3, 0.3}, {0.90, 0.96, 1}, 300},
}};

tinygltf::Material material(const Look& look) {
  tinygltf::Material m;
  m.name = look.name;
  const auto& a = look.albedo;
  m.pbrMetallicRoughness.baseColorFactor = {a[0], a[1], a[2], 1};
  m.pbrMetallicRoughness.metallicFactor = 0;
  const auto& e = look.emission_color;
  m.emissiveFactor = {e[0], e[1], e[2]};
  if (look.emission_cd_m2 > 0)
    m.extensions["KHR_materials_emissive_strength"] = tinygltf::Value(
        tinygltf::Value::Object{{"emissiveStrength", tinygltf::Value(look.emission_cd_m2)}});
  return m;
}

template <typename T>
int accessor(tinygltf::Model& model, const std::vector<T>& values, int component, int width) {
  auto& data = model.buffers[0].data;
  tinygltf::BufferView view;
  view.buffer = 0;
  view.byteOffset = data.size();
  view.byteLength = values.size() * sizeof(T);
  data.resize((data.size() + view.byteLength + 3) / 4 * 4);
  std::memcpy(data.data() + view.byteOffset, values.data(), view.byteLength);
  tinygltf::Accessor a;
  a.bufferView = static_cast<int>(model.bufferViews.size());
  a.componentType = component;
  a.type = width == 3 ? TINYGLTF_TYPE_VEC3 : TINYGLTF_TYPE_SCALAR;
  a.count = values.size() / static_cast<std::size_t>(width);
  if (width == 3) {  // glTF wants the bounds of positions
    a.minValues.assign(3, 1e30);
    a.maxValues.assign(3, -1e30);
    for (std::size_t i = 0; i < values.size(); ++i) {
      a.minValues[i % 3] = std::min(a.minValues[i % 3], static_cast<double>(values[i]));
      a.maxValues[i % 3] = std::max(a.maxValues[i % 3], static_cast<double>(values[i]));
    }
  }
  model.bufferViews.push_back(view);
  model.accessors.push_back(a);
  return a.bufferView;
}

tinygltf::Model model_of(const Street& street) {
  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = "make_street";
  model.extensionsUsed = {"KHR_materials_emissive_strength"};
  model.buffers.emplace_back();
  model.meshes.emplace_back();
  for (std::size_t i = 0; i < surfaces; ++i) {
    const Part& part = street.parts[i];
    if (part.indices.empty()) continue;
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.material = static_cast<int>(model.materials.size());
    primitive.attributes["POSITION"] =
        accessor(model, part.positions_m, TINYGLTF_COMPONENT_TYPE_FLOAT, 3);
    primitive.indices = accessor(model, part.indices, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, 1);
    model.meshes[0].primitives.push_back(primitive);
    model.materials.push_back(material(looks[i]));
  }
  model.nodes.emplace_back();
  model.nodes[0].mesh = 0;
  model.scenes.emplace_back();
  model.scenes[0].nodes = {0};
  model.defaultScene = 0;
  return model;
}

}  // namespace

bool write_gltf(const Street& street, const std::string& file) {
  const tinygltf::Model model = model_of(street);
  return tinygltf::TinyGLTF().WriteGltfSceneToFile(&model, file, true, true, true, false);
}

}  // namespace street
