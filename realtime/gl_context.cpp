#include "realtime/gl_context.h"

#include <stdexcept>
#include <vector>

#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <fmt/format.h>

namespace pluvia {
namespace {

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
  if (context == EGL_NO_CONTEXT)
    throw std::runtime_error(
        fmt::format("OpenGL: EGL refused a context (error {:#x}); expected "
                    "OpenGL 4.5 core",
                    static_cast<unsigned>(eglGetError())));
  return context;
}

void keep_first_error(GLenum, GLenum type, GLuint, GLenum, GLsizei, const GLchar* text,
                      const void* user) {
  auto* first = static_cast<std::string*>(const_cast<void*>(user));
  if (type == GL_DEBUG_TYPE_ERROR && first->empty()) *first = text;
}

std::string gl_string(GLenum name) {
  const GLubyte* text = glGetString(name);
  return text ? reinterpret_cast<const char*>(text) : "";
}

}  // namespace

struct GlContext::State {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
  std::string first_error = {};
};

GlContext::GlContext() : state_(std::make_unique<State>()) {
  state_->display = open_display();
  state_->context = create_context(state_->display);
  make_current();
  glEnable(GL_DEBUG_OUTPUT);
  glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
  glDebugMessageCallback(keep_first_error, &state_->first_error);
}

// The display stays initialised: other contexts of the process share it.
GlContext::~GlContext() {
  if (eglGetCurrentContext() == state_->context)
    eglMakeCurrent(state_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(state_->display, state_->context);
}

void GlContext::make_current() {
  if (!eglMakeCurrent(state_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, state_->context))
    throw std::runtime_error(
        fmt::format("OpenGL: the context cannot be made current (EGL error "
                    "{:#x}); expected it free on other threads",
                    static_cast<unsigned>(eglGetError())));
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

}  // namespace pluvia
