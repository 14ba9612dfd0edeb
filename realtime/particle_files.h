// Drops of a run in files that other programs read: drops.csv, a row for each drop and frame, and
// camera0.xml, the layout in which the rain augmentation of Halder, Lalonde and de Charette (ICCV
// 2019; Tremblay et al., IJCV 2020; github.com/astra-vision/rain-rendering) takes the output of the
// particle simulator of de Charette et al. (ICCP 2012). docs/compose.md has both layouts.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "raytrace/scene.h"
#include "realtime/drop_list.h"

namespace pluvia {

struct FrameDrops {
  int frame = 0;
  double time_s = 0;  // shutter opens
  std::vector<ListedDrop> drops = {};
};

// Numbers are the shortest decimal text that reads back as the same double.
std::string drops_csv_head(const Scene& scene);
std::string drops_csv_rows(const FrameDrops& frame);

// The document is head, the frames' elements, tail.
std::string particles_xml_head();
std::string particles_xml_frame(const Scene& scene, const FrameDrops& frame);
std::string particles_xml_tail();

}  // namespace pluvia
