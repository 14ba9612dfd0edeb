// A camera path recorded by flying it, as [[camera.key]] tables that read_scene reads back to the
// bit.
#pragma once

#include <string>
#include <vector>

#include "raytrace/scene.h"

namespace pluvia {

// Adds a key for the camera at a time of the rain, unless the last key is less than every_s before
// it. every_s >= least_key_s.
void record_key(std::vector<CameraKey>& path, const Camera& camera, double time_s, double every_s);

// [camera] with everything but places, then its keys, and [depth_of_field] where the camera has it:
// what replaces [camera] and [depth_of_field] in a scene file; a focus at infinity is 1,000 km.
// Times are those of the rain: a frame rendered at a key's time shows what was seen. Throws
// std::runtime_error for fewer than two keys.
std::string camera_path_toml(const Camera& camera, const std::vector<CameraKey>& path);

}  // namespace pluvia
