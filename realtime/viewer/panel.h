// The viewer's controls, with Dear ImGui: a panel of numbers, handles of the lights in the picture,
// the map of packets.
#pragma once

#include "realtime/viewer/viewer.h"

struct GLFWwindow;

namespace pluvia {

// Dear ImGui in a window whose OpenGL context is current, for as long as this lives.
class PanelFrame {
 public:
  explicit PanelFrame(GLFWwindow* window);
  ~PanelFrame();
  PanelFrame(const PanelFrame&) = delete;
  PanelFrame& operator=(const PanelFrame&) = delete;

  void begin();  // before any control of a frame
  void draw();   // over what is in framebuffer 0
};

struct PanelState {  // what the panel itself keeps
  bool shown = true;
  bool light_handles = true;
  bool packet_map = false;
  int map_size = 0;     // of the rain's sizes
  int held_light = -1;  // being dragged
  double fly_speed_m_s = 2;
  bool screenshot_asked = false;
};

// All controls, for the frame that was drawn last; changes the viewer's edits, camera and clock.
void show_panel(Viewer& viewer, PanelState& panel);

// What keys (W A S D Q E, shift: four times as fast) and the mouse (drag: turn) ask for, where no
// control has them. A key pressed: P panel, F12 screenshot, space clock, R recording.
FlyInput fly_input(const PanelState& panel);
void take_keys(Viewer& viewer, PanelState& panel);

// Whether no control is held: edits may make the renderer anew.
bool is_settled();

}  // namespace pluvia
