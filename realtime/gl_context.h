// An OpenGL 4.5 core context: one without a window or a display server (EGL, surfaceless platform;
// the first EGL device where that platform is missing), or a window's own.
#pragma once

#include <functional>
#include <memory>
#include <string>

namespace pluvia {

struct GlInfo {
  std::string vendor, renderer, version;
};  // what the machine's OpenGL is: for reports

class GlContext {
 public:
  // Current on this thread afterwards. Throws std::runtime_error "OpenGL: what was found; what is
  // expected" when there is no EGL or no OpenGL 4.5 core.
  GlContext();

  // The context that make_current makes current: a window's, which stays its owner and must outlive
  // this. Throws as above when it is older than 4.5.
  explicit GlContext(std::function<void()> make_current);

  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  void make_current();  // on the calling thread; throws when it is current on another
  GlInfo info() const;

  // Throws std::runtime_error "OpenGL: TEXT" with the driver's first complaint since the last call.
  // A driver reports errors through a C callback, which must not throw itself.
  void check();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Version and renderer of the context that is current: for messages.
std::string opengl_version();

}  // namespace pluvia
