// Where a drop's streak lies in the picture: the formulas of raytrace/streak_placement.h, in float.
#include "lights.glsl"
#include "rain_drops.glsl"
#if LENS
#include "rain_lens.glsl"
#endif

const float nearest_depth_m = 0.1;
const float never = 1e30;  // a row or a time that is not reached

struct DropFrame {  // x toward the camera, y image right, z against the fall
  vec3 x, y, z;
  float sin_view, cos_view;
};

struct Placement {
  vec2 origin_px, column_px, row_px;
  float path_rows, clip_row, depth_m;
  vec3 middle_m;  // of the path, from the camera
  float lux;      // of all lights, of their brightest channel, past no surface, by what it counts for
  DropFrame frame;
};

vec3 in_camera(vec3 v) {
  return vec3(dot(v, camera_right.xyz), dot(v, camera_up.xyz), dot(v, camera_forward.xyz));
}

vec2 project(vec3 p) {
  return 0.5 * vec2(camera_up.w, camera_forward.w) + camera_right.w / p.z * vec2(p.x, -p.y);
}

// project(p + d) - project(p) without the difference of two large numbers.
vec2 projected_step(vec3 p, vec3 d) {
  vec2 moved = d.xy * p.z - p.xy * d.z;
  return camera_right.w / (p.z * (p.z + d.z)) * vec2(moved.x, -moved.y);
}

vec2 projected_derivative(vec3 p, vec3 w) {
  vec2 moved = w.xy - p.xy / p.z * w.z;
  return camera_right.w / p.z * vec2(moved.x, -moved.y);
}

vec3 across(vec3 v, vec3 z) { return v - dot(v, z) * z; }

DropFrame drop_frame(vec3 toward_camera, vec3 against_fall) {
  DropFrame frame;
  frame.z = against_fall;
  frame.sin_view = dot(toward_camera, frame.z);
  vec3 x = across(toward_camera, frame.z);
  frame.cos_view = length(x);
  if (length(x) < 1e-6) x = across(-camera_forward.xyz, frame.z);
  if (length(x) < 1e-6) {
    bool looks_up = dot(camera_forward.xyz, frame.z) > 0.0;
    x = across(looks_up ? camera_up.xyz : -camera_up.xyz, frame.z);
  }
  frame.x = normalize(x);
  frame.y = cross(frame.z, frame.x);
  return frame;
}

// False for a segment before which the drop has hit the ground, and too near to the camera's plane.
bool place_streak(Drop drop, out Placement placed) {
  RainSize size = rain_sizes[drop.size];
  float each_s = size.times.x, pixel_m = size.axis_z.w;
  float start_s = float(drop.segment) * each_s;
  float hit_time_s = drop.hit_time_s - start_s;
  vec3 path = velocity_of(drop) * each_s;
  vec3 start_m = drop.centre_m + start_s * velocity_of(drop);
  vec3 p0 = in_camera(start_m), step = in_camera(path);
  if (!(hit_time_s > 0.0) || p0.z < nearest_depth_m || p0.z + step.z < nearest_depth_m)
    return false;
  vec3 m = p0 + 0.5 * step;
  placed.middle_m = start_m + 0.5 * path;
  DropFrame frame = drop_frame(-normalize(placed.middle_m), against_fall(drop));
  vec3 up = frame.cos_view * frame.z - frame.sin_view * frame.x;
  placed.frame = frame;
  placed.path_rows = max(length(path) * frame.cos_view / pixel_m, 0.01);
  placed.row_px = placed.path_rows >= 1.0 ? projected_step(p0, step) / placed.path_rows
                                          : projected_derivative(m, in_camera(-pixel_m * up));
  placed.column_px = projected_derivative(m, in_camera(pixel_m * frame.y));
  placed.origin_px = project(p0) - cell.x * placed.row_px - 0.5 * cell.y * placed.column_px;
  float left_s = size.times.y - start_s;
  float end_s = left_s < each_s * (1.0 - 1e-6) ? min(left_s, hit_time_s) : hit_time_s;
  placed.clip_row = end_s < each_s ? cell.x + placed.path_rows * (end_s / each_s) : never;
  placed.depth_m = m.z;
  placed.lux = 0.0;
  for (int i = 0; i < counts.y; ++i) {
    Light light = lights[i];
    float brightest = max(light.intensity.r, max(light.intensity.g, light.intensity.b));
    if (light.place.w == 0.0) {
      placed.lux += brightest;
      continue;
    }
    float distance_m = distance(light.place.xyz, placed.middle_m);
    // No drop is inside a lamp.
    if (!(distance_m > light.intensity.w + size.velocity_m_s.w)) return false;
    placed.lux += brightest / (distance_m * distance_m);
  }
  placed.lux *= drop.counts_for;
  return true;
}

// Last row that can carry light.
float end_row(float path_rows, float clip_row) {
  return min(cell.x + path_rows + cell.w, clip_row);
}

// Last row that is drawn: a drop that refracts is whole where its path is cut short.
float last_row(float path_rows, float clip_row) {
#if REFRACTION
  return min(cell.x + path_rows, clip_row) + cell.w;
#else
  return end_row(path_rows, clip_row);
#endif
}

// Whether any pixel of the picture can be touched: the parallelogram's bounding box, one pixel
// wider.
bool in_picture(Placement placed) {
  vec2 across_px = cell.y * placed.column_px;
  vec2 along_px = last_row(placed.path_rows, placed.clip_row) * placed.row_px;
  float margin_px = 1.0;
#if LENS
  margin_px += circle_reach_px(placed.depth_m);
#endif
  vec2 low = placed.origin_px + min(across_px, vec2(0)) + min(along_px, vec2(0)) - margin_px;
  vec2 high = placed.origin_px + max(across_px, vec2(0)) + max(along_px, vec2(0)) + margin_px;
  return all(greaterThan(high, vec2(0))) &&
         all(lessThan(low, vec2(camera_up.w, camera_forward.w)));
}

// Whether rain_splat.comp draws it. Without that pass no streak is thin: splat is 0 then.
bool is_thin(Placement placed) {
#if LENS
  if (circle_px(placed.depth_m) > widest_walked_circle_px) return false;
#endif
  float row_px = length(placed.row_px);
  float twist = placed.column_px.x * placed.row_px.y - placed.column_px.y * placed.row_px.x;
  float width_px = abs(twist) / row_px * cell.y;
  return placed.lux <= splat_most.x && width_px <= splat.x &&
         row_px * end_row(placed.path_rows, placed.clip_row) <= splat.y;
}
