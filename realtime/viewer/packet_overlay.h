// The map of packets (realtime/viewer/packet_map.h) as an ImGui window.
#pragma once

#include "realtime/viewer/viewer.h"

namespace pluvia {

// size: of the rain's sizes, which the window lets choose.
void show_packet_map(const Viewer& viewer, int& size);

}  // namespace pluvia
