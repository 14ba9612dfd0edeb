// The viewer's controls, with Dear ImGui: a panel of numbers, handles of the lights in the picture,
// the map of packets.
#pragma once

#include "realtime/viewer/viewer.h"
#include "realtime/viewer/window.h"

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
  bool streamlines = false;
  int map_size = 0;     // of the rain's sizes
  int held_light = -1;  // being dragged
  double fly_speed_m_s = 2;
  bool screenshot_asked = false;
  WindowKeys keys = {};  // of the last frame
};

// All controls, for the frame that was drawn last; changes the viewer's edits, camera and clock.
void show_panel(Viewer& viewer, PanelState& panel);

// Where keys (W A S D along the view, Q E down and up, shift four times as fast) and the mouse
// (dragged over the picture: a turn) send the camera, where no control has them.
FlyInput fly_input(const PanelState& panel, const WindowKeys& keys);

// Of keys that were up in the last frame: P shows or hides the panel, F12 is a screenshot, space
// stops the clock, R starts and ends a recording.
void take_keys(Viewer& viewer, PanelState& panel, const WindowKeys& keys);

// Whether no control is held: edits may make the renderer anew.
bool is_settled();

}  // namespace pluvia
