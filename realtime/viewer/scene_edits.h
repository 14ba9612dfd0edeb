// What a viewer changes about a scene, and what of it needs the renderer to be made anew.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "raytrace/scene.h"
#include "realtime/rain_renderer.h"

namespace pluvia {

struct SceneEdits {
  // Without making anew:
  double white_cd_m2 = 1;  // the radiance shown as white; not far below what it was
  std::vector<Light> lights =
      {};              // in the scene's order; moved or brighter, unless they cast shadows
  double focus_m = 3;  // with depth of field
  std::vector<WindPrimitive> wind = {};  // of a scene that has some: drops go on in the new wind
  // Made anew for:
  double rate_mm_h = 0;                  // through a level plane
  Eigen::Vector3d wind_m_s = {0, 0, 0};  // carries every drop of the rain along
  double exposure_s = 1.0 / 60;
  double vertical_fov_deg = 40;
  bool rain = true;     // the scene's drops, single ones too
  bool shadows = true;  // those of the scene's lights that have one
  bool fog = false;
  bool glow = false;      // only with fog
  Fog air = {};           // where fog is on
  bool splashes = false;  // only with rain
  bool depth_of_field = false;
  double aperture_m = 0.02;  // with it
  RenderOptions options = {};
  int pixel_px = 1;  // of the window, along a side of the picture's pixel
};

// Water that falls through a level plane, mm/h: sum of n (4/3) pi r0^3 (-v_z) 3.6e6.
double rate_mm_h(const Rain& rain);

// The scene as it is.
SceneEdits edits_of(const Scene& scene, const RenderOptions& options);

// The scene edited. Rate: every size has more drops or fewer, the shares of the sizes stay (of a
// scene without rain: no rain). Wind: instead of the scene's. With edits_of(scene) the scene
// itself. Throws std::runtime_error for drops that would not fall, as read_scene does.
Scene edited_scene(const Scene& scene, const SceneEdits& edits);

// Its lights alone, and its lens: nothing for a pinhole.
std::vector<Light> edited_lights(const SceneEdits& edits);
std::optional<DepthOfField> edited_lens(const SceneEdits& edits);

// Which edit needs the renderer to be made anew: its name; empty for none. White does where it
// falls below an eighth: light is added up in quanta of the white that a renderer was made for
// (realtime/rain_splat.h), and an eighth leaves 8192 of them below the new one.
std::string needs_remake(const SceneEdits& made, const SceneEdits& now);

// A path that looks around from a camera, level, up and down: a renderer made for it shows the rain
// whichever way the camera is then turned.
std::vector<CameraKey> look_around(const Camera& camera);

}  // namespace pluvia
