// What refraction masks say (raytrace/refraction_mask.h, realtime/refraction_look.h), and the scene
// around the camera where they point to. Lengths are in mean radii of the drop.
layout(binding = MASKS) uniform sampler2DArray masks;
layout(std430, binding = MASK_OUTLINES) readonly buffer MaskOutlines { float mask_outlines[]; };
// Of each size its diameter among the masks, and the share of a picture's time that a segment shows;
// of each layer of the atlas its oscillation; elevations
// of the views in degrees; of each drop seen from each side the farthest that its outline reaches.
layout(std430, binding = MASK_SIZES) readonly buffer MaskSizes { vec2 mask_sizes[]; };
layout(std430, binding = MASK_SETS) readonly buffer MaskSets { int mask_sets[]; };
layout(std430, binding = MASK_VIEWS) readonly buffer MaskViews { float mask_views[]; };
layout(std430, binding = MASK_REACHES) readonly buffer MaskReaches { float mask_reaches[]; };
#if CAPTURE_CUBE
layout(binding = SURROUNDINGS) uniform samplerCube surroundings;
#else
layout(binding = SURROUNDINGS) uniform sampler2D surroundings;
#endif

const float coarsest_lod = float(CAPTURE_LEVELS - 1);
const float tau = 6.28318530717959;

// Which drop, seen from which side.
int seen_drop(int size, int layer, float view_deg) {
  int view = 0;
  for (int i = 1; i < MASK_VIEW_COUNT; ++i) {
    if (abs(mask_views[i] - view_deg) < abs(mask_views[view] - view_deg)) view = i;
  }
  return (int(mask_sizes[size].x) * MASK_SET_COUNT + mask_sets[layer]) * MASK_VIEW_COUNT + view;
}

// Distance of the outline from the centre toward `place`, at a share of the picture's time.
float outline_toward(vec2 place, int seen, float time) {
  int instant = clamp(int(time * float(MASK_INSTANTS)), 0, MASK_INSTANTS - 1);
  // atan(0, 0) is undefined; there, any angle serves.
  float turn = dot(place, place) > 0.0 ? atan(place.y, place.x) / tau : 0.0;
  float at = (turn < 0.0 ? turn + 1.0 : turn) * float(MASK_ANGLES);
  int low = min(int(at), MASK_ANGLES - 1), high = low + 1 < MASK_ANGLES ? low + 1 : 0;
  int first = (seen * MASK_INSTANTS + instant) * MASK_ANGLES;
  return mix(mask_outlines[first + low], mask_outlines[first + high], at - float(low));
}

// Direction (right, up, onward; not of unit length) and weight at a share of the picture's time,
// linear between phases. q: of place_in_mask.
vec4 mask_exit(int seen, float time, int order, vec2 q) {
  vec2 texel = 0.5 * (float(MASK_PX) + vec2(q.x, -q.y) * float(MASK_PX - 1));
  texel.x += float(order * MASK_PX);
  vec2 uv = texel / (float(MASK_PX) * vec2(MASK_ORDERS, 1));
#if MASK_PHASES == 1
  return textureLod(masks, vec3(uv, seen), 0.0);
#else
  float at = clamp(time, 0.0, 1.0) * float(MASK_PHASES - 1);
  float phase = min(floor(at), float(MASK_PHASES - 2)), first = float(seen * MASK_PHASES) + phase;
  return mix(textureLod(masks, vec3(uv, first), 0.0), textureLod(masks, vec3(uv, first + 1.0), 0.0),
             at - phase);
#endif
}

// Where a place, right and up of the centre, is in a round map whose outline is that far in its
// direction (trace_round_mask): |q| = asin(place / outline) / (pi / 2).
vec2 place_in_mask(vec2 place, float outline) {
  float distance_r = max(length(place), 1e-6);
  return place / distance_r * (asin(min(distance_r / outline, 1.0)) * (4.0 / tau));
}

float impact_of(vec2 q) { return sin(min(length(q), 1.0) * (tau / 4.0)); }

// Radians over which a patch `side` radii wide spreads the light of an order: as a sphere's, which
// turns by D = 2 i - 2 p r. Its area grows by |dD / db| |sin D| / b.
float spread_of(float side, float impact, int order, float sine) {
  float b = clamp(impact, 0.02, 0.999);
  float ci = sqrt(1.0 - b * b), cr = sqrt(REFRACTIVE_INDEX * REFRACTIVE_INDEX - b * b);
  float slope = abs(2.0 / ci - 2.0 * float(order) / cr);
  return side * sqrt(slope * max(sine, 0.02) / b);
}

#if CAPTURE_CUBE
vec3 surroundings_toward(vec3 d, float spread) {
  float lod = log2(max(spread * float(CAPTURE_PX) * 0.5, 1.0));
  return textureLod(surroundings, d, min(lod, coarsest_lod)).rgb;
}

vec3 mean_surroundings() {
  vec3 sum = vec3(0);
  for (int axis = 0; axis < 3; ++axis) {
    vec3 d = vec3(axis == 0, axis == 1, axis == 2);
    sum += textureLod(surroundings, d, coarsest_lod).rgb;
    sum += textureLod(surroundings, -d, coarsest_lod).rgb;
  }
  return sum / 6.0;
}
#else
vec3 mean_surroundings() { return textureLod(surroundings, vec2(0.5), coarsest_lod).rgb; }

// A flat picture around the camera's axis; beyond its edge, its mean.
vec3 surroundings_toward(vec3 d, float spread) {
  float onward = dot(d, camera_forward.xyz);
  vec2 place = vec2(dot(d, camera_right.xyz), -dot(d, camera_up.xyz));
  if (!(max(abs(place.x), abs(place.y)) < CAPTURE_TANGENT * onward)) return mean_surroundings();
  float texel = 2.0 * CAPTURE_TANGENT / float(CAPTURE_PX) * onward * onward;
  float lod = log2(max(spread / texel, 1.0));
  vec2 uv = 0.5 + 0.5 / CAPTURE_TANGENT * place / onward;
  return textureLod(surroundings, uv, min(lod, coarsest_lod)).rgb;
}
#endif

// The axes of a mask in the world: the line to the drop, and its picture's right and up.
mat3 mask_axes(vec3 onward, DropFrame frame) {
  return mat3(frame.y, frame.cos_view * frame.z - frame.sin_view * frame.x, onward);
}
