// The wind's primitives under the hand, and its streamlines (realtime/viewer/streamlines.h) over
// the picture, with Dear ImGui.
#pragma once

#include "realtime/viewer/viewer.h"

namespace pluvia {

// Place, turn, strength and core of each primitive. One that follows keys is taken from them where
// it is when it is touched. Nothing for a scene without primitives.
void wind_controls(Viewer& viewer, bool& streamlines);

void show_streamlines(const Viewer& viewer);

}  // namespace pluvia
