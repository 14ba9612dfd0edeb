// The packed form that a renderer reads: one layer per oscillation set; in a layer one cell per
// (view elevation, light direction) for point light, one per view and spherical harmonic for any
// environment where the database has transfer pictures (atlas/transfer.h), and one per view for the
// uniform environment and for coverage.
//
// Mips are made cell by cell (2 x 2 averages inside the cell, zeros beyond its height), cells start
// at multiples of 2^(levels-1) and their pitch is a multiple of it: no texel of any level mixes two
// cells, and the sum of a cell times 4^level is the same at every level. A reader that filters must
// clamp its taps to the cell (cell_rect below).
//
// On disk: DIR/atlas.json (version, tables) and DIR/oscNN.exr, multi-part: point_mip0 .., env_mip0
// .., coverage_mip0 .., transfer_mip0 ..; 32-bit float, ZIP, channel Y. atlas.json is written last
// and holds the layers' hashes.
#pragma once

#include <string>
#include <vector>

#include "atlas/image.h"
#include "atlas/refraction_masks.h"
#include "atlas/streak_database.h"
#include "atlas/streak_strokes.h"

namespace pluvia {

struct AtlasView {  // one row of cells
  int elevation_deg = 0;
  int height_px = 0;        // of the streak picture at level 0
  int row_px = 0;           // first row of the cells at level 0; a multiple of 2^(levels-1)
  double path_top_row = 0;  // inside the cell; see ShardRecord
  double path_bottom_row = 0;
};

struct AtlasLayer {  // one oscillation set; level -> picture
  int oscillation = 0;
  std::vector<Image> point = {};     // columns: one cell per light direction
  std::vector<Image> env = {};       // one column of cells; empty where the shards have no env part
  std::vector<Image> coverage = {};  // one column of cells
  std::vector<Image> transfer = {};  // columns: one cell per harmonic, may be negative; or empty
};

struct StreakAtlas {
  static constexpr int version = 1;
  int cell_width_px = 0;  // at level 0; also the pitch of columns; a power of two
  int levels = 1;         // cell_width_px >> (levels - 1) >= 1
  int diameter_um = 0;
  double mean_radius_m = 0;
  double exposure_s = 0;
  double fall_speed_m_s = 0;
  double pixel_m = 0;
  // Whether env and the first harmonic hold all orders: what is left in a drop after the last one
  // that was traced comes from the whole sky evenly, so that both follow coverage. What is right
  // under an even sky by the conservation of energy is a guess under another.
  bool rest_from_sky = false;
  int transfer_degree = -1;                 // of the harmonics, (degree + 1)^2 cells; -1: none
  std::string database_sha256 = {};         // of the manifest it was packed from
  std::vector<LightDirection> lights = {};  // column order
  std::vector<AtlasView> views = {};        // ascending elevation
  std::vector<AtlasLayer> layers = {};      // ascending oscillation
  RefractionMasks masks = {};  // of the same drops; not in its files: without any, empty
  StreakStrokes strokes = {};  // whose shapes streaks take that are not traced; not in its files
};

// Of the oscillation sets, ascending: one for each layer.
std::vector<int> set_numbers(const StreakAtlas& atlas);

// The same numbers, views and strokes, without lights, layers and masks.
StreakAtlas places_of(const StreakAtlas& atlas);

struct CellRect {
  int x = 0, y = 0, width = 0, height = 0;
};  // in texels of `level`

// Height is ceil(height_px / 2^level).
CellRect cell_rect(const StreakAtlas& atlas, int view, int column, int level);

// The cells of a layer for a reader: its lights, then those of the sky, then coverage. The sky's: 0
// for none, 1 for the uniform environment, else so many of the harmonics.
inline int cells_per_layer(const StreakAtlas& atlas, int sky_cells) {
  return static_cast<int>(atlas.lights.size()) + sky_cells + 1;
}

struct AtlasCell {
  const Image& picture;  // of level 0
  int column = 0;        // for cell_rect
};

// Throws std::runtime_error when the atlas has no such picture.
AtlasCell finest_cell(const StreakAtlas& atlas, int layer, int cell, int sky_cells);

// What of a database to pack. A renderer reads one size and one band.
struct PackOptions {
  int diameter_um = 0;    // 0: the only one
  std::string band = {};  // a name; empty: the only one, or luminance (Rec.709) of bands R, G, B
  // StreakAtlas::rest_from_sky, where the database was traced to an order: photographs have all.
  bool rest_from_sky = true;
};

// Makes the shard's pictures those of that band, or luminance, as above; means only, variances stay
// as they were. Throws std::runtime_error naming `file`.
void keep_one_band(const std::string& file, const std::string& wanted, Shard& shard);

// Reads every shard of the diameter (hashes verified; every oscillation has the same views and
// lights, or std::runtime_error names the missing shard). The atlas's exposure is the time that the
// pictures cover. Throws std::runtime_error also for several diameters or bands where none is
// chosen, and for one that is not there.
StreakAtlas pack_database(const std::string& database_folder, const PackOptions& options = {});

void write_atlas(const std::string& folder, const StreakAtlas& atlas);
StreakAtlas read_atlas(const std::string& folder);

}  // namespace pluvia
