#include "realtime/gl_context.h"

#include <stdexcept>
#include <utility>

#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <fmt/format.h>

namespace pluvia {
namespace {

std::string gl_string(GLenum name) {
  const GLubyte* text = glGetString(name);
  return text ? reinterpret_cast<const char*>(text) : "";
}

[[noreturn]] void refuse_opengl(const std::string& found) {
  throw std::runtime_error("OpenGL: " + found + "; expected OpenGL 4.5 core");
}

EGLDisplay initialised(EGLDisplay display) {
  if (display == EGL_NO_DISPLAY) return EGL_NO_DISPLAY;
  return eglInitialize(display, nullptr, nullptr) ? display : EGL_NO_DISPLAY;
}

EGLDisplay device_display() {
  if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_enumeration")) return EGL_NO_DISPLAY;
  EGLDeviceEXT device = nullptr;
  EGLint count = 0;
  if (!eglQueryDevicesEXT(1, &device, &count) || count < 1) return EGL_NO_DISPLAY;
  return initialised(eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, device, nullptr));
}

EGLDisplay open_display() {
  if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_base"))
    throw std::runtime_error(
        "OpenGL: EGL has no EGL_EXT_platform_base; expected EGL 1.5 with "
        "platforms");
  EGLDisplay display = EGL_NO_DISPLAY;
  if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless"))
    display = initialised(
        eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr));
  if (display == EGL_NO_DISPLAY) display = device_display();
  if (display == EGL_NO_DISPLAY)
    throw std::runtime_error("OpenGL: no EGL display; expected a surfaceless platform or a device");
  return display;
}

// What a display offers that refuses OpenGL 4.5: the version of the context that it gives unasked.
std::string offered_instead(EGLDisplay display) {
  const EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, nullptr);
  if (context == EGL_NO_CONTEXT) return "no OpenGL";
  eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context);
  const std::string found = opengl_version();
  eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display, context);
  return found;
}

EGLContext create_context(EGLDisplay display) {
  if (!eglBindAPI(EGL_OPENGL_API))
    throw std::runtime_error("OpenGL: EGL offers no desktop OpenGL; expected OpenGL 4.5 core");
  const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                               4,
                               EGL_CONTEXT_MINOR_VERSION,
                               5,
                               EGL_CONTEXT_OPENGL_PROFILE_MASK,
                               EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                               EGL_CONTEXT_OPENGL_DEBUG,
                               EGL_TRUE,
                               EGL_NONE};
  const EGLContext context =
      eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
  if (context == EGL_NO_CONTEXT) refuse_opengl(offered_instead(display));
  return context;
}

void make_egl_current(EGLDisplay display, EGLContext context) {
  if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context))
    throw std::runtime_error(fmt::format(
        "OpenGL: the context cannot be made current (EGL error {:#x}); expected it free "
        "on other threads",
        static_cast<unsigned>(eglGetError())));
}

void keep_first_error(GLenum, GLenum type, GLuint, GLenum, GLsizei, const GLchar* text,
                      const void* user) {
  auto* first = static_cast<std::string*>(const_cast<void*>(user));
  if (type == GL_DEBUG_TYPE_ERROR && first->empty()) *first = text;
}

}  // namespace

struct GlContext::State {
  std::function<void()> make_current = {};
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;  // none: a window's
  std::string first_error = {};

  void collect_errors() {
    make_current();
    glEnable(GL_DEBUG_OUTPUT);
    glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    glDebugMessageCallback(keep_first_error, &first_error);
  }
};

GlContext::GlContext() : state_(std::make_unique<State>()) {
  State& state = *state_;
  state.display = open_display();
  state.context = create_context(state.display);
  state.make_current = [&state] { make_egl_current(state.display, state.context); };
  state.collect_errors();
}

GlContext::GlContext(std::function<void()> make_current) : state_(std::make_unique<State>()) {
  state_->make_current = std::move(make_current);
  state_->make_current();
  if (epoxy_gl_version() < 45) refuse_opengl(opengl_version());
  state_->collect_errors();
}

// The display stays initialised: other contexts of the process share it.
GlContext::~GlContext() {
  if (state_->context == EGL_NO_CONTEXT) {
    state_->make_current();
    glDebugMessageCallback(nullptr, nullptr);
    return;
  }
  if (eglGetCurrentContext() == state_->context)
    eglMakeCurrent(state_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(state_->display, state_->context);
}

void GlContext::make_current() {
  state_->make_current();
}

GlInfo GlContext::info() const {
  return {gl_string(GL_VENDOR), gl_string(GL_RENDERER), gl_string(GL_VERSION)};
}

void GlContext::check() {
  if (state_->first_error.empty()) return;
  std::string text;
  text.swap(state_->first_error);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  throw std::runtime_error("OpenGL: " + text + "; expected no error");
}

std::string opengl_version() {
  return fmt::format("version {} ({})", gl_string(GL_VERSION), gl_string(GL_RENDERER));
}

}  // namespace pluvia
