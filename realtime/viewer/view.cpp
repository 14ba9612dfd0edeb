#include "realtime/viewer/view.h"

#include <chrono>

#include <epoxy/gl.h>

#include "atlas/image_io.h"
#include "realtime/viewer/panel.h"

namespace pluvia {
namespace {

using Clock = std::chrono::steady_clock;

// A minimised window is looked at again so often.
constexpr double idle_s = 0.1;

// The window as it is, panel and all.
void save_window(const std::string& file, const WindowSize& size) {
  const auto row = static_cast<std::size_t>(3 * size.width_px);
  const auto rows = static_cast<std::size_t>(size.height_px);
  std::vector<unsigned char> from_below(row * rows), bytes;
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
  glReadBuffer(GL_BACK);
  glReadPixels(0, 0, size.width_px, size.height_px, GL_RGB, GL_UNSIGNED_BYTE, from_below.data());
  for (std::size_t y = rows; y-- > 0;)
    bytes.insert(bytes.end(), &from_below[y * row], &from_below[y * row] + row);
  write_srgb_png(file, bytes, size.width_px, size.height_px);
}

// What is left of a given number of frames: the last one, and the window that showed it.
void save_last(Viewer& viewer, const WindowSize& size) {
  const std::string shot = save_screenshot(viewer);
  save_window(shot + "_window.png", size);
}

FlyInput show_controls(Viewer& viewer, PanelState& panel, PanelFrame& controls,
                       const WindowKeys& keys) {
  controls.begin();
  take_keys(viewer, panel, keys);
  show_panel(viewer, panel);
  controls.draw();
  return fly_input(panel, keys);
}

}  // namespace

void view(Window& window, const Scene& scene, const StreakAtlas& atlas,
          const ViewOptions& options) {
  PanelFrame controls(window.handle());
  PanelState panel;
  Viewer viewer = make_viewer(window.context(), scene, atlas, options.render, options.start_s,
                              options.out_folder);
  viewer.edits.pixel_px = options.pixel_px;
  Clock::time_point last = Clock::now();
  for (int k = 0; !window.closed() && (options.frames == 0 || k < options.frames);) {
    window.take_events(0);
    const WindowSize size = window.size();
    if (!draw_viewer(viewer, is_settled(), 0, size.width_px, size.height_px)) {
      window.take_events(idle_s);
      continue;
    }
    const FlyInput input = show_controls(viewer, panel, controls, window.keys());
    if (++k == options.frames) save_last(viewer, size);
    window.show();
    const Clock::time_point now = Clock::now();
    const double passed_s = std::chrono::duration<double>(now - last).count();
    last = now;
    const double next_s = options.frames > 0
                              ? options.start_s + static_cast<double>(k) / options.frames_per_s
                              : viewer.time_s + viewer.time_scale * passed_s;
    advance(viewer, input, passed_s, next_s);
  }
}

}  // namespace pluvia
