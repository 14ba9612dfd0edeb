#include "realtime/rain_renderer.h"

#include <cassert>
#include <chrono>
#include <ctime>
#include <optional>
#include <utility>

#include "atlas/image_io.h"
#include "realtime/blur_pass.h"
#include "realtime/composite_pass.h"
#include "realtime/darkening_pass.h"
#include "realtime/fog_pass.h"
#include "realtime/moving_sky.h"
#include "realtime/moving_surfaces.h"
#include "realtime/rain_inputs.h"
#include "realtime/rain_pass.h"
#include "realtime/splash_pass.h"
#include "realtime/wind_pass.h"

namespace pluvia {
namespace {

// Costs of passes, all commands finished: timer queries of a software rasteriser err by orders of
// magnitude.
class Stopwatch {
 public:
  void lap(const std::string& pass, const std::string& skipped, std::vector<PassCost>& costs) {
    glFinish();
    const auto now = std::chrono::steady_clock::now();
    const std::clock_t cpu = std::clock();
    costs.push_back({pass, std::chrono::duration<double>(now - last_).count(),
                     static_cast<double>(cpu - last_cpu_) / CLOCKS_PER_SEC, skipped});
    last_ = now;
    last_cpu_ = cpu;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
  std::clock_t last_cpu_ = std::clock();
};

[[maybe_unused]] bool fits(const Image& image, const Camera& camera, int channels) {
  return image.width == camera.width_px && image.height == camera.height_px &&
         image.channels == channels;
}

}  // namespace

struct RainRenderer::State {
  std::shared_ptr<GlContext> context = {};  // first: the objects below need it until they are gone
  Scene scene = {};  // the camera is the last frame's; without its surfaces, if they stand still
  ScenePass surfaces = {};
  std::optional<PicturePass> picture = {};  // nothing: the scene's surfaces are drawn
  ShadowPass shadows = {};
  MovingSky sky = {};
  RainSpace space = {};
  std::optional<WindPass> wind = {};        // nothing: a scene whose rain has the closed form
  std::optional<RainPass> rain = {};        // nothing: a scene without drops
  std::optional<SplashPass> splashes = {};  // nothing: a scene without [splashes] or without drops
  std::optional<FogPass> fog = {};          // nothing: a scene without [fog]
  std::optional<DarkeningPass> darkening = {};
  std::optional<BlurPass> blur = {};
  CompositePass composite = {};
  GlFramebuffer over_scene = {};  // of billboards: the picture, before the scene's depth

  bool billboards() const { return rain && !rain->billboards.empty(); }
  // What the composite puts over the scene.
  const RainPass* streaks() const { return rain && !billboards() ? &*rain : nullptr; }

  bool captures() const { return rain && rain->refraction; }

  void use() { context->make_current(); }
  // Why no surface was moved; empty: one was.
  std::string move(double time_s) {
    scene.camera = camera_at(scene, time_s);
    if (scene.moving.empty()) return "nothing moves";
    return move_surfaces(scene, space, time_s, surfaces, shadows, rain ? &*rain : nullptr,
                         splashes ? &*splashes : nullptr);
  }
  // Why the sky was not changed; empty: it was.
  std::string move_sky(double time_s) {
    return pluvia::move_sky(sky, scene.environment, time_s, surfaces, rain ? &*rain : nullptr,
                            fog ? &*fog : nullptr);
  }
  // What changes the scene as a whole, in the order of the light: as it leaves the surfaces, in the
  // air, in the eye.
  void draw_whole_image(Stopwatch& watch, std::vector<PassCost>& costs) {
    if (darkening) watch.lap("darkening", draw_darkening(*darkening, surfaces), costs);
    if (fog) watch.lap("fog", draw_fog(*fog, scene, surfaces, shadows), costs);
    if (blur) watch.lap("blur", draw_blur(*blur, surfaces), costs);
  }
  void draw_background() {
    if (picture) {
      if (captures()) set_camera(surfaces, scene, shadows);
      draw_picture(*picture, surfaces);
    } else {
      set_camera(surfaces, scene, shadows);
      draw_scene(surfaces, shadows);
    }
  }
};

std::unique_ptr<RainRenderer::State> RainRenderer::make_state(std::shared_ptr<GlContext> context,
                                                              const Scene& scene,
                                                              const StreakAtlas& atlas,
                                                              const RenderOptions& options,
                                                              const State* kept) {
  auto made = std::make_unique<State>();
  State& state = *made;
  state.context = std::move(context);
  state.use();
  state.scene = {.camera = scene.camera,
                 .camera_path = scene.camera_path,
                 .lights = scene.lights,
                 .environment = scene.environment,
                 .geometry_file = scene.geometry_file,
                 .mesh = scene.moving.empty() ? Mesh() : scene.mesh,
                 .moving = scene.moving,
                 .rain = scene.rain,
                 .drops = scene.drops,
                 .fog = scene.fog,
                 .glow = scene.glow,
                 .splashes = scene.splashes,
                 .darkening = scene.darkening,
                 .blur = scene.blur};
  const int degree = sky_degree(atlas, options);
  const bool same_sky = kept && kept->scene.environment.map_file == scene.environment.map_file;
  state.sky = make_moving_sky(scene.environment, degree, same_sky ? kept->sky : MovingSky());
  const std::optional<Image> map =
      state.sky.clip ? state.sky.clip->at(state.sky.shown) : posed_map(scene.environment);
  // Beside a picture drops that refract see the scene's own surfaces and sky.
  const bool refracts = options.look == StreakLook::refraction;
  const bool draws_scene = !options.over_picture || refracts;
  state.surfaces =
      draws_scene ? make_scene_pass(scene, map ? &*map : nullptr) : make_scene_targets(scene);
  state.shadows = make_shadow_pass(scene, state.surfaces);
  if (options.over_picture) state.picture = make_picture_pass(state.surfaces, refracts);
  if (draws_scene) link_scene_pass(state.surfaces, state.shadows);
  state.space = make_rain_space(scene);
  const glm::vec4 environment = mean_environment(scene.environment, map ? &*map : nullptr);
  if (needs_motion(scene.rain)) state.wind = make_wind_pass(scene);
  if (!scene.rain.sizes.empty() || !scene.drops.empty())
    state.rain = make_rain_pass(scene, state.space, atlas, options,
                                sky_light(scene.environment, map ? &*map : nullptr, degree),
                                state.surfaces, state.shadows, state.wind ? &*state.wind : nullptr,
                                kept && kept->rain ? atlas_of(*kept->rain) : GpuAtlas());
  if (scene.splashes && state.streaks())
    state.splashes = make_splash_pass(scene, state.space, *state.rain, state.shadows);
  if (scene.fog)
    state.fog = make_fog_pass(scene, state.space, state.surfaces, state.shadows, environment);
  if (scene.darkening) state.darkening = make_darkening_pass(*scene.darkening);
  if (scene.blur) state.blur = make_blur_pass(*scene.blur, state.surfaces);
  state.composite =
      make_composite_pass(scene.camera.width_px, scene.camera.height_px, state.streaks(),
                          state.billboards() ? GL_RGBA16F : GL_RGBA32F);
  if (state.billboards())
    state.over_scene = make_framebuffer({state.composite.color.id()}, state.surfaces.depth.id());
  state.context->check();
  return made;
}

RainRenderer::RainRenderer(const Scene& scene, const StreakAtlas& atlas,
                           const RenderOptions& options)
    : RainRenderer(std::make_shared<GlContext>(), scene, atlas, options) {}

RainRenderer::RainRenderer(std::shared_ptr<GlContext> context, const Scene& scene,
                           const StreakAtlas& atlas, const RenderOptions& options)
    : state_(make_state(std::move(context), scene, atlas, options, nullptr)) {}

RainRenderer::~RainRenderer() {
  state_->use();
}

void RainRenderer::remake(const Scene& scene, const StreakAtlas& atlas,
                          const RenderOptions& options) {
  state_ = make_state(state_->context, scene, atlas, options, state_.get());
}

void RainRenderer::show(const Picture& picture) {
  assert(state_->picture);
  assert(fits(picture.color, state_->scene.camera, 3));
  assert(fits(picture.depth_m, state_->scene.camera, 1));
  state_->use();
  set_picture(*state_->picture, picture);
}

void RainRenderer::look_through(const Camera& camera) {
  state_->scene.camera = camera;
  state_->scene.camera_path.clear();
}

void RainRenderer::set_lights(const std::vector<Light>& lights) {
  state_->scene.lights = lights;
}

void RainRenderer::set_wind(const std::vector<WindPrimitive>& primitives) {
  if (state_->wind) change_wind(*state_->wind, primitives);
}

std::vector<Drop> RainRenderer::drops(int oscillation_count, double time_s) const {
  const State& state = *state_;
  if (!state.wind) return drop_field(state.scene, state.space, oscillation_count, time_s);
  state_->use();
  DropMotion motion = state.wind->motion;
  motion.drops = read_moving_drops(*state.wind);
  return drop_field(state.scene, state.space, oscillation_count, motion, time_s);
}

const RainSpace& RainRenderer::rain_space() const {
  return state_->space;
}

const RainPackets* RainRenderer::rain_packets() const {
  return state_->rain ? &state_->rain->packets : nullptr;
}

const GlTexture& RainRenderer::picture() const {
  return state_->composite.color;
}

Frame RainRenderer::render(double time_s) {
  Frame frame = draw(time_s);
  read(frame);
  return frame;
}

Frame RainRenderer::draw(double time_s) {
  State& state = *state_;
  state.use();
  Frame frame;
  Stopwatch watch;
  const std::string stood = state.move(time_s);
  if (!state.scene.moving.empty()) watch.lap("moving surfaces", stood, frame.costs);
  if (state.sky.clip) watch.lap("sky", state.move_sky(time_s), frame.costs);
  if (state.wind) watch.lap("wind", step_wind(*state.wind, time_s), frame.costs);
  state.draw_background();
  watch.lap(state.picture ? "picture" : "surfaces", "", frame.costs);
  state.draw_whole_image(watch, frame.costs);
  if (state.captures()) {
    draw_capture(state.rain->refraction->capture, state.surfaces, state.shadows,
                 state.picture ? &*state.picture : nullptr);
    watch.lap("surroundings", "", frame.costs);
  }
  if (state.rain) {
    frame.streaks_in_view = place_rain(*state.rain, state.scene, state.shadows, time_s);
    frame.packets = state.rain->counts;
    if (state.streaks()) draw_rain(*state.rain);
    watch.lap("rain", frame.streaks_in_view == 0 ? "no streak in view" : "", frame.costs);
  }
  if (state.splashes) {
    place_splashes(*state.splashes, state.scene, *state.rain, state.shadows, time_s);
    const std::string skipped = draw_splashes(*state.splashes, *state.rain);
    frame.splash_strokes = static_cast<long>(state.splashes->strokes_in_view);
    watch.lap("splashes", skipped, frame.costs);
  }
  draw_composite(state.composite, state.surfaces, state.streaks());
  watch.lap("composite", "", frame.costs);
  if (state.billboards()) {
    draw_billboards(*state.rain, state.over_scene);
    watch.lap("billboards", "", frame.costs);
  }
  state.context->check();
  return frame;
}

void RainRenderer::read(Frame& frame) {
  State& state = *state_;
  state.use();
  const int width = state.scene.camera.width_px, height = state.scene.camera.height_px;
  frame.color = read_texture(state.composite.color, width, height, 3);
  frame.background = read_texture(state.composite.background, width, height, 3);
  frame.rain = state.streaks() ? read_texture(state.rain->seen, width, height, 3)
                               : make_image(width, height, 3);
  frame.rain_tau =
      state.streaks() ? read_alpha(state.rain->seen, width, height) : make_image(width, height, 1);
  frame.depth_m = read_texture(state.surfaces.depth_m, width, height, 1);
  state.context->check();
}

FramePlan RainRenderer::plan() {
  State& state = *state_;
  state.use();
  FramePlan plan;
  if (!state.shadows.empty()) plan.passes.push_back(plan_of(state.shadows));
  if (state.sky.clip) plan.passes.push_back(plan_of(state.sky, state.scene.environment));
  plan.passes.push_back(state.picture ? plan_of(*state.picture, state.surfaces)
                                      : plan_of(state.surfaces));
  if (state.darkening) plan.passes.push_back(plan_of(*state.darkening));
  if (state.fog) plan.passes.push_back(plan_of(*state.fog));
  if (state.blur) plan.passes.push_back(plan_of(*state.blur));
  if (state.wind) plan.passes.push_back(plan_of(*state.wind));
  if (state.captures()) plan.passes.push_back(plan_of(state.rain->refraction->capture));
  if (state.rain) plan.passes.push_back(plan_of(*state.rain));
  if (state.splashes) plan.passes.push_back(plan_of(*state.splashes));
  plan.passes.push_back(plan_of(state.composite));
  return plan;
}

GlInfo RainRenderer::gl_info() const {
  state_->use();
  return state_->context->info();
}

std::vector<float> RainRenderer::drop_centres_m(double time_s) {
  State& state = *state_;
  state.use();
  if (!state.rain) return {};
  state.move(time_s);
  if (state.wind) step_wind(*state.wind, time_s);
  std::vector<float> centres = read_centres_m(*state.rain, state.scene, state.shadows, time_s);
  for (std::size_t i = 0; i < centres.size(); ++i)
    centres[i] =
        static_cast<float>(static_cast<double>(centres[i]) +
                           state.scene.camera.position_m[static_cast<Eigen::Index>(i % 3)]);
  state.context->check();
  return centres;
}

StreakRecords RainRenderer::streak_records(double time_s) {
  State& state = *state_;
  state.use();
  if (!state.rain) return {};
  state.move(time_s);
  if (state.wind) step_wind(*state.wind, time_s);
  place_rain(*state.rain, state.scene, state.shadows, time_s);
  StreakRecords records = read_records(*state.rain);
  state.context->check();
  return records;
}

std::vector<StrokeRecord> RainRenderer::splash_strokes(double time_s) {
  State& state = *state_;
  state.use();
  if (!state.splashes) return {};
  state.move(time_s);
  if (state.wind) step_wind(*state.wind, time_s);
  place_rain(*state.rain, state.scene, state.shadows, time_s);
  place_splashes(*state.splashes, state.scene, *state.rain, state.shadows, time_s);
  std::vector<StrokeRecord> strokes = read_strokes(*state.splashes);
  state.context->check();
  return strokes;
}

std::size_t RainRenderer::atlas_bytes() const {
  return state_->rain ? state_->rain->atlas->bytes : 0;
}

}  // namespace pluvia
