// A glTF 2.0 file and its accessors, checked: nothing read through these functions lies outside the
// file's buffers. The first step of raytrace/gltf_mesh.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <tiny_gltf.h>
#include <Eigen/Core>

namespace pluvia {

inline constexpr const char* gltf_emissive_strength = "KHR_materials_emissive_strength";

struct GltfSource {  // the file while it is read: whatever goes wrong is told with its name
  std::string file;
  tinygltf::Model model;
};

// Throws std::runtime_error "FILE: WHAT; expected EXPECTED" on one line.
[[noreturn]] void refuse_gltf(const std::string& file, std::string what,
                              const std::string& expected);

// .glb is read as binary, any other name as text. Pictures are not loaded.
GltfSource load_gltf(const std::string& file);

// list[index]; kind names the list in the message.
template <typename T>
const T& gltf_element(const GltfSource& source, const std::vector<T>& list, int index,
                      const char* kind) {
  if (index < 0 || static_cast<std::size_t>(index) >= list.size())
    refuse_gltf(source.file, fmt::format("{} {}", kind, index),
                list.empty() ? fmt::format("none: the file has no {}", kind)
                             : fmt::format("0 .. {}", list.size() - 1));
  return list[static_cast<std::size_t>(index)];
}

// A VEC3 of floats, each finite and within +-1e6; name tells what it holds.
std::vector<Eigen::Vector3d> read_gltf_vectors(const GltfSource& source, int accessor_index,
                                               const char* name);

// Three per triangle, each < positions. Without an accessor (-1): 0, 1, 2 ..
std::vector<std::uint32_t> read_gltf_indices(const GltfSource& source, int accessor_index,
                                             std::size_t positions);

}  // namespace pluvia
