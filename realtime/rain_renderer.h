// Rain in a scene, rendered with OpenGL 4.5 core, without a window (EGL, surfaceless) or for one.
//
// A frame is: the scene (colour and depth), then rain over it,
//   C = (1 - coverage) B + sum_lights E_l S_l + sum_sky c_k S_k
// (the sky: its mean times the picture under uniform light, or its spherical harmonics, one for
// one, raytrace/sky_light.h) with S and coverage looked up in the atlas by view and light angles of
// each drop (atlas_lookup.h), streaks seen past each other (realtime/shaders/composite.frag). All
// pictures are linear Rec.709 radiance in cd/m^2, row 0 at the top.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "atlas/atlas_lookup.h"
#include "atlas/image.h"
#include "atlas/streak_atlas.h"
#include "raytrace/drop_field.h"
#include "raytrace/rain_packets.h"
#include "raytrace/rain_space.h"
#include "raytrace/scene.h"
#include "realtime/frame_plan.h"
#include "realtime/gl_context.h"
#include "realtime/gpu_atlas.h"
#include "realtime/picture_pass.h"
#include "realtime/streak_record.h"
#include "realtime/stroke_record.h"

namespace pluvia {

// How streaks are drawn: as this renderer does, or as Creus did (realtime/billboard_pass.h), to
// measure against.
enum class RainPath { streaks, billboards_2010 };

// How light gets into a streak (realtime/rain_look.h): as traced; as into a sphere; the same as
// Wang et al. published it in 2006; each streak as bright as another; or refracted by masks
// (realtime/refraction_look.h).
enum class StreakLook { traced, sphere, sphere_published, white, refraction };

// What of the scene drops that refract see: all around the camera, or as published 165 degrees
// before it (realtime/capture_pass.h).
enum class SceneCapture { cube, wide };

struct RenderOptions {
  RainPath path = RainPath::streaks;  // billboards heed `packets` and `lookup` alone
  // A streak's columns are merged in powers of two as long as they are at most this wide on screen
  // (at least four are left). > 0. Relative RMSE of the rain against the exact composite, drops in
  // the street of data/scenes: 0.013 at 0.25, 0.015 at 0.5; close by (close.toml): 0.002 at 0.25,
  // 0.035 at 0.5, 0.08 at 1.
  double max_texel_px = 0.25;
  // Finer levels are never read nor uploaded. Levels that no drop of the scene can need are left
  // out anyway. 0 .. the atlas's levels - 1.
  int finest_level = 0;
  // Streaks whose cell is at most this wide on screen go into the picture without quads
  // (realtime/shaders/rain_splat.comp). 0 .. 16; 0: none.
  double widest_splat_px = 1;
  // Where more streaks than this cross a pixel, fewer stand for all (realtime/far_field.h): 1 ..
  // 1e6; 0: every drop is drawn.
  double far_streaks = 0;
  PacketOptions packets = {};
  LookupMode lookup = LookupMode::view_linear;
  StreakLook look = StreakLook::traced;
  // Of spheres: the share of the background behind a streak that is added to it, 0 .. 0.99;
  // nothing: 0.7 as published for sphere_published, else 0.
  std::optional<double> background_share = {};
  // Of white streaks: their radiance, 0 .. 1e9; nothing: the camera's white.
  std::optional<double> streak_cd_m2 = {};
  // To which degree of spherical harmonics streaks see an environment map, 0 .. 8, as far as the
  // atlas has their pictures: (degree + 1)^2 cells a streak; 0: its mean from everywhere. Spheres
  // see it to degree 3 at most, whatever the atlas has.
  int sky_degree = 3;
  // The frame is put over pictures that are given (RainRenderer::show), not over the scene's
  // surfaces.
  bool over_picture = false;
  // Of streaks that refract, by the atlas's masks: samples of the drop in a pixel, 1 .. 50; the
  // scene that they see, its sides in px, 16 .. 4096.
  int persistence_samples = 10;
  SceneCapture capture = SceneCapture::cube;
  int capture_px = 256;

  bool operator==(const RenderOptions&) const = default;
};

// What the selection of packets looked at (raytrace/rain_packets.h).
struct PacketCounts {
  long packets_looked_at = 0;
  long packets_taken = 0;
  long drops_looked_at = 0;
  long drops_stood_for = 0;  // besides, by others of those looked at (realtime/far_field.h)
};

struct Frame {
  Image color = {};       // RGB, with rain
  Image background = {};  // RGB, the same frame without rain
  Image rain = {};        // RGB: what streaks and splashes add to the dimmed background; black
                          // without rain and with billboards_2010
  Image rain_tau = {};    // 1 channel: sum of -log(1 - coverage), of both
  Image depth_m = {};     // 1 channel: distance along the view axis; +inf where there is no surface
  std::vector<PassCost> costs = {};  // of each pass of the plan that a frame runs; before
                                     // them of surfaces that move, if any do
  long streaks_in_view = 0;  // a drop has one for each segment (raytrace/streak_placement.h)
  long splash_strokes = 0;   // parts of splashes in view (realtime/splash_pass.h)
  PacketCounts packets = {};
};

class RainRenderer {
 public:
  // Uploads the scene and the atlas. Throws std::runtime_error when there is no EGL or no
  // OpenGL 4.5, when a shader does not compile, when the rain asks for too many drops or packets
  // that cannot be, and for an exposure in which drops are no streaks. A scene without rain needs
  // no atlas: it may be empty.
  RainRenderer(const Scene& scene, const StreakAtlas& atlas, const RenderOptions& options = {});

  // The same in a context that others use, too: a window's.
  RainRenderer(std::shared_ptr<GlContext> context, const Scene& scene, const StreakAtlas& atlas,
               const RenderOptions& options = {});
  ~RainRenderer();
  RainRenderer(const RainRenderer&) = delete;
  RainRenderer& operator=(const RainRenderer&) = delete;

  // Shutter opens at time_s, 0 .. 1e7.
  Frame render(double time_s);

  // The two halves of render: a frame whose pictures are empty, and stay on the GPU; its pictures.
  Frame draw(double time_s);
  void read(Frame& frame);

  // What was drawn last: Frame::color, RGBA, row 0 at the top.
  const GlTexture& picture() const;

  // Becomes what the constructor makes of the scene, in the same context; of the same atlas what is
  // already on the GPU stays there. Throws as the constructor, and then stays what it was.
  void remake(const Scene& scene, const StreakAtlas& atlas, const RenderOptions& options);

  // From now on over this picture of the camera's size, before the first frame at the latest; only
  // with RenderOptions::over_picture.
  void show(const Picture& picture);

  // From now on through this camera, whatever path the scene has; of the same size in px and
  // shutter.
  void look_through(const Camera& camera);

  // The same lights elsewhere, or brighter. Shadow maps are of the places where lights were: a
  // light with a shadow that moves needs remake.
  void set_lights(const std::vector<Light>& lights);

  // Other wind primitives instead of the scene's: drops that move by steps go on from where they
  // are. For a scene that has some; nothing for another.
  void set_wind(const std::vector<WindPrimitive>& primitives);

  // The drops at the time of the last frame, as raytrace/drop_field.h has them; those that move by
  // steps as the GPU has moved them. oscillation_count >= 1.
  std::vector<Drop> drops(int oscillation_count, double time_s) const;

  // Where drops are drawn, and in which packets they are looked at; nullptr without rain.
  const RainSpace& rain_space() const;
  const RainPackets* rain_packets() const;

  GlInfo gl_info() const;

  // What it has made for the scene.
  FramePlan plan();

  // Centres of the drops in the packets taken at time_s as the GPU's closed form computes them (x,
  // y, z per drop, in order of drop_field): for the test against raytrace/drop_field.h.
  std::vector<float> drop_centres_m(double time_s);

  // What the GPU decides about every streak that is drawn as a quad: for the tests against
  // place_streak and choose_cells.
  StreakRecords streak_records(double time_s);

  // The same about every part of every splash: for the tests against raytrace/splash.h.
  std::vector<StrokeRecord> splash_strokes(double time_s);

  // Bytes of the cumulative sums on the GPU.
  std::size_t atlas_bytes() const;

 private:
  struct State;
  static std::unique_ptr<State> make_state(std::shared_ptr<GlContext> context, const Scene& scene,
                                           const StreakAtlas& atlas, const RenderOptions& options,
                                           const State* kept);

  std::unique_ptr<State> state_;
};

}  // namespace pluvia
