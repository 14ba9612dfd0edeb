#include "raytrace/gltf_file.h"

#include <cmath>
#include <cstring>
#include <exception>
#include <filesystem>
#include <stdexcept>

namespace pluvia {
namespace {

constexpr double farthest_m = 1e6;  // beyond it a float is coarser than 6 cm

// Pictures are not read: a surface's colour is its factor.
bool ignore_image(tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*,
                  int, void*) {
  return true;
}

// The bytes of an accessor's elements: all of them inside the buffer.
struct View {
  const unsigned char* bytes = nullptr;
  std::size_t stride = 0;
  std::size_t count = 0;
};

View view_of(const GltfSource& source, int accessor_index, std::size_t element_size) {
  const auto& accessor = gltf_element(source, source.model.accessors, accessor_index, "accessor");
  if (accessor.sparse.isSparse)
    refuse_gltf(source.file, fmt::format("accessor {} is sparse", accessor_index), "a plain one");
  const auto& view =
      gltf_element(source, source.model.bufferViews, accessor.bufferView, "bufferView");
  const auto& buffer = gltf_element(source, source.model.buffers, view.buffer, "buffer");
  const std::size_t stride = view.byteStride == 0 ? element_size : view.byteStride;
  // Divisions, not products: a hostile count must not overflow.
  const bool view_fits = view.byteOffset <= buffer.data.size() &&
                         view.byteLength <= buffer.data.size() - view.byteOffset;
  const bool offset_fits = accessor.byteOffset <= view.byteLength &&
                           element_size <= view.byteLength - accessor.byteOffset;
  const bool count_fits =
      offset_fits && stride >= element_size &&
      accessor.count <= 1 + (view.byteLength - accessor.byteOffset - element_size) / stride;
  if (accessor.count == 0 || !view_fits || !count_fits)
    refuse_gltf(
        source.file,
        fmt::format("accessor {}: {} elements of {} bytes from byte {} of a view of {} bytes",
                    accessor_index, accessor.count, element_size, accessor.byteOffset,
                    view.byteLength),
        "1 or more, all inside the view and its buffer");
  return {buffer.data.data() + view.byteOffset + accessor.byteOffset, stride, accessor.count};
}

template <typename T>
std::vector<std::uint32_t> widen(const View& view) {
  std::vector<std::uint32_t> values(view.count);
  for (std::size_t i = 0; i < view.count; ++i) {
    T value;
    std::memcpy(&value, view.bytes + i * view.stride, sizeof(T));
    values[i] = value;
  }
  return values;
}

}  // namespace

void refuse_gltf(const std::string& file, std::string what, const std::string& expected) {
  for (char& c : what)
    if (c == '\n' || c == '\r') c = ' ';
  while (!what.empty() && what.back() == ' ') what.pop_back();
  throw std::runtime_error(fmt::format("{}: {}; expected {}", file, what, expected));
}

GltfSource load_gltf(const std::string& file) {
  GltfSource source{file, {}};
  std::error_code code;
  if (!std::filesystem::is_regular_file(file, code))
    refuse_gltf(file, "no such file", "a glTF 2.0 file");
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader(ignore_image, nullptr);
  std::string error, warning;
  bool loaded = false;
  try {
    loaded = std::filesystem::path(file).extension() == ".glb"
                 ? loader.LoadBinaryFromFile(&source.model, &error, &warning, file)
                 : loader.LoadASCIIFromFile(&source.model, &error, &warning, file);
  } catch (const std::exception& exception) {
    error = exception.what();
  }
  if (!loaded) refuse_gltf(file, "not readable: " + error, "a glTF 2.0 file");
  if (source.model.asset.version.rfind("2.", 0) != 0)
    refuse_gltf(file, fmt::format("asset.version = \"{}\"", source.model.asset.version), "\"2.0\"");
  for (const std::string& extension : source.model.extensionsRequired)
    if (extension != gltf_emissive_strength)
      refuse_gltf(file, "requires extension " + extension,
                  std::string("at most ") + gltf_emissive_strength);
  return source;
}

std::vector<Eigen::Vector3d> read_gltf_vectors(const GltfSource& source, int accessor_index,
                                               const char* name) {
  const auto& accessor = gltf_element(source, source.model.accessors, accessor_index, "accessor");
  if (accessor.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT ||
      accessor.type != TINYGLTF_TYPE_VEC3)
    refuse_gltf(source.file,
                fmt::format("{} in accessor {} is no VEC3 of floats", name, accessor_index),
                "VEC3 of component type 5126");
  const View view = view_of(source, accessor_index, 3 * sizeof(float));
  std::vector<Eigen::Vector3d> vectors(view.count);
  for (std::size_t i = 0; i < view.count; ++i) {
    Eigen::Vector3f vector;
    std::memcpy(vector.data(), view.bytes + i * view.stride, 3 * sizeof(float));
    vectors[i] = vector.cast<double>();
    if (!(vectors[i].cwiseAbs().maxCoeff() <= farthest_m) || !vector.allFinite())
      refuse_gltf(source.file,
                  fmt::format("{} {} of accessor {} is ({}, {}, {})", name, i, accessor_index,
                              vector.x(), vector.y(), vector.z()),
                  fmt::format("finite values within +-{}", farthest_m));
  }
  return vectors;
}

std::vector<std::uint32_t> read_gltf_indices(const GltfSource& source, int accessor_index,
                                             std::size_t positions) {
  std::vector<std::uint32_t> indices;
  if (accessor_index < 0) {
    for (std::size_t i = 0; i < positions; ++i) indices.push_back(static_cast<std::uint32_t>(i));
  } else {
    const auto& accessor = gltf_element(source, source.model.accessors, accessor_index, "accessor");
    const int type = accessor.componentType;
    if (accessor.type != TINYGLTF_TYPE_SCALAR)
      refuse_gltf(source.file, fmt::format("indices in accessor {} are no scalars", accessor_index),
                  "SCALAR");
    if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE)
      indices = widen<std::uint8_t>(view_of(source, accessor_index, 1));
    else if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT)
      indices = widen<std::uint16_t>(view_of(source, accessor_index, 2));
    else if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
      indices = widen<std::uint32_t>(view_of(source, accessor_index, 4));
    else
      refuse_gltf(source.file, fmt::format("indices of component type {}", type),
                  "5121, 5123 or 5125");
  }
  for (const std::uint32_t index : indices)
    if (index >= positions)
      refuse_gltf(source.file, fmt::format("index {} in accessor {}", index, accessor_index),
                  fmt::format("0 .. {}, the positions there are", positions - 1));
  if (indices.size() % 3 != 0)
    refuse_gltf(source.file, fmt::format("{} indices of triangles", indices.size()),
                "a multiple of 3");
  return indices;
}

}  // namespace pluvia
