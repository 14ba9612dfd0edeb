#include "realtime/viewer/panel.h"

#include <algorithm>
#include <numbers>
#include <stdexcept>
#include <utility>

#include <epoxy/gl.h>

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <fmt/format.h>
#include <imgui.h>

#include "raytrace/depth_of_field.h"
#include "realtime/viewer/packet_overlay.h"
#include "realtime/viewer/wind_overlay.h"

namespace pluvia {
namespace {

constexpr double turn_per_px = 0.003;  // radians

bool slider(const char* label, double& value, double low, double high, const char* format,
            bool logarithmic = false) {
  return ImGui::SliderScalar(
      label, ImGuiDataType_Double, &value, &low, &high, format,
      (logarithmic ? ImGuiSliderFlags_Logarithmic : 0) | ImGuiSliderFlags_AlwaysClamp);
}

void text(const std::string& line) {
  ImGui::TextUnformatted(line.c_str());
}

template <std::size_t n>
void choice(const char* label, const char* const (&names)[n], int& chosen) {
  ImGui::Combo(label, &chosen, names, static_cast<int>(n));
}

// What an action says: the file it wrote, or why not.
template <class Action>
void tell(Viewer& viewer, Action action) {
  try {
    viewer.message = action();
  } catch (const std::runtime_error& error) {
    viewer.message = error.what();
  }
}

void rain_controls(Viewer& viewer) {
  SceneEdits& edits = viewer.edits;
  if (!ImGui::CollapsingHeader("Rain", ImGuiTreeNodeFlags_DefaultOpen)) return;
  if (viewer.scene.rain.sizes.empty()) {
    text("the scene has no rain");
  } else {
    slider("rate [mm/h]", edits.rate_mm_h, 0, 300, "%.2f", true);
    const double low = -30, high = 30;
    ImGui::SliderScalarN("wind [m/s]", ImGuiDataType_Double, edits.wind_m_s.data(), 2, &low, &high,
                         "%.1f");
  }
  slider("clock", viewer.time_scale, 0, 2, "%.2f x");
  text(fmt::format("{:.2f} s, {} streaks in view", viewer.time_s, viewer.frame.streaks_in_view));
}

void picture_controls(Viewer& viewer) {
  SceneEdits& edits = viewer.edits;
  if (!ImGui::CollapsingHeader("Picture", ImGuiTreeNodeFlags_DefaultOpen)) return;
  const double white = viewer.scene.camera.white_cd_m2;
  slider("white [cd/m2]", edits.white_cd_m2, white / 100, white * 100, "%.3g", true);
  double shutter_ms = 1e3 * edits.exposure_s;
  if (slider("shutter [ms]", shutter_ms, 1, 200, "%.1f", true))
    edits.exposure_s = 1e-3 * shutter_ms;
  slider("field of view", edits.vertical_fov_deg, 5, 120, "%.0f deg");
}

void effect_controls(Viewer& viewer) {
  SceneEdits& edits = viewer.edits;
  if (!ImGui::CollapsingHeader("Effects", ImGuiTreeNodeFlags_DefaultOpen)) return;
  ImGui::Checkbox("rain", &edits.rain);
  ImGui::SameLine();
  const bool any_drop = !viewer.scene.rain.sizes.empty() || !viewer.scene.drops.empty();
  ImGui::BeginDisabled(!any_drop || !edits.rain);
  ImGui::Checkbox("splashes", &edits.splashes);
  ImGui::EndDisabled();
  ImGui::Checkbox("fog", &edits.fog);
  ImGui::SameLine();
  ImGui::BeginDisabled(!edits.fog);
  ImGui::Checkbox("glow", &edits.glow);
  ImGui::EndDisabled();
  const bool any_shadow = std::any_of(viewer.scene.lights.begin(), viewer.scene.lights.end(),
                                      [](const Light& light) { return light.shadow; });
  ImGui::SameLine();
  ImGui::BeginDisabled(!any_shadow);
  ImGui::Checkbox("shadows", &edits.shadows);
  ImGui::EndDisabled();
  ImGui::BeginDisabled(!any_drop || !edits.rain);
  ImGui::Checkbox("depth of field", &edits.depth_of_field);
  ImGui::EndDisabled();
  if (edits.depth_of_field) {
    double aperture_mm = 1e3 * edits.aperture_m;
    if (slider("aperture [mm]", aperture_mm, 0, 100, "%.1f")) edits.aperture_m = 1e-3 * aperture_mm;
    slider("focus [m]", edits.focus_m, nearest_focus_m, 1000, "%.2f", true);
  }
  if (edits.fog) slider("mist [1/m]", edits.air.extinction_per_m, 0, 0.2, "%.4f", true);
}

// What belongs to the look before does not stay; a look that the atlas cannot have is undone.
void look_control(RenderOptions& options) {
  int look = static_cast<int>(options.look);
  choice("look", {"traced", "sphere", "sphere of 2006", "white", "refraction"}, look);
  if (look == static_cast<int>(options.look)) return;
  options.look = static_cast<StreakLook>(look);
  options.background_share.reset();
  options.streak_cd_m2.reset();
}

void quality_controls(Viewer& viewer, PanelState& panel) {
  RenderOptions& options = viewer.edits.options;
  if (!ImGui::CollapsingHeader("Quality", ImGuiTreeNodeFlags_DefaultOpen)) return;
  look_control(options);
  int lookup = static_cast<int>(options.lookup);
  choice("lookup", {"nearest", "view-linear", "trilinear"}, lookup);
  options.lookup = static_cast<LookupMode>(lookup);
  slider("widest texel [px]", options.max_texel_px, 0.1, 4, "%.2f", true);
  slider("thin streaks [px]", options.widest_splat_px, 0, 4, "%.2f");
  bool thins = options.far_streaks > 0;
  ImGui::Checkbox("few far streaks stand for all", &thins);
  if (thins && options.far_streaks == 0) options.far_streaks = 16;
  if (!thins) options.far_streaks = 0;
  if (thins) slider("far streaks a pixel", options.far_streaks, 1, 256, "%.0f", true);
  ImGui::SliderInt("pixel size [px]", &viewer.edits.pixel_px, 1, 8, "%d",
                   ImGuiSliderFlags_AlwaysClamp);
  int scheme = static_cast<int>(options.packets.scheme);
  choice("packets", {"automatic", "world", "tree", "grid"}, scheme);
  options.packets.scheme = static_cast<PacketScheme>(scheme);
  ImGui::Checkbox("map of packets", &panel.packet_map);
}

// The light's colour at another strength, up to ten times the scene's.
void strength(const char* label, const Eigen::Vector3d& original, Eigen::Vector3d& now) {
  const double whole = original.maxCoeff();
  if (!(whole > 0)) return text("dark in the scene");
  double value = now.maxCoeff();
  if (slider(label, value, 0, 10 * whole, "%.3g")) now = value / whole * original;
}

void light_row(Light& light, const Light& original, int index) {
  ImGui::PushID(index);
  const std::string name = light.name.empty() ? fmt::format("light {}", index) : light.name;
  if (ImGui::TreeNode(name.c_str())) {
    if (light.kind == LightKind::sun) {
      strength("lux", original.illuminance_lux, light.illuminance_lux);
    } else {
      ImGui::DragScalarN("place [m]", ImGuiDataType_Double, light.position_m.data(), 3, 0.05f,
                         nullptr, nullptr, "%.2f");
      strength("cd", original.intensity_cd, light.intensity_cd);
    }
    ImGui::TreePop();
  }
  ImGui::PopID();
}

void light_controls(Viewer& viewer, PanelState& panel) {
  if (viewer.edits.lights.empty() || !ImGui::CollapsingHeader("Lights")) return;
  ImGui::Checkbox("handles in the picture", &panel.light_handles);
  for (std::size_t i = 0; i < viewer.edits.lights.size(); ++i)
    light_row(viewer.edits.lights[i], viewer.scene.lights[i], static_cast<int>(i));
}

void camera_controls(Viewer& viewer, PanelState& panel) {
  if (!ImGui::CollapsingHeader("Camera", ImGuiTreeNodeFlags_DefaultOpen)) return;
  const Eigen::Vector3d& p = viewer.camera.position_m;
  text(fmt::format("at {:.2f}, {:.2f}, {:.2f} m", p.x(), p.y(), p.z()));
  slider("speed [m/s]", panel.fly_speed_m_s, 0.1, 50, "%.1f", true);
  if (ImGui::Button(viewer.recording ? "stop" : "record"))
    viewer.recording ? stop_recording(viewer) : start_recording(viewer);
  ImGui::SameLine();
  ImGui::BeginDisabled(viewer.path.size() < 2);
  if (ImGui::Button("replay")) start_replay(viewer);
  ImGui::SameLine();
  if (ImGui::Button("save path")) tell(viewer, [&] { return save_path(viewer) + ".toml"; });
  ImGui::EndDisabled();
  ImGui::SameLine();
  text(fmt::format("{} keys", viewer.path.size()));
  if (ImGui::Button("screenshot (F12)")) panel.screenshot_asked = true;
  text("W A S D, Q E fly; shift faster; drag turns\nspace stops the clock, R records");
}

void cost_rows(const Viewer& viewer) {
  if (!ImGui::CollapsingHeader("Costs of the last frame", ImGuiTreeNodeFlags_DefaultOpen)) return;
  if (!ImGui::BeginTable("costs", 3)) return;
  // A width that follows the text is known only after the first frame.
  const float letter = ImGui::CalcTextSize("m").x;
  ImGui::TableSetupColumn("pass", ImGuiTableColumnFlags_WidthFixed, 11 * letter);
  ImGui::TableSetupColumn("cost", ImGuiTableColumnFlags_WidthFixed, 10 * letter);
  ImGui::TableSetupColumn("skipped", ImGuiTableColumnFlags_WidthStretch);
  for (const PassCost& cost : viewer.frame.costs) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    text(cost.pass);
    ImGui::TableNextColumn();
    text(fmt::format("{:.1f} ms", 1e3 * cost.wall_s));
    ImGui::TableNextColumn();
    text(cost.skipped);
  }
  ImGui::EndTable();
}

// Circles over the lamps in the picture; a lamp that is held goes where the mouse goes, at its
// distance.
void show_handles(Viewer& viewer, PanelState& panel) {
  const ImGuiIO& io = ImGui::GetIO();
  const Eigen::Vector2d scale(viewer.camera.width_px / static_cast<double>(io.DisplaySize.x),
                              viewer.camera.height_px / static_cast<double>(io.DisplaySize.y));
  const Eigen::Vector2d mouse(static_cast<double>(io.MousePos.x),
                              static_cast<double>(io.MousePos.y));
  const Eigen::Vector2d went(static_cast<double>(io.MouseDelta.x),
                             static_cast<double>(io.MouseDelta.y));
  if (!ImGui::IsMouseDown(ImGuiMouseButton_Left)) panel.held_light = -1;
  for (std::size_t i = 0; i < viewer.edits.lights.size(); ++i) {
    Light& light = viewer.edits.lights[i];
    if (light.kind == LightKind::sun) continue;
    const auto seen = seen_at_px(viewer.camera, light.position_m);
    if (!seen) continue;
    const Eigen::Vector2d at = seen->cwiseQuotient(scale);
    const bool near = (at - mouse).norm() < 10 && !io.WantCaptureMouse;
    const int index = static_cast<int>(i);
    if (near && ImGui::IsMouseClicked(ImGuiMouseButton_Left)) panel.held_light = index;
    const bool held = panel.held_light == index;
    if (held)
      light.position_m =
          dragged_to(viewer.camera, light.position_m, *seen + went.cwiseProduct(scale));
    const ImVec2 centre(static_cast<float>(at.x()), static_cast<float>(at.y()));
    ImDrawList* over = ImGui::GetBackgroundDrawList();
    over->AddCircle(centre, 8, IM_COL32(255, 255, 255, near || held ? 255 : 120), 0, 2);
    if (near || held)
      over->AddText({centre.x + 12, centre.y - 7}, IM_COL32(255, 255, 255, 255),
                    light.name.c_str());
  }
}

}  // namespace

PanelFrame::PanelFrame(GLFWwindow* window) {
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // nothing is written that nobody asked for
  ImGui::GetStyle().Colors[ImGuiCol_WindowBg].w = 0.85f;
  ImGui_ImplGlfw_InitForOpenGL(window, true);
  ImGui_ImplOpenGL3_Init("#version 450 core");
}

PanelFrame::~PanelFrame() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
}

void PanelFrame::begin() {
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
}

void PanelFrame::draw() {
  ImGui::Render();
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void show_panel(Viewer& viewer, PanelState& panel) {
  if (panel.screenshot_asked) tell(viewer, [&] { return save_screenshot(viewer) + ".exr, .png"; });
  panel.screenshot_asked = false;
  if (panel.light_handles) show_handles(viewer, panel);
  if (panel.streamlines) show_streamlines(viewer);
  if (!panel.shown) return;
  ImGui::SetNextWindowPos({8, 8}, ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowSize({340, ImGui::GetIO().DisplaySize.y - 16}, ImGuiCond_FirstUseEver);
  ImGui::Begin("Pluvia (P hides)");
  ImGui::PushItemWidth(170);
  rain_controls(viewer);
  wind_controls(viewer, panel.streamlines);
  picture_controls(viewer);
  effect_controls(viewer);
  quality_controls(viewer, panel);
  light_controls(viewer, panel);
  camera_controls(viewer, panel);
  cost_rows(viewer);
  ImGui::PopItemWidth();
  if (!viewer.message.empty()) ImGui::TextWrapped("%s", viewer.message.c_str());
  ImGui::End();
  if (panel.packet_map) show_packet_map(viewer, panel.map_size);
}

FlyInput fly_input(const PanelState& panel, const WindowKeys& keys) {
  const ImGuiIO& io = ImGui::GetIO();
  FlyInput input = {.speed_m_s = panel.fly_speed_m_s * (keys.fast ? 4 : 1)};
  if (!io.WantTextInput) input.move = keys.move;
  const bool turning =
      ImGui::IsMouseDown(ImGuiMouseButton_Left) || ImGui::IsMouseDown(ImGuiMouseButton_Right);
  if (turning && !io.WantCaptureMouse && panel.held_light < 0)
    input.turn_rad = {turn_per_px * static_cast<double>(io.MouseDelta.x),
                      -turn_per_px * static_cast<double>(io.MouseDelta.y)};
  return input;
}

void take_keys(Viewer& viewer, PanelState& panel, const WindowKeys& keys) {
  const WindowKeys before = std::exchange(panel.keys, keys);
  if (ImGui::GetIO().WantTextInput) return;
  if (keys.panel && !before.panel) panel.shown = !panel.shown;
  if (keys.screenshot && !before.screenshot) panel.screenshot_asked = true;
  if (keys.clock && !before.clock) viewer.time_scale = viewer.time_scale > 0 ? 0 : 1;
  if (keys.record && !before.record)
    viewer.recording ? stop_recording(viewer) : start_recording(viewer);
}

bool is_settled() {
  return !ImGui::IsAnyItemActive();
}

}  // namespace pluvia
