#include "realtime/viewer/camera_recording.h"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

#include "raytrace/depth_of_field.h"

namespace pluvia {
namespace {

std::string toml(const Eigen::Vector3d& v) {
  return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z());  // the shortest that reads back exactly
}

}  // namespace

void record_key(std::vector<CameraKey>& path, const Camera& camera, double time_s, double every_s) {
  if (!path.empty() && time_s < path.back().time_s + every_s) return;
  CameraKey key = {time_s, camera.position_m, camera.target_m};
  if (camera.depth_of_field) key.focus_m = camera.depth_of_field->focus_m;
  path.push_back(key);
}

std::string camera_path_toml(const Camera& camera, const std::vector<CameraKey>& path) {
  if (path.size() < 2)
    throw std::runtime_error(fmt::format("camera path: {} key{}; expected 2 or more", path.size(),
                                         path.size() == 1 ? "" : "s"));
  std::string text = fmt::format(
      "[camera]\nvertical_fov_deg = {}\nwidth_px = {}\nheight_px = {}\nexposure_s = {}\n"
      "white_cd_m2 = {}\n",
      camera.vertical_fov_deg, camera.width_px, camera.height_px, camera.exposure_s,
      camera.white_cd_m2);
  for (const CameraKey& key : path) {
    text += fmt::format("\n[[camera.key]]\ntime_s = {}\nposition_m = {}\ntarget_m = {}\n",
                        key.time_s, toml(key.position_m), toml(key.target_m));
    // TOML readers refuse infinity here; as far as a scene file may say is as good.
    if (camera.depth_of_field)
      text += fmt::format("focus_m = {}\n", std::min(key.focus_m, farthest_focus_m));
  }
  if (const auto& lens = camera.depth_of_field)
    text += fmt::format("\n[depth_of_field]\naperture_m = {}\n", lens->aperture_m);
  return text;
}

}  // namespace pluvia
