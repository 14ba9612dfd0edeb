#include "realtime/rain_renderer.h"

#include <chrono>
#include <ctime>
#include <optional>

#include "atlas/image_io.h"
#include "realtime/composite_pass.h"
#include "realtime/rain_pass.h"

namespace pluvia {
namespace {

// Seconds since the last call, all commands finished: timer queries of a software rasteriser err by
// orders of magnitude.
class Stopwatch {
 public:
  double lap_s() {
    glFinish();
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return seconds;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace

struct RainRenderer::State {
  GlContext context = {};  // first: the objects below need it until they are gone
  Scene scene = {};  // without its surfaces; the camera is the last frame's
  ScenePass surfaces = {};
  ShadowPass shadows = {};
  std::optional<RainPass> rain = {};  // nothing: a scene without drops
  GlTexture rain_sum = {};            // RGBA32F: radiance and tau
  GlFramebuffer rain_target = {};
  CompositePass composite = {};

  void use() { context.make_current(); }
  void move_camera(double time_s) { scene.camera = camera_at(scene, time_s); }
  void make_rain_target();
};

void RainRenderer::State::make_rain_target() {
  rain_sum = make_texture(GL_RGBA32F, scene.camera.width_px, scene.camera.height_px);
  rain_target = make_framebuffer({rain_sum.id()}, surfaces.depth.id());
  const float dry[4] = {0, 0, 0, 0};
  glClearNamedFramebufferfv(rain_target.id(), GL_COLOR, 0, dry);
}

RainRenderer::RainRenderer(const Scene& scene, const StreakAtlas& atlas,
                           const RenderOptions& options)
    : state_(std::make_unique<State>()) {
  State& state = *state_;
  state.scene = {.camera = scene.camera,
                 .camera_path = scene.camera_path,
                 .lights = scene.lights,
                 .environment = scene.environment,
                 .geometry_file = scene.geometry_file,
                 .mesh = {},
                 .rain = scene.rain,
                 .drops = scene.drops};
  std::optional<Image> map;
  if (!scene.environment.map_file.empty()) map = read_environment_map(scene.environment.map_file);
  state.surfaces = make_scene_pass(scene, map ? &*map : nullptr);
  state.shadows = make_shadow_pass(scene, state.surfaces);
  link_scene_pass(state.surfaces, state.shadows);
  state.make_rain_target();
  state.composite = make_composite_pass(scene.camera.width_px, scene.camera.height_px);
  if (!scene.rain.sizes.empty() || !scene.drops.empty())
    state.rain = make_rain_pass(scene, atlas, options,
                                mean_environment(scene.environment, map ? &*map : nullptr), state.shadows);
  state.context.check();
}

RainRenderer::~RainRenderer() {
  state_->use();
}

Frame RainRenderer::render(double time_s) {
  State& state = *state_;
  state.use();
  Frame frame;
  const std::clock_t cpu_start = std::clock();
  Stopwatch watch;
  state.move_camera(time_s);
  set_camera(state.surfaces, state.scene, state.shadows);
  draw_scene(state.surfaces, state.shadows);
  frame.timing.scene_s = watch.lap_s();
  if (state.rain) {
    frame.streaks_in_view = place_rain(*state.rain, state.scene, state.shadows, time_s);
    frame.packets = state.rain->counts;
    draw_rain(*state.rain, state.rain_target);
  }
  frame.timing.rain_s = watch.lap_s();
  draw_composite(state.composite, state.surfaces, state.rain_sum);
  frame.timing.composite_s = watch.lap_s();
  frame.timing.cpu_s = static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC;
  const int width = state.scene.camera.width_px, height = state.scene.camera.height_px;
  frame.color = read_texture(state.composite.color, width, height, 3);
  frame.background = read_texture(state.composite.background, width, height, 3);
  frame.rain = read_texture(state.rain_sum, width, height, 3);
  frame.rain_tau = read_alpha(state.rain_sum, width, height);
  frame.depth_m = read_texture(state.surfaces.depth_m, width, height, 1);
  state.context.check();
  return frame;
}

GlInfo RainRenderer::gl_info() const {
  state_->use();
  return state_->context.info();
}

std::vector<float> RainRenderer::drop_centres_m(double time_s) {
  State& state = *state_;
  state.use();
  if (!state.rain) return {};
  state.move_camera(time_s);
  std::vector<float> centres = read_centres_m(*state.rain, state.scene, state.shadows, time_s);
  for (std::size_t i = 0; i < centres.size(); ++i)
    centres[i] = static_cast<float>(static_cast<double>(centres[i]) +
                                    state.scene.camera.position_m[static_cast<Eigen::Index>(i % 3)]);
  state.context.check();
  return centres;
}

StreakRecords RainRenderer::streak_records(double time_s) {
  State& state = *state_;
  state.use();
  if (!state.rain) return {};
  state.move_camera(time_s);
  place_rain(*state.rain, state.scene, state.shadows, time_s);
  StreakRecords records = read_records(*state.rain);
  state.context.check();
  return records;
}

std::size_t RainRenderer::atlas_bytes() const {
  return state_->rain ? state_->rain->sums_bytes : 0;
}

}  // namespace pluvia
