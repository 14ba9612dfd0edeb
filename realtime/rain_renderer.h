// Rain in a scene, rendered with OpenGL 4.5 core without a window (EGL, surfaceless).
//
// A frame is: the scene (colour and depth), then rain over it,
//   C = (1 - coverage) B + sum_lights E_l S_l + L_env S_env
// with S and coverage looked up in the atlas by view and light angles of each drop (atlas_lookup.h).
// All pictures are linear Rec.709 radiance in cd/m^2, row 0 at the top.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "atlas/image.h"
#include "atlas/streak_atlas.h"
#include "raytrace/scene.h"

namespace pluvia {

struct FrameTiming {             // steady clock around glFinish; process CPU time beside it
  double scene_s = 0;
  double rain_s = 0;
  double composite_s = 0;
  double cpu_s = 0;
};

struct Frame {
  Image color = {};              // RGB, with rain
  Image background = {};         // RGB, the same frame without rain
  Image rain = {};               // RGB: sum of E S, before it is put over the background
  Image rain_tau = {};           // 1 channel: sum of -log(1 - coverage)
  Image depth_m = {};            // 1 channel: distance along the view axis; +inf where there is no surface
  FrameTiming timing = {};
  long drops_in_view = 0;
};

// What the machine's OpenGL is: for reports.
struct GlInfo { std::string vendor, renderer, version; };

class RainRenderer {
 public:
  // Uploads the scene and the atlas. Throws std::runtime_error when there is no EGL or no OpenGL 4.5,
  // when a shader does not compile, when the scene's exposure, fall speed or drop radius is not the
  // atlas's ("SCENE: camera.exposure_s = 0.01; the atlas in DIR holds 0.0166667").
  RainRenderer(const Scene& scene, const StreakAtlas& atlas);
  ~RainRenderer();
  RainRenderer(const RainRenderer&) = delete;
  RainRenderer& operator=(const RainRenderer&) = delete;

  Frame render(double time_s);   // shutter opens at time_s
  GlInfo gl_info() const;

  // Centres of all drops at time_s as the GPU's closed form computes them (x, y, z per drop, in order of
  // id): for the test against raytrace/drop_field.h.
  std::vector<float> drop_centres_m(double time_s);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace pluvia
