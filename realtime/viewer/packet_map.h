// The rain's packets as a map across the fall (raytrace/rain_packets.h): which a frame takes, and
// why.
#pragma once

#include <vector>

#include "raytrace/rain_packets.h"
#include "raytrace/rain_space.h"

namespace pluvia {

struct MapRectangle {
  Eigen::Vector2d low_m = {0, 0}, high_m = {0, 0};
};

struct PacketMap {  // in x and y of the size's frame
  std::vector<MapRectangle> taken = {};
  MapRectangle box = {};              // of the rain
  PlanePolygon shadow = {};           // what the picture can show
  Eigen::Vector2d camera_m = {0, 0};  // along the fall
  Eigen::Vector2d centre_m = {0, 0};  // of the local space
  double radius_m = 0;
};

// Of one size of the rain (0 .. scene.rain.sizes.size() - 1).
PacketMap packet_map(const Rain& rain, const RainSpace& space, const RainPackets& packets,
                     const Camera& camera, double time_s, int size);

}  // namespace pluvia
