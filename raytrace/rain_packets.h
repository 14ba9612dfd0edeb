// Which of the rain's cells a picture can show. Cells are looked at in packets, after Creus (2010):
//   world   one packet for all of a size: no selection
//   tree    the leaves of a kd-tree (halves of equal numbers of drops) or of a quad-tree (quarters
//   of
//           equal area) over the plane across the fall, whichever has fewer, each at most a
//           packet's drops; only for a box that is bounded across the fall
//   grid    squares of as many cells as hold at most a packet's drops
// and `automatic` is the one that needs the fewest packets. All draw the same drops in the same
// order: the scheme decides about time alone.
//
// A packet is taken when it meets the prism of the local space and what the picture's frustum
// throws on the plane along the fall, within the slab: the convex hull of that shadow, or the
// rectangle around it as published.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "raytrace/rain_space.h"
#include "raytrace/scene.h"

namespace pluvia {

enum class PacketScheme { automatic, world, tree, grid };
enum class PacketSelection { hull, rectangle };

struct PacketOptions {
  PacketScheme scheme = PacketScheme::automatic;
  PacketSelection selection = PacketSelection::hull;
  double most_drops = 1024;  // of a packet, expected; >= 1

  bool operator==(const PacketOptions&) const = default;
};

struct RainPacket {
  int size = 0;  // of RainSpace::sizes
  CellRange cells = {};
};

struct RainPackets {
  PacketOptions options = {};           // scheme: the one taken
  std::vector<RainPacket> stored = {};  // of the tree
  bool quarters = false;                // it is a quad-tree
  std::vector<int> grid_cells = {};     // along a side of a packet of the grid, for each size
};

// Throws std::runtime_error for a tree over a box that is not bounded, and for most_drops < 1.
RainPackets make_rain_packets(const Rain& rain, const RainSpace& space,
                              const PacketOptions& options);

// The plane's part that a picture can show: convex, counter-clockwise; empty where it shows none of
// the slab.
using PlanePolygon = std::vector<Eigen::Vector2d>;
PlanePolygon view_shadow(const RainSpace& space, int size, const LocalSpace& local,
                         const Camera& camera);

struct PacketChoice {
  std::vector<RainPacket> packets = {};
  long looked_at = 0;  // taken or not
};

PacketChoice select_packets(const Rain& rain, const RainSpace& space, const RainPackets& packets,
                            const Camera& camera, double time_s);

// The cells of the packets that lie in the prism and are rained on, in drop_field's order.
struct SizedCell {
  int size = 0;
  RainCell cell = {};
};
std::vector<SizedCell> packet_cells(const Rain& rain, const RainSpace& space,
                                    const PacketChoice& choice, const Camera& camera,
                                    double time_s);

std::string packet_scheme_name(PacketScheme scheme);

}  // namespace pluvia
