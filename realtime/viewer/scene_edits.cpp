#include "realtime/viewer/scene_edits.h"

#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

namespace pluvia {
namespace {

bool same_place(const Light& a, const Light& b) {
  return a.position_m == b.position_m && a.direction == b.direction;
}

bool shadows_move(const std::vector<Light>& made, const std::vector<Light>& now) {
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (now[i].shadow && !same_place(made[i], now[i])) return true;
  }
  return false;
}

void refuse_rising_drops(const Rain& rain) {
  for (const RainSize& size : rain.sizes) {
    if (size.velocity_m_s.z() < -0.01 && size.velocity_m_s.norm() <= 200) continue;
    throw std::runtime_error(fmt::format(
        "wind: drops of {:.3g} mm move at ({:.4g}, {:.4g}, {:.4g}) m/s; expected a fall "
        "of 0.01 m/s or more, at most 200 m/s in all",
        2e3 * size.r0_m, size.velocity_m_s.x(), size.velocity_m_s.y(), size.velocity_m_s.z()));
  }
}

void edit_rain(const SceneEdits& edits, Rain& rain) {
  const double rate = rate_mm_h(rain);
  if (edits.wind_m_s != rain.wind_m_s) {
    for (RainSize& size : rain.sizes) size.velocity_m_s += edits.wind_m_s - rain.wind_m_s;
    rain.wind_m_s = edits.wind_m_s;
    refuse_rising_drops(rain);
  }
  if (edits.rate_mm_h == rate) return;
  if (edits.rate_mm_h == 0) rain.sizes.clear();
  for (RainSize& size : rain.sizes) size.drops_per_m3 *= edits.rate_mm_h / rate;
  rain.undrawn_per_m *= rain.sizes.empty() ? 0 : edits.rate_mm_h / rate;
}

}  // namespace

double rate_mm_h(const Rain& rain) {
  double m_s = 0;
  for (const RainSize& size : rain.sizes)
    m_s -= size.drops_per_m3 * 4 / 3 * std::numbers::pi * size.r0_m * size.r0_m * size.r0_m *
           size.velocity_m_s.z();
  return 3.6e6 * m_s;
}

SceneEdits edits_of(const Scene& scene, const RenderOptions& options) {
  const DepthOfField lens = scene.camera.depth_of_field.value_or(
      DepthOfField{.aperture_m = SceneEdits().aperture_m, .focus_m = SceneEdits().focus_m});
  return {.white_cd_m2 = scene.camera.white_cd_m2,
          .lights = scene.lights,
          .focus_m = lens.focus_m,
          .wind = scene.rain.wind,
          .rate_mm_h = rate_mm_h(scene.rain),
          .wind_m_s = scene.rain.wind_m_s,
          .exposure_s = scene.camera.exposure_s,
          .vertical_fov_deg = scene.camera.vertical_fov_deg,
          .fog = scene.fog.has_value(),
          .glow = scene.glow.has_value(),
          .air = scene.fog.value_or(Fog()),
          .splashes = scene.splashes.has_value(),
          .depth_of_field = scene.camera.depth_of_field.has_value(),
          .aperture_m = lens.aperture_m,
          .options = options};
}

std::vector<Light> edited_lights(const SceneEdits& edits) {
  std::vector<Light> lights = edits.lights;
  for (Light& light : lights) light.shadow = light.shadow && edits.shadows;
  return lights;
}

std::optional<DepthOfField> edited_lens(const SceneEdits& edits) {
  if (!edits.depth_of_field) return {};
  return DepthOfField{.aperture_m = edits.aperture_m, .focus_m = edits.focus_m};
}

Scene edited_scene(const Scene& scene, const SceneEdits& edits) {
  Scene edited = scene;
  edited.camera.white_cd_m2 = edits.white_cd_m2;
  edited.camera.exposure_s = edits.exposure_s;
  edited.camera.vertical_fov_deg = edits.vertical_fov_deg;
  edited.camera.depth_of_field = edited_lens(edits);
  edited.lights = edited_lights(edits);
  edit_rain(edits, edited.rain);
  edited.rain.wind = edits.wind;
  if (!edits.rain) {
    edited.rain.sizes.clear();
    edited.rain.undrawn_per_m = 0;
    edited.drops.clear();
  }
  edited.fog = edits.fog ? std::optional<Fog>(edits.air) : std::nullopt;
  edited.glow = edits.fog && edits.glow ? std::optional<Glow>(Glow()) : std::nullopt;
  edited.splashes =
      edits.rain && edits.splashes ? std::optional<Splashes>(Splashes()) : std::nullopt;
  return edited;
}

std::string needs_remake(const SceneEdits& made, const SceneEdits& now) {
  if (made.rain != now.rain) return "rain";
  if (now.rain && now.white_cd_m2 < made.white_cd_m2 / 8) return "white";
  if (now.rain && made.rate_mm_h != now.rate_mm_h) return "rate";
  if (now.rain && made.wind_m_s != now.wind_m_s) return "wind";
  if (now.rain && made.splashes != now.splashes) return "splashes";
  if (made.exposure_s != now.exposure_s) return "exposure";
  if (made.depth_of_field != now.depth_of_field ||
      (now.depth_of_field && made.aperture_m != now.aperture_m))
    return "depth of field";
  if (made.vertical_fov_deg != now.vertical_fov_deg) return "field of view";
  if (made.shadows != now.shadows) return "shadows";
  if (now.shadows && shadows_move(made.lights, now.lights)) return "a light with a shadow";
  if (made.fog != now.fog) return "fog";
  if (now.fog && made.glow != now.glow) return "glow";
  if (now.fog && (made.air.extinction_per_m != now.air.extinction_per_m ||
                  made.air.asymmetry != now.air.asymmetry))
    return "mist";
  if (made.pixel_px != now.pixel_px) return "size of a pixel";
  return made.options == now.options ? "" : "quality";
}

std::vector<CameraKey> look_around(const Camera& camera) {
  const Eigen::Vector3d& eye = camera.position_m;
  std::vector<CameraKey> path = {{0, eye, camera.target_m}};
  for (const Eigen::Vector3d& way :
       {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, -1, 0),
        Eigen::Vector3d(-1, 0, 0), Eigen::Vector3d(0, 0.1, 1), Eigen::Vector3d(0, 0.1, -1)})
    path.push_back({path.back().time_s + 1, eye, eye + way});
  return path;
}

}  // namespace pluvia
