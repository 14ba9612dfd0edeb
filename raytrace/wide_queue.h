// What the vector code reads and writes: queues of walkers and of exits, one array per component,
// so that consecutive entries load into the lanes of a vector.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "raytrace/wide_paths.h"

namespace pluvia {

// One 64-bit word tells of a walker: its hit's place in the block (low half), its order (high
// half), and whether the hit lies beyond the outline (highest bit, where a double has its sign).
constexpr int order_shift = 32;
constexpr std::uint64_t one_order = std::uint64_t{1} << order_shift;
constexpr std::uint64_t beyond_outline = std::uint64_t{1} << 63;

template <std::size_t Components>
struct LaneQueue {
  std::size_t count = 0;
  std::array<std::vector<double>, Components> value = {};
  std::vector<std::uint64_t> signature = {}, word = {};

  // Makes room for `lanes` more entries, all of which a vector may overwrite. The arrays are whole
  // vectors long: the last entries are loaded with what follows them.
  void make_room(std::size_t lanes) {
    if (count + lanes <= signature.size()) return;
    const std::size_t size = 2 * (count / lanes + 1) * lanes;
    for (auto& component : value) component.resize(size);
    signature.resize(size);
    word.resize(size);
  }
};

// Position (over the drop's scale, from the star centre), direction, axis of polarisation, light.
constexpr std::size_t walker_components = 13;
// The last interface: incident direction, normal, powers s and p, 1 where it was refracted there.
constexpr std::size_t last_components = 9;
using InsideQueue = LaneQueue<walker_components>;
using OutsideQueue = LaneQueue<walker_components + last_components>;
// Direction, throughput, the last interface.
using ExitQueue = LaneQueue<4 + last_components>;

// One block of hits on its way through the waves; kept between blocks for its memory.
struct WideBlock {
  InsideQueue inside = {}, next_inside = {};     // this wave's and the next one's
  OutsideQueue outside = {}, next_outside = {};  // likewise
  ExitQueue exits = {};
  std::vector<PathRemainder> remainder = {};  // of each hit
};

struct WideScene {
  const DropInstant& drop;
  const Eigen::Vector3d& to_camera;
  const PathOptions& options;
};

// Traces the hits to their ends: fills exits and remainder of the block.
using TraceBlock = void (*)(const WideScene& scene, std::span<const CameraHit> hits,
                            WideBlock& block);

}  // namespace pluvia
