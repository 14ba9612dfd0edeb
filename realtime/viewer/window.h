// A window with an OpenGL 4.5 core context, through GLFW: the only file of the renderer that needs
// a display.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include <Eigen/Core>

#include "realtime/gl_context.h"

struct GLFWwindow;

namespace pluvia {

struct WindowSize {  // of its framebuffer; 0 x 0 while it is minimised
  int width_px = 0, height_px = 0;
};

// Keys that are down, or were since they were last asked for: a frame may take longer than a tap.
struct WindowKeys {
  Eigen::Vector3d move = {0, 0, 0};  // D - A, W - S, E - Q
  bool fast = false;                 // shift
  bool panel = false;                // P
  bool clock = false;                // space
  bool record = false;               // R
  bool screenshot = false;           // F12
};

class Window {
 public:
  // Throws std::runtime_error "window: what was found; what is expected" without a display, and
  // "OpenGL: .." where there is no OpenGL 4.5 core.
  Window(const std::string& title, const WindowSize& size);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  GLFWwindow* handle() const { return window_; }
  // Use it before the window is gone.
  const std::shared_ptr<GlContext>& context() const { return context_; }
  WindowSize size() const;
  void resize(const WindowSize& size);  // in the screen's coordinates
  bool closed() const;
  // What the user did since the last call; waits up to wait_s for it.
  void take_events(double wait_s);
  WindowKeys keys();
  void show();  // what was drawn into framebuffer 0

 private:
  GLFWwindow* window_ = nullptr;
  std::shared_ptr<GlContext> context_ = {};
};

}  // namespace pluvia
