// The hash of three integers of raytrace/rain_space.h.
uvec3 rain_hash(uvec3 v) {
  v = v * 1664525u + 1013904223u;
  v.x += v.y * v.z;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v ^= v >> 16u;
  v.x += v.y * v.z;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  return v;
}

float fraction(uint bits) { return float(bits) * (1.0 / 4294967296.0); }
