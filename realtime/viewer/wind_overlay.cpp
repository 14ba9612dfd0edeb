#include "realtime/viewer/wind_overlay.h"

#include <algorithm>

#include <fmt/format.h>
#include <imgui.h>

#include "realtime/viewer/streamlines.h"

namespace pluvia {
namespace {

constexpr ImU32 line_color = IM_COL32(140, 220, 255, 150), tip_color = IM_COL32(230, 250, 255, 230);
constexpr double fastest_m_s = 60;  // that a slider gives

const char* name_of(WindKind kind) {
  switch (kind) {
    case WindKind::uniform:
      return "uniform";
    case WindKind::source:
      return "source";
    case WindKind::vortex:
      return "vortex";
    case WindKind::tornado:
      return "tornado";
  }
  return "";
}

bool slider(const char* label, double& value, double low, double high, const char* format) {
  return ImGui::SliderScalar(label, ImGuiDataType_Double, &value, &low, &high, format,
                             ImGuiSliderFlags_AlwaysClamp);
}

bool place_slider(const Rain& rain, int axis, WindPrimitive& primitive) {
  const char* const labels[3] = {"east [m]", "north [m]", "up [m]"};
  return slider(labels[axis], primitive.position_m[axis], rain.box_min_m[axis],
                rain.box_max_m[axis], "%.2f");
}

// The strength of the fastest that a slider gives; most_speed_m_s goes with it.
double greatest_strength(WindPrimitive primitive) {
  primitive.strength = 1;
  return fastest_m_s / most_speed_m_s(primitive);
}

bool primitive_controls(const Rain& rain, WindPrimitive& primitive) {
  bool touched = false;
  if (primitive.kind != WindKind::uniform) {
    for (int axis = 0; axis < 3; ++axis) touched |= place_slider(rain, axis, primitive);
  }
  Turn turn = turn_of(primitive.axis);
  const bool turned = slider("tilt", turn.tilt_deg, 0, 180, "%.0f deg") |
                      slider("heading", turn.heading_deg, -180, 180, "%.0f deg");
  if (turned) primitive.axis = axis_of(turn);
  const double most = greatest_strength(primitive);
  const char* label = primitive.kind == WindKind::uniform ? "speed [m/s]" : "strength [m2/s]";
  touched |= slider(label, primitive.strength, -most, most, "%.1f");
  return touched || turned;
}

ImVec2 to_window(const Eigen::Vector2d& at_px, const Camera& camera) {
  const ImVec2& window = ImGui::GetIO().DisplaySize;
  return {static_cast<float>(at_px.x()) * window.x / static_cast<float>(camera.width_px),
          static_cast<float>(at_px.y()) * window.y / static_cast<float>(camera.height_px)};
}

void draw_line(const Camera& camera, const Streamline& line, ImDrawList& list) {
  std::vector<ImVec2> points;
  for (const Eigen::Vector3d& at : line) {
    const auto seen = seen_at_px(camera, at);
    if (!seen) return;  // it comes too near to the eye
    points.push_back(to_window(*seen, camera));
  }
  if (points.size() < 2) return;
  list.AddPolyline(points.data(), static_cast<int>(points.size()), line_color, 0, 1.5f);
  list.AddCircleFilled(points.back(), 2.5f, tip_color);
}

}  // namespace

void wind_controls(Viewer& viewer, bool& streamlines) {
  std::vector<WindPrimitive>& wind = viewer.edits.wind;
  if (wind.empty() || !ImGui::CollapsingHeader("Wind", ImGuiTreeNodeFlags_DefaultOpen)) return;
  ImGui::Checkbox("streamlines", &streamlines);
  for (std::size_t i = 0; i < wind.size(); ++i) {
    WindPrimitive now = primitive_at(wind[i], viewer.time_s);
    const std::string label = fmt::format("{} {}{}", name_of(now.kind), i + 1,
                                          wind[i].path.empty() ? "" : " (follows keys)");
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::TreeNodeEx("primitive", ImGuiTreeNodeFlags_DefaultOpen, "%s", label.c_str())) {
      if (primitive_controls(viewer.scene.rain, now)) wind[i] = now;
      ImGui::TreePop();
    }
    ImGui::PopID();
  }
}

void show_streamlines(const Viewer& viewer) {
  Rain rain = viewer.scene.rain;  // an edited scene would copy its surfaces in every frame
  rain.wind_m_s = viewer.edits.wind_m_s;
  rain.wind = viewer.edits.wind;
  ImDrawList* over = ImGui::GetBackgroundDrawList();
  for (const Streamline& line : wind_lines(rain, viewer.time_s))
    draw_line(viewer.camera, line, *over);
}

}  // namespace pluvia
