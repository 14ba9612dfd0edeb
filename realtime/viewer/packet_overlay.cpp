#include "realtime/viewer/packet_overlay.h"

#include <algorithm>

#include <fmt/format.h>
#include <imgui.h>

#include "realtime/viewer/packet_map.h"

namespace pluvia {
namespace {

constexpr float side_px = 280;
constexpr ImU32 paper = IM_COL32(20, 24, 30, 255), packet_fill = IM_COL32(80, 140, 220, 90),
                packet_rim = IM_COL32(120, 180, 255, 255), view_rim = IM_COL32(255, 220, 120, 255),
                reach_rim = IM_COL32(150, 150, 150, 255), eye = IM_COL32(255, 255, 255, 255);

// Metres of the map to pixels of the window; y up.
struct MapView {
  Eigen::Vector2d centre_m = {0, 0};
  double px_per_m = 1;
  ImVec2 corner = {};

  ImVec2 at(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d d = px_per_m * (p - centre_m);
    return {corner.x + side_px / 2 + static_cast<float>(d.x()),
            corner.y + side_px / 2 - static_cast<float>(d.y())};
  }
};

void draw_map(const PacketMap& map, const MapView& view, ImDrawList& list) {
  const ImVec2 end = {view.corner.x + side_px, view.corner.y + side_px};
  list.AddRectFilled(view.corner, end, paper);
  list.PushClipRect(view.corner, end, true);
  for (const MapRectangle& rectangle : map.taken) {
    const ImVec2 a = view.at(rectangle.low_m), b = view.at(rectangle.high_m);
    list.AddRectFilled({a.x, b.y}, {b.x, a.y}, packet_fill);
    list.AddRect({a.x, b.y}, {b.x, a.y}, packet_rim);
  }
  const ImVec2 low = view.at(map.box.low_m), high = view.at(map.box.high_m);
  list.AddRect({low.x, high.y}, {high.x, low.y}, reach_rim);
  list.AddCircle(view.at(map.centre_m), static_cast<float>(view.px_per_m * map.radius_m), reach_rim,
                 64);
  std::vector<ImVec2> shadow;
  for (const Eigen::Vector2d& p : map.shadow) shadow.push_back(view.at(p));
  list.AddPolyline(shadow.data(), static_cast<int>(shadow.size()), view_rim, ImDrawFlags_Closed, 2);
  list.AddCircleFilled(view.at(map.camera_m), 4, eye);
  list.PopClipRect();
}

}  // namespace

void show_packet_map(const Viewer& viewer, int& size) {
  const RainPackets* packets = viewer.renderer ? viewer.renderer->rain_packets() : nullptr;
  ImGui::SetNextWindowPos({ImGui::GetIO().DisplaySize.x - 312, 8}, ImGuiCond_FirstUseEver);
  ImGui::Begin("Packets", nullptr, ImGuiWindowFlags_AlwaysAutoResize);
  const Rain rain = edited_scene(viewer.scene, viewer.made).rain;
  if (!packets || rain.sizes.empty()) {
    ImGui::TextUnformatted("no rain");
    ImGui::End();
    return;
  }
  const int last = static_cast<int>(rain.sizes.size()) - 1;
  size = std::clamp(size, 0, last);
  if (last > 0) ImGui::SliderInt("size", &size, 0, last);
  const RainSpace& space = viewer.renderer->rain_space();
  const PacketMap map = packet_map(rain, space, *packets, viewer.camera, viewer.time_s, size);
  const MapView view = {.centre_m = map.centre_m,
                        .px_per_m = static_cast<double>(side_px) / (2.2 * map.radius_m),
                        .corner = ImGui::GetCursorScreenPos()};
  draw_map(map, view, *ImGui::GetWindowDrawList());
  ImGui::Dummy({side_px, side_px});
  const std::string line =
      fmt::format("{}: {} of {} packets, {} drops\nradius {:.1f} m, height {:.1f} m",
                  packet_scheme_name(packets->options.scheme), viewer.frame.packets.packets_taken,
                  viewer.frame.packets.packets_looked_at, viewer.frame.packets.drops_looked_at,
                  space.culling_radius_m, space.local_height_m);
  ImGui::TextUnformatted(line.c_str());
  ImGui::End();
}

}  // namespace pluvia
