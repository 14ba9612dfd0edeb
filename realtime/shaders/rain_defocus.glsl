// A streak out of focus: the sharp one spread over the disc of its circle (rain_lens.glsl), radius R.
//
// The disc is cut into bars that run along the streak. In axes a along the streak, of the screen, and
// b beside it, a streak's column is a line b = k a; at distance d beside the line the disc's chord is
//   sqrt(Q^2 - d^2) / (1 + k^2) to both sides of d k / (1 + k^2),   Q^2 = R^2 (1 + k^2)
// long in a. A bar holds the disc between two d, exactly, over one length: of the mean square of its
// chords and the pixel, the square root m. What a pixel gets of a column through a bar is then
//   (share of the bar that the pixel's unit of b takes)
//     x (light of the column over the length around the pixel) / length:
// two fetches a bar, as for a sharp streak. Lengths are whole: a share of the light is spread over
// floor(m), the rest over one more, such that the mean square is m^2. Bars of whole lengths lie beside
// and below each other without a gap from pixel to pixel, so that no light is lost nor made: over all
// pixels it is that of the sharp streak but for rounding. The pixel itself counts as sheared along
// with the streak; Q^2 has k^2 / 3 more for what that takes from the square pixel's variance beside
// the streak, bars lean by as much more, and Q^2 has the variance of a column's width.
//
// Errors: within a bar one length stands for its chords, so the ends of a streak and its glints show
// bars, its sides the disc; and the shape, not the size, of a sheared pixel where the circle is
// small and the streak slanted (docs/rendering.md).
const int most_bars = 24;
const float bars_per_px = 1.5;
const float longest_mixed_px = 16.0;  // a longer bar is as long as the nearest whole number

struct Defocus {  // of a streak
  int bars, pieces;       // pieces: of a column, none wider than half a circle
  float radius_px;        // Q
  float lean;             // of the bars' middles, along for a pixel beside
  float chord_px;         // the longest: 2 R / sqrt(1 + k^2)
  float slant;            // k
  float px_per_column;    // beside
  float rows_per_px;      // a row's share of a pixel along, signed
  float rows_per_column;  // that a column lies before the next at the same place along
  float area_px;          // of a row of a column
};

Defocus defocus_of(Streak streak, float circle, float texel) {
  vec2 column = streak.column_px, row = streak.row_px;
  int along = abs(row.y) >= abs(row.x) ? 1 : 0, beside = 1 - along;
  float twist = cross2(column, row);
  Defocus lens;
  lens.slant = row[beside] / row[along];
  lens.px_per_column = (along == 1 ? twist : -twist) / row[along];
  lens.rows_per_px = 1.0 / row[along];
  lens.rows_per_column = column[along] / row[along];
  float width_px = texel * abs(lens.px_per_column);
  lens.pieces = int(ceil(width_px / (0.5 * max(circle, 0.5))));
  width_px /= float(lens.pieces);
  float stretch = 1.0 + lens.slant * lens.slant;
  lens.radius_px = sqrt(circle * circle * stretch +
                        (lens.slant * lens.slant + width_px * width_px) / 3.0);
  float square = lens.slant * lens.slant / 3.0;
  lens.lean = lens.slant * (circle * circle + square) / (circle * circle * stretch + square);
  lens.chord_px = 2.0 * circle / sqrt(stretch);
  lens.bars = clamp(int(ceil(bars_per_px * lens.radius_px)) + 1, 1, most_bars);
  lens.area_px = abs(twist) * texel;
  return lens;
}

// Part of a disc of radius 1 before x: int (2 / pi) sqrt(1 - x^2).
float disc_before(float x) {
  x = clamp(x, -1.0, 1.0);
  return 0.5 + (x * sqrt(1.0 - x * x) + asin(x)) / 3.14159265358979;
}

// Of a bar, in the pixel, of light between `low` and `high` columns.
float bar_share(Across across, float low, float high) {
  float share = 0.0, piece = (high - low) / float(across.pieces);
  for (int i = 0; i < across.pieces; ++i) {
    float d = (across.centre - low - (float(i) + 0.5) * piece) * across.px_per_column;
    vec2 ends = clamp(vec2(d - 0.5, d + 0.5), across.bar.x, across.bar.y) / across.radius_px;
    share += disc_before(ends.y) - disc_before(ends.x);
  }
  return share / float(across.pieces);
}

// What both views have of a column, half_rows to both sides of a row.
vec4 bar_sum(Streak streak, Across across, vec2 strip, int column, float row, float half_rows) {
  vec2 rows = min(row + vec2(-half_rows, half_rows), streak.clip_row);
  if (!(rows.x < rows.y)) return vec4(0);
  vec4 sum = streak.view_weight.x *
             column_sum(streak, rows, column, streak.view.x, across, strip);
  if (streak.view_weight.y > 0.0)
    sum += streak.view_weight.y * column_sum(streak, rows, column, streak.view.y, across, strip);
  return sum;
}

vec4 defocused_strip(Streak streak, Defocus lens, vec2 pixel_place, vec2 strip, int column) {
  float radius = lens.radius_px;
  vec2 d = (pixel_place.x - strip) * lens.px_per_column;
  float to_bar = 0.5 * float(lens.bars);
  int first = max(int(floor(((min(d.x, d.y) - 0.5) / radius + 1.0) * to_bar)), 0);
  int last = min(int(floor(((max(d.x, d.y) + 0.5) / radius + 1.0) * to_bar)), lens.bars - 1);
  float row = pixel_place.y +
              (pixel_place.x - 0.5 * (strip.x + strip.y)) * lens.rows_per_column;
  vec4 sum = vec4(0);
  for (int bar = first; bar <= last; ++bar) {
    vec2 edge = vec2(bar, bar + 1) / to_bar - 1.0;
    // A parallelogram's mean square: of its length, and of what its sides are shifted.
    float lean = (edge.y - edge.x) * lens.slant / 2.0;
    float shape = 1.0 - (dot(edge, edge) + edge.x * edge.y) / 3.0 + lean * lean;
    float square = lens.chord_px * lens.chord_px * shape + 1.0;
    float length_px = floor(sqrt(square));
    float longer = (square - length_px * length_px) / (2.0 * length_px + 1.0);
    if (length_px > longest_mixed_px) longer = step(0.5, longer);
    float middle = row + 0.5 * (edge.x + edge.y) * radius * lens.lean * lens.rows_per_px;
    Across across = Across(pixel_place.x, lens.px_per_column, vec2(0), radius * edge, radius,
                           lens.pieces);
    vec2 share = vec2(1.0 - longer, longer) / vec2(length_px, length_px + 1.0);
    for (int i = 0; i < 2; ++i) {
      if (share[i] == 0.0) continue;
      float half_rows = 0.5 * (length_px + float(i)) * abs(lens.rows_per_px);
      sum += share[i] * bar_sum(streak, across, strip, column, middle, half_rows);
    }
  }
  return lens.area_px * sum;
}
