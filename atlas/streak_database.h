// The streak database on disk: one shard per (drop diameter, oscillation set, view elevation), and
// a manifest that tells how all of it was made.
//
//   DIR/manifest.json                version, all parameters, seed, instruction set, shards' hashes
//
//   DIR/cost.json                    CPU seconds of each shard: outside the promise of same bytes
//
//   DIR/shards/dDDDD_oscOO_vEE.exr   diameter in um, oscillation, view elevation with sign
//
// A shard is a multi-part OpenEXR file, 32-bit float, ZIP: parts light_v+10_h010 .. (light
// elevation with sign, azimuth, degrees), then env, then transfer_00 .. where they were asked for,
// then coverage; channels Y and Y.variance.
// A database of several bands has for each, instead of Y, the channels NAME and NAME.variance;
// coverage always has Y. Values:
//   light     radiance toward the camera per unit irradiance of the light on a plane facing it
//             [1/sr]
//   env       radiance per unit radiance of a uniform environment [1]
//   transfer  radiance under an environment of radiance Y_lm, number l^2 + l + m: may be negative
//             (raytrace/spherical_harmonics.h, atlas/transfer.h)
//   coverage  share of pixel area x exposure in which the drop is there [0 .. 1]
// each an average over the pixel's area AND over the whole exposure. Y.variance is the variance of
// that mean (unit squared). Row 0 is the top: the drop enters there at shutter-open.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

namespace pluvia {

struct LightDirection {
  int elevation_deg = 0;  // -90 .. 90; at +-90 the azimuth has no meaning and is 170 by convention
  int azimuth_deg = 0;    // 0 = on the camera's side, 180 = behind the drop
  bool operator==(const LightDirection&) const = default;
};

// The 74 directions of the 2006 database, elevation ascending, then azimuth ascending:
// elevations -70..70 step 20, that is +-10 .. +-70, x azimuths 10..170 step 20, and +-90 with 170.
std::vector<LightDirection> gn2006_light_directions();

// All directions with elevation and azimuth in whole steps from (first, first): of step 20 the 74
// above, of 10 and 5 those and the ones between (elevations -90 .. 90, azimuths 0 .. 180; poles
// once, azimuth 170): 74, 325, 1,297. So each grid holds the coarser ones. Throws
// std::invalid_argument for another step.
std::vector<LightDirection> light_grid(int step_deg);

// "light_v+10_h010": the name of its part in a shard and of its image in the manifest.
std::string light_name(const LightDirection& light);

// "transfer_07": the same of the spherical harmonic of that number.
std::string transfer_name(std::size_t number);

struct Band {                   // light of one wavelength
  std::string name = "Y";       // a letter, then letters, digits, _
  double wavelength_nm = 0;     // in vacuum
  double refractive_index = 0;  // of the drop over air
  bool operator==(const Band&) const = default;
};

struct StreakImage {                 // one part of a shard
  std::vector<float> mean = {};      // band by band, width * height, row by row
  std::vector<float> variance = {};  // of the mean
};

struct ShardKey {
  int diameter_um = 3200;
  int oscillation = 0;         // index of the set
  int view_elevation_deg = 0;  // > 0 looks down on the drop
  bool operator==(const ShardKey&) const = default;
};

// "d3200_osc03_v+20"
std::string shard_name(const ShardKey& key);

struct Shard {
  ShardKey key = {};
  int width_px = 0;
  int height_px = 0;
  std::vector<std::string> bands = {"Y"};  // names, ascending
  std::vector<LightDirection> lights = {};
  std::vector<StreakImage> light = {};     // as many as lights
  StreakImage env = {};                    // empty vectors where the preset asks for none
  std::vector<StreakImage> transfer = {};  // none, or (degree + 1)^2
  StreakImage coverage = {};               // of one band
};

// sqrt(sum of variances / sum of squared means); 0 for an image that is zero everywhere.
double estimated_relative_error(const StreakImage& image);

// The file's bytes are a function of the shard alone; its name should be shard_name(key) + ".exr",
// or read_shard refuses it. Refuses NaN, infinity, negative values (but in transfer) and wrong
// sizes (std::runtime_error naming the part and the pixel). Returns the SHA-256 of the file.
std::string write_shard(const std::string& file, const Shard& shard);

// Throws std::runtime_error "FILE: part NAME: ..." for missing or misnamed parts, unequal sizes,
// truncation, NaN. The key comes from the file's own header attributes, and must agree with its
// name.
Shard read_shard(const std::string& file);

struct ShardRecord {
  ShardKey key = {};
  std::string file = {};  // relative to the database folder
  std::string sha256 = {};
  int width_px = 0;
  int height_px = 0;
  double path_top_row =
      0;  // row coordinate (0 = top edge of row 0) of the drop's centre at shutter-open
  double path_bottom_row = 0;                         // .. at shutter-close
  std::vector<std::string> images = {};               // part names in file order
  std::vector<double> estimated_relative_error = {};  // one per image
};

// What belongs to one diameter of a database.
struct SizeRecord {
  int diameter_um = 0;
  double mean_radius_m = 0;
  double fall_speed_m_s = 0;
  double span_s = 0;   // of time that a picture covers, and over which its pixels are averages
  double pixel_m = 0;  // side of a pixel in the plane facing the camera
  bool operator==(const SizeRecord&) const = default;
};

struct Manifest {
  static constexpr int version = 1;
  std::string preset = {};  // name of the preset
  std::string parameters =
      {};  // every resolved parameter, as a JSON object's text; read back compact
  unsigned long long seed = 0;
  std::string instruction_set = {};
  double mean_radius_m = 0;  // this, fall_speed_m_s and pixel_m are 0 where `sizes` has them
  double exposure_s = 0;
  double fall_speed_m_s = 0;
  double pixel_m = 0;                  // side of a pixel in the plane facing the camera
  std::vector<SizeRecord> sizes = {};  // ascending diameter; empty: one size, the four values above
  std::vector<Band> bands = {};        // ascending name; empty: the one band Y
  // Names of all shards that were asked for, whoever traces them; empty: those below are all.
  std::set<std::string> planned = {};
  std::vector<ShardRecord> shards = {};  // sorted by key: diameter, oscillation, view elevation
};

// The order of Manifest::shards.
bool comes_before(const ShardKey& a, const ShardKey& b);

// The size of that diameter: of the list, or where there is none, of the manifest's own values with
// the exposure as span. Throws std::invalid_argument where the list has no such diameter.
SizeRecord size_of(const Manifest& manifest, int diameter_um);

void write_manifest(const std::string& folder, const Manifest& manifest);

// Throws std::runtime_error "DIR/manifest.json: KEY: found; expected", also for another version.
Manifest read_manifest(const std::string& folder);

struct ManifestDifference {
  std::string what = {}, found = {}, expected = {};
};

// The first way in which the shards of two manifests were made differently: preset, parameters,
// seed, instruction set, geometry. Which shards they hold or plan does not count.
std::optional<ManifestDifference> first_difference(const Manifest& found, const Manifest& expected);

// True when the shard's file exists and its bytes hash to the record's SHA-256.
bool shard_is_whole(const std::string& folder, const ShardRecord& record);

// The bytes of the record's file. Throws std::runtime_error where it is missing or its hash is
// another.
std::string whole_shard_bytes(const std::string& folder, const ShardRecord& record);

// The record's shard. Throws as above, and where its size is another or read_shard refuses it.
Shard read_whole_shard(const std::string& folder, const ShardRecord& record);

}  // namespace pluvia
