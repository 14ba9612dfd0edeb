// MovingDrop of raytrace/drop_motion.h; GpuMovingDrop of realtime/wind_pass.h.
struct MovingDrop {
  vec3 position_m;    // from the low corner of the rain's box
  float since_hit_s;  // < 0: it falls
  vec3 velocity_m_s;
  uint fall;
};
layout(std430, binding = MOVING_DROPS) buffer MovingDrops { MovingDrop moving_drops[]; };
