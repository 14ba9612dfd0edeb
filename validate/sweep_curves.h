// The curves that `pluvia sweep` measures (validate/sweep.h). Each names in its text what its error
// is of; points come without front and recommendation.
#pragma once

#include <string>

#include "raytrace/generate.h"
#include "validate/sweep.h"

namespace pluvia {

struct SweepInputs {
  std::string preset_file = {};  // generator, atlas: of the kind gn2006
  std::string physical_preset_file =
      {};                         // drop: of the kind physical, with a drop of 3 mm and set 6
  std::string scene_file = {};    // renderer
  std::string atlas_folder = {};  // renderer, models
  std::string masks_folder = {};  // models: of refraction; empty: without it
  std::string data_folder = {};   // models: the project's
  int repeats = 3;                // of each time, >= 1
  bool quick = false;             // fewer settings, smaller pictures: to try it, not to quote it
};

// What a tenth of the exposure of two shards costs by the settings of the exit field, by counting
// rays and by counting rays that meet a mesh, against finer runs of the field
// (validate/sweep_streaks.h). Times are processor time of one thread. A picked setting is held
// against a whole database. Throws std::runtime_error for files.
SweepCurve sweep_generator(const SweepInputs& inputs, const Progress& progress);

// What triangle meshes of the drop cost, and what light they move: the same rays through meshes,
// through meshes with polished hits and through the analytic drop (raytrace/brute_force.h). Their
// noise is the same, but for rays that only one of the two sees, and taken away: the error is bias.
// Times are processor time of one thread and hold the building of a mesh for each instant.
SweepCurve sweep_mesh(const SweepInputs& inputs, const Progress& progress);

// What a streak costs by the model of the drop (sphere or shape at rest, no mode to five), against
// the fullest one (validate/sweep_streaks.h). Times are processor time of one thread. Throws
// std::runtime_error for files and a preset without that drop.
SweepCurve sweep_drop(const SweepInputs& inputs, const Progress& progress);

// What a set's pictures cost by the directions that they are traced for, by their width, and by the
// form they are kept in, against streaks traced between the directions (validate/grid_prices.h,
// format_prices.h). Times are processor time of one thread and hold the bringing into that form.
// Throws std::runtime_error for files.
SweepCurve sweep_atlas(const SweepInputs& inputs, const Progress& progress);

// What a frame's rain costs by lookup, texels, streaks that stand for many, harmonics of the sky
// and drops that are left out, against the fullest rain that the renderer draws: quads alone, four
// samples a pixel, trilinear light, drops out to 1.5 times as far (validate/frame_composite.h
// would take minutes for each instant, and agrees with quads to 0.013: docs/rendering.md). The
// error is the mean over instants of the relative RMSE of the rain as a screen shows it (what is
// brighter than white is white), its standard error comes from their spread. Splashes are left out.
// Times are of the passes that draw rain: processor time on a software rasteriser, wall-clock time
// on a GPU. Throws std::runtime_error for files, and as RainRenderer.
SweepCurve sweep_renderer(const SweepInputs& inputs, const Progress& progress);

// What each model of a streak's light costs and is off (realtime/rain_look.h, billboard_pass.h):
// flat white; A, billboards of 2010 and traced streaks by their lookups, the sky by harmonics or by
// its mean, few far streaks for many; B, a sphere's transfer function; C, refraction by masks; of
// the same drops, in small scenes (validate/frame_prices.h), against the reference tracer. Times
// are of the same rain 100 times as dense (near drops: 10 times), as in sweep_renderer; there, what
// far streaks that stand for others are off is measured against all of them, and added in squares.
// Near drops have wide streaks: there refraction is measured by its samples. Throws
// std::runtime_error for files, as RainRenderer, and for an atlas that lacks what the reference
// needs.
SweepCurve sweep_models_by_day(const SweepInputs& inputs, const Progress& progress);
SweepCurve sweep_models_at_night(const SweepInputs& inputs, const Progress& progress);
SweepCurve sweep_near_models_by_day(const SweepInputs& inputs, const Progress& progress);
SweepCurve sweep_near_models_at_night(const SweepInputs& inputs, const Progress& progress);

}  // namespace pluvia
