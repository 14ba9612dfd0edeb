// The surfaces of a glTF 2.0 file, through tinygltf: every triangle of the default scene's meshes
// in the world (z up: x = X, y = -Z, z = Y), with node transforms applied. Read are POSITION,
// NORMAL (absent: flat, as glTF asks for), indices, baseColorFactor, and emissiveFactor times
// KHR_materials_emissive_strength in cd/m^2. Textures, cameras and lights of the file are not read.
#pragma once

#include <string>

#include "raytrace/scene.h"

namespace pluvia {

// A triangle without area is left out: no ray meets it. Throws std::runtime_error
// "FILE: what was found; what is expected" for a file that is missing or malformed, an index or a
// view out of range, a position or normal that is not finite, a transform that cannot be inverted,
// a node reached twice, a colour outside 0..1, an extension that the file requires and this reader
// lacks.
Mesh read_gltf_mesh(const std::string& file);

}  // namespace pluvia
