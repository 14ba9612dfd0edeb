#include "realtime/wind_pass.h"

#include <algorithm>

#include <fmt/format.h>

#include "oscillation/fall_speed.h"
#include "realtime/group_passes.h"
#include "realtime/rain_inputs.h"
#include "realtime/to_glm.h"

namespace pluvia {
namespace {

enum Binding : GLuint { uniforms_at, drops_at, sizes_at, grid_at, top_heights_at };

// In one dispatch: llvmpipe ends a shader without a word after 65,535 rounds of its loops.
constexpr long most_steps = 32;

ShaderDefines defines() {
  return {{"GROUP_SIZE", std::to_string(group_size)},
          {"DROPS_OF_GROUP", std::to_string(drops_of_group)},
          {"GROUPS_PER_ROW", std::to_string(groups_per_row)},
          {"WIND_UNIFORMS", std::to_string(uniforms_at)},
          {"MOVING_DROPS", std::to_string(drops_at)},
          {"MOVING_SIZES", std::to_string(sizes_at)},
          {"WIND", std::to_string(grid_at)},
          {"TOP_HEIGHTS", std::to_string(top_heights_at)},
          {"STEP_S", fmt::format("{:.9g}", motion_step_s)},
          {"GRAVITY_M_S2", fmt::format("{:.9g}", gravity_m_s2)},
          {"BACK_OFF_M", std::to_string(back_off_m)},
          {"LEAST_BOUNCE_M_S", std::to_string(least_bounce_m_s)}};
}

std::vector<GpuMovingDrop> gpu_drops(const DropMotion& motion) {
  std::vector<GpuMovingDrop> drops;
  drops.reserve(motion.drops.size());
  for (const MovingDrop& drop : motion.drops) {
    GpuMovingDrop gpu = {.position_m = to_glm(drop.position_m, drop.since_hit_s),
                         .fall = drop.fall};
    for (int i = 0; i < 3; ++i) gpu.velocity_m_s[i] = static_cast<float>(drop.velocity_m_s[i]);
    drops.push_back(gpu);
  }
  return drops;
}

std::vector<GpuMovingSize> gpu_sizes(const DropMotion& motion) {
  std::vector<GpuMovingSize> sizes;
  for (const MovingSize& size : motion.sizes)
    sizes.push_back({to_glm(size.fall_m_s, size.fall_m_s.norm()),
                     {size.stream[0], size.stream[1], static_cast<std::uint32_t>(size.first),
                      static_cast<std::uint32_t>(size.count)}});
  return sizes;
}

std::vector<glm::vec4> gpu_wind(const WindGrid& grid) {
  std::vector<glm::vec4> wind;
  wind.reserve(grid.wind_m_s.size());
  for (const Eigen::Vector3d& at : grid.wind_m_s) wind.push_back(to_glm(at, 0));
  return wind;
}

WindUniforms uniforms_of(const MotionSurroundings& around) {
  const TopHeight& top = around.top;
  return {.size_m = to_glm(around.size_m, around.restitution),
          .node_step_m = to_glm(around.grid.step_m, around.grid.nodes),
          .top_grid =
              to_glm({top.min_x_m - around.low_m.x(), top.min_y_m - around.low_m.y(), top.texel_m},
                     top.lowest_m - around.low_m.z()),
          .top_layout = {top.width, top.height, 0, 0}};
}

void upload_surroundings(const WindPass& pass) {
  const MotionSurroundings& around = pass.motion.around;
  update_buffer(pass.wind, gpu_wind(around.grid));
  if (!pass.scene.moving.empty())
    update_buffer(pass.top_heights, gpu_top_rows(around.top, 0, around.top.height));
}

// The drops at time 0, on the GPU alone.
void restart(WindPass& pass) {
  start_drops(pass.motion, pass.scene);
  upload_surroundings(pass);
  update_buffer(pass.drops, gpu_drops(pass.motion));
  pass.motion.drops.clear();
}

void take_steps(const WindPass& pass, long steps) {
  glBindBufferBase(GL_UNIFORM_BUFFER, uniforms_at, pass.uniforms.id());
  bind_storage(drops_at, pass.drops);
  bind_storage(sizes_at, pass.sizes);
  bind_storage(grid_at, pass.wind);
  bind_storage(top_heights_at, pass.top_heights);
  glProgramUniform1ui(pass.step.id(), 1, static_cast<GLuint>(steps));
  for (std::size_t i = 0; i < pass.motion.sizes.size(); ++i) {
    const std::size_t groups = (pass.motion.sizes[i].count + group_size - 1) / group_size;
    if (groups == 0) continue;
    glProgramUniform1ui(pass.step.id(), 0, static_cast<GLuint>(i));
    dispatch_groups(pass.step, groups);
  }
}

}  // namespace

WindPass make_wind_pass(const Scene& scene) {
  WindPass pass;
  pass.scene.moving = scene.moving;
  if (!scene.moving.empty()) pass.scene.mesh = scene.mesh;
  pass.motion = make_drop_motion(scene);
  const std::vector<GpuMovingDrop> drops = gpu_drops(pass.motion);
  pass.drops = make_storage(fmt::format("rain: {} drops, moved by wind,", drops.size()),
                            drops.size() * sizeof(GpuMovingDrop));
  update_buffer(pass.drops, drops);
  pass.motion.drops = {};
  const MotionSurroundings& around = pass.motion.around;
  pass.sizes = make_buffer(gpu_sizes(pass.motion));
  pass.wind = make_buffer(gpu_wind(around.grid));
  pass.top_heights = make_buffer(gpu_top_rows(around.top, 0, around.top.height));
  const WindUniforms uniforms = uniforms_of(around);
  pass.uniforms = make_buffer(&uniforms, sizeof(uniforms));
  pass.step = build_program({"wind_step.comp"}, defines());
  return pass;
}

std::string step_wind(WindPass& pass, double time_s) {
  DropMotion& motion = pass.motion;
  const long wanted = steps_until(time_s);
  if (wanted == motion.steps) return "no step since the last frame";
  if (wanted < motion.steps) restart(pass);
  const bool staged = has_stages(motion, pass.scene);
  while (motion.steps < wanted) {
    if (prepare_stage(motion, pass.scene, motion.steps)) upload_surroundings(pass);
    const long stage_end = (motion.steps / motion_stage_steps + 1) * motion_stage_steps;
    const long end = std::min(wanted, staged ? stage_end : motion.steps + most_steps);
    take_steps(pass, end - motion.steps);
    motion.steps = end;
  }
  return "";
}

void change_wind(WindPass& pass, const std::vector<WindPrimitive>& primitives) {
  if (primitives == pass.motion.wind.primitives) return;
  pass.motion.wind.primitives = primitives;
  pass.motion.stage = -1;
}

double late_s(const WindPass& pass, double time_s) {
  return time_s - static_cast<double>(pass.motion.steps) * motion_step_s;
}

PlannedPass plan_of(const WindPass& pass) {
  PlannedPass plan = {.name = "wind"};
  plan.add(pass.step);
  plan.add("drops", pass.drops);
  plan.add("sizes", pass.sizes);
  plan.add("wind", pass.wind);
  plan.add("top heights", pass.top_heights);
  plan.add("uniforms", pass.uniforms);
  return plan;
}

std::vector<MovingDrop> read_moving_drops(const WindPass& pass) {
  std::size_t count = 0;
  for (const MovingSize& size : pass.motion.sizes) count += size.count;
  std::vector<GpuMovingDrop> drops(count);
  glGetNamedBufferSubData(pass.drops.id(), 0,
                          static_cast<GLsizeiptr>(count * sizeof(GpuMovingDrop)), drops.data());
  std::vector<MovingDrop> moved;
  for (const GpuMovingDrop& drop : drops)
    moved.push_back(
        {.position_m = {drop.position_m.x, drop.position_m.y, drop.position_m.z},
         .since_hit_s = drop.position_m.w,
         .velocity_m_s = {drop.velocity_m_s[0], drop.velocity_m_s[1], drop.velocity_m_s[2]},
         .fall = drop.fall});
  return moved;
}

}  // namespace pluvia
