// The checks of the fidelity report, by rung of the ladder of truth. Each function measures, and
// adds its checks, figures, tables and timings to the report.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "atlas/streak_atlas.h"
#include "raytrace/generate.h"
#include "validate/picture_comparison.h"
#include "validate/report.h"

namespace pluvia {

struct Frame;           // realtime/rain_renderer.h
struct FrameComposite;  // validate/frame_composite.h
struct Scene;           // raytrace/scene.h

// A sphere of index 1.333 against the closed form: sphere.energy.p0 .. p3, sphere.rainbow.p2_deg
// and p3_deg (as the extremum of traced exit directions), sphere.intensity.rms.
void add_sphere_checks(Report& report);

// Nothing is lost: furnace (a uniform environment), and mesh.convergence (exit directions of
// triangle meshes against the analytic surface).
void add_energy_check(const Preset& preset, Report& report);
void add_mesh_check(const Preset& preset, Report& report);

// The exit field against brute force on one streak, all lights at once: field.flux.easy and .hard
// with the standard errors that they rest on, field.picture.easy and .hard, and three streaks side
// by side with difference and noise.
void add_field_checks(const Preset& preset, const Progress& progress, Report& report);

// The database against the closed-form sphere (gn2006.sphere_closed_form.osc0) and against the real
// database's factors (gn2006.log_factor_rms.osc0 and .all, with the worst five directions).
void add_database_checks(const std::string& database_folder, const std::string& factor_file,
                         Report& report);

// The area that the rigid sphere's pictures cover against its disc: gn2006.sphere_coverage.osc0.
void add_coverage_check(const std::string& database_folder, Report& report);

// A streak of the database, of a drop that is not its own mirror image, against brute force of the
// drop that the manifest tells: gn2006.brute_force.osc6.easy and .hard. What the database lacks is
// skipped.
void add_streak_checks(const std::string& database_folder, const Progress& progress,
                       Report& report);

// An atlas against the database that it was packed from, every texel of every level: atlas.cells
// and atlas.mips. Skipped for the atlas of another database, and where there are several bands.
void add_atlas_checks(const std::string& database_folder, const StreakAtlas& atlas, Report& report);

// Whether a lamp on the right lights the right side of a drop: frame.lamp_side, the composited
// streak of the atlas's rigid sphere against closed-form rays of the sphere that the database's
// manifest tells.
void add_lamp_check(const std::string& database_folder, const StreakAtlas& atlas, Report& report);

// Pictures of the database: every oscillation under one light, and one oscillation under many.
void add_gallery(const std::string& database_folder, Report& report);

struct CheckedFrame {
  std::string scene_file = {};
  double time_s = 1;             // shutter-open
  int most_width_px = 0;         // a wider camera's picture is made so small; 0: never
  std::string prefix = "frame";  // of the checks' names
};

// One real-time frame against a double-precision composite of the same drops: prefix.composite,
// prefix.png, and add_picture_checks with the prefix. Splashes, depth of field and shadows, which
// the composite does not know, are left out of both, and told under `skipped`.
void add_frame_check(const CheckedFrame& checked, const StreakAtlas& atlas, Report& report);

// The same of a frame and its composite that are there already. what: "NAME at TIME".
void add_frame_comparison(const std::string& prefix, const Scene& scene, const Frame& frame,
                          const FrameComposite& truth, const std::string& what, Report& report);

// A frame's PNG (atlas/image_io.h) against its radiance: prefix.png. Throws std::runtime_error for
// bytes that are no PNG of the frame's size.
void add_png_check(const std::string& prefix, const std::vector<unsigned char>& png,
                   const Image& frame, double white, Report& report);

// Single drops in real time against the reference tracer, drop by drop (validate/drop_by_drop.h),
// nine sets under suns that the database holds, between those, and under a uniform sky:
// reference.flux.lamps, .lamps.sum, .direct, .between and .sky, reference.picture, and what each
// shortcut costs. preset: how the atlas's drops oscillate, the cone of its lights. An atlas without
// the views 0, 20 and 40 degrees, ten sets or a sky is told under `skipped`.
void add_reference_checks(const Preset& preset, const StreakAtlas& atlas, const Progress& progress,
                          Report& report);

// What each approximation costs (validate/price_tags.h), a table for each kind. brief: two
// drops from one side under every twelfth light, some 20 CPU s; full: from two sides under all, and
// the grids of lights and views, sizes
// of drops, degrees of the sky, some minutes. data_folder: of the sky's map.
enum class StudyDepth { brief, full };
void add_streak_prices(const Preset& preset, const std::string& data_folder, StudyDepth depth,
                       const Progress& progress, Report& report);

// The same of levels and formats of an atlas.
void add_format_prices(const StreakAtlas& atlas, Report& report);

// The same of frames: of a scene's, 320 x 180 px with a quarter of its drops and with twice as
// many, against the exact composite, of drops near the camera and near lamps against the reference.
// A few minutes.
void add_frame_prices(const std::string& scene_file, const StreakAtlas& atlas, const Preset& preset,
                      const Progress& progress, Report& report);

// A small frame of near rain against the reference tracer: reference.frame, a comparison, and what
// each lookup costs it; full: with more samples and more of them.
void add_whole_frame_check(const Preset& preset, const StreakAtlas& atlas,
                           const std::string& data_folder, StudyDepth depth, Report& report);

// The metrics of pictures (docs/fidelity.md), as prefix.psnr.ldr and .hdr, .ssim, .ms_ssim,
// .flip.ldr and .hdr, .streak_flux, .streaks.brightness, .width and .lean, .spectrum.rings and
// .sectors, with a table of percentiles and the error maps. The pictures are taken as exact.
void add_picture_checks(const std::string& prefix, const ComparedPictures& pictures,
                        Report& report);

// value = |measured - expected|, or that over `scale`.
Check deviation(const std::string& name, double measured, double expected, double bound,
                const std::string& unit, const std::string& why, double scale = 1);

}  // namespace pluvia
