// Which pictures of a database a scene can ask for: the views at which its camera can see drops,
// the directions from which its lights can shine on them, the drops' size, and the bands and the
// environment that have any light. Conservative: what is left out is never looked up.
//
// The box of the rain is cut into cells, halved until what a cell may ask for is decided. In a
// cell of half diagonal s whose middle is d from the camera (or lamp), the direction to it turns by
// at most asin(s / d); the azimuth about the fall by at most asin(s / distance from the axis
// through the camera). The nearest light of the database for any direction within e of one whose
// nearest light is a away, is at most a + 2 e away from it (triangle inequality). A cell counts
// as seen unless it lies, by more than a streak's size, beyond a side of the view.
#pragma once

#include <string>
#include <vector>

#include "raytrace/preset.h"
#include "raytrace/scene.h"

namespace pluvia {

struct SubsetRow {        // one line of the table that tells what was kept
  std::string what = {};  // "views", "lights", "sizes", "bands", "environment", "transfer"
  std::string kept = {};  // names
  std::string left_out = {};
};

struct SceneSubset {
  Preset preset = {};  // smaller: to be traced
  std::vector<SubsetRow> rows = {};
  long images = 0, all_images = 0;      // a band of a part counts as one
  long shards = 0, all_shards = 0;      // one for each size, oscillation, view
  long tracings = 0, all_tracings = 0;  // shards x bands: the share of tracing time
};

// The preset reduced to what the scene can ask for; oscillations stay as they are, since any drop
// may have any. `lights` become the same for all views (an atlas has one table of lights), in the
// database's order; without a lamp the first is kept, since an atlas needs one. Sizes: those
// nearest to each size of the scene's drops; an exposure longer than a picture's is several of
// them. Enough for the lookups of one light (atlas/atlas_lookup.h); trilinear ones would mix what
// is left.
//
// Throws std::runtime_error "FILE: .." when no drop of the scene can be seen.
SceneSubset scene_subset(const Preset& preset, const Scene& scene, const std::string& scene_file);

// Views (of a preset's list, ascending) and lights that drops of the scene in view can ask for;
// along a camera path, at 64 moments evenly spread over it.
struct Reach {
  std::vector<int> views_deg = {};
  std::vector<LightDirection> lights = {};
};
Reach scene_reach(const Preset& preset, const Scene& scene);

}  // namespace pluvia
