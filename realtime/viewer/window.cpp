#include "realtime/viewer/window.h"

#include <stdexcept>

// Before GLFW's own header, which else brings another of OpenGL.
#include <epoxy/gl.h>

#include <GLFW/glfw3.h>
#include <fmt/format.h>

namespace pluvia {
namespace {

// GLFW's last complaint; empty: none.
std::string complaint() {
  const char* text = nullptr;
  return glfwGetError(&text) == GLFW_NO_ERROR || !text ? "" : text;
}

GLFWwindow* create(const std::string& title, const WindowSize& size) {
  return glfwCreateWindow(size.width_px, size.height_px, title.c_str(), nullptr, nullptr);
}

GLFWwindow* create_modern(const std::string& title, const WindowSize& size) {
  glfwDefaultWindowHints();
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_DEBUG_CONTEXT, GLFW_TRUE);
  return create(title, size);
}

// What the display offers that refuses OpenGL 4.5: the version of a window that asks for none.
std::string offered_instead() {
  glfwDefaultWindowHints();
  glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
  GLFWwindow* any = create("", {16, 16});
  if (!any) return "no OpenGL: " + complaint();
  glfwMakeContextCurrent(any);
  const std::string found = opengl_version();
  glfwDestroyWindow(any);
  return found;
}

}  // namespace

Window::Window(const std::string& title, const WindowSize& size) {
  if (!glfwInit()) throw std::runtime_error("window: " + complaint() + "; expected a display");
  window_ = create_modern(title, size);
  if (!window_) {
    const std::string found = offered_instead();
    glfwTerminate();
    throw std::runtime_error("OpenGL: " + found + "; expected OpenGL 4.5 core");
  }
  try {
    context_ = std::make_shared<GlContext>([this] { glfwMakeContextCurrent(window_); });
  } catch (...) {
    glfwTerminate();
    throw;
  }
  glfwSwapInterval(1);
  glfwSetInputMode(window_, GLFW_STICKY_KEYS, GLFW_TRUE);
}

Window::~Window() {
  context_.reset();
  glfwDestroyWindow(window_);
  glfwTerminate();
}

WindowSize Window::size() const {
  WindowSize size;
  glfwGetFramebufferSize(window_, &size.width_px, &size.height_px);
  return size;
}

void Window::resize(const WindowSize& size) {
  glfwSetWindowSize(window_, size.width_px, size.height_px);
}

bool Window::closed() const {
  return glfwWindowShouldClose(window_);
}

void Window::take_events(double wait_s) {
  if (wait_s > 0)
    glfwWaitEventsTimeout(wait_s);
  else
    glfwPollEvents();
}

WindowKeys Window::keys() {
  const auto down = [&](int key) { return glfwGetKey(window_, key) == GLFW_PRESS; };
  const auto axis = [&](int more, int less) {
    return (down(more) ? 1.0 : 0) - (down(less) ? 1.0 : 0);
  };
  return {.move = {axis(GLFW_KEY_D, GLFW_KEY_A), axis(GLFW_KEY_W, GLFW_KEY_S),
                   axis(GLFW_KEY_E, GLFW_KEY_Q)},
          .fast = down(GLFW_KEY_LEFT_SHIFT) || down(GLFW_KEY_RIGHT_SHIFT),
          .panel = down(GLFW_KEY_P),
          .clock = down(GLFW_KEY_SPACE),
          .record = down(GLFW_KEY_R),
          .screenshot = down(GLFW_KEY_F12)};
}

void Window::show() {
  glfwSwapBuffers(window_);
}

}  // namespace pluvia
