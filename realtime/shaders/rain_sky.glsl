// The sky as a streak sees it, where that differs by direction (raytrace/sky_light.h). Of each size,
// in its fall's frame:
layout(std430, binding = SKY) readonly buffer Sky { vec4 sky_cd_m2[]; };

// What is a streak's own: its drop's frame has its x axis turned from the fall's by an angle a about
// z: cos a, sin a; how much of the light the fog before it lets through, with a minus where the sky
// is turned over (a view from below that is served by one from above); its size.
struct SkyOfStreak {
  float cos_turn, sin_turn, transmitted, size;
};

// Coefficients of the harmonics, by l^2 + l + m: c'_m = cos(m a) c_m + sin(m a) c_-m,
// c'_-m = cos(m a) c_-m - sin(m a) c_m; turned over: (-1)^(l + m).
vec3 sky_seen[SKY_CELLS];

void see_sky(SkyOfStreak sky) {
  vec2 turn = vec2(sky.cos_turn, sky.sin_turn), turned = vec2(1, 0);  // of m a
  int base = int(sky.size) * SKY_CELLS;
  for (int m = 0; m <= SKY_DEGREE; ++m) {
    for (int l = m; l <= SKY_DEGREE; ++l) {
      int even = l * (l + 1) + m, odd = l * (l + 1) - m;
      float share = (l + m & 1) != 0 ? sky.transmitted : abs(sky.transmitted);
      vec3 c = sky_cd_m2[base + even].rgb, s = sky_cd_m2[base + odd].rgb;
      sky_seen[odd] = share * (turned.x * s - turned.y * c);
      sky_seen[even] = share * (turned.x * c + turned.y * s);
    }
    turned = vec2(turned.x * turn.x - turned.y * turn.y, turned.x * turn.y + turned.y * turn.x);
  }
}
