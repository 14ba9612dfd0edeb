#include "realtime/viewer/packet_map.h"

namespace pluvia {

PacketMap packet_map(const Rain& rain, const RainSpace& space, const RainPackets& packets,
                     const Camera& camera, double time_s, int size) {
  const RainSizeSpace& drops = space.sizes[static_cast<std::size_t>(size)];
  const LocalSpace local = local_space(space, size, camera.position_m, time_s);
  PacketMap map = {
      .box = {{drops.box_x.low_m, drops.box_y.low_m}, {drops.box_x.high_m, drops.box_y.high_m}},
      .shadow = view_shadow(space, size, local, camera),
      .camera_m = {camera.position_m.dot(drops.frame.x), camera.position_m.dot(drops.frame.y)},
      .centre_m = local.centre_m,
      .radius_m = space.culling_radius_m};
  for (const RainPacket& packet : select_packets(rain, space, packets, camera, time_s).packets) {
    if (packet.size != size) continue;
    const CellRange& cells = packet.cells;
    map.taken.push_back({drops.cell_m * Eigen::Vector2d(cells.x0, cells.y0),
                         drops.cell_m * Eigen::Vector2d(cells.x1, cells.y1)});
  }
  return map;
}

}  // namespace pluvia
