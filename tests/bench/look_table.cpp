// A table of view directions against the sum that it holds: Wang et al. (MSR-TR-2006-102) keep 16
// coefficients of a sphere's transfer function for each of 98,304 directions, a cube map of 128 x
// 128 x 6 (6 MB); this renderer evaluates them (realtime/shaders/rain_look.glsl, in float alike).
// Time of either and how far the table is off, of the brightness of drops under a map, for
// directions that follow each other as pixels do and for any; the nearest texel.
//   look_table MAP.exr
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Core>

#include "atlas/image_io.h"
#include "raytrace/sky_light.h"
#include "raytrace/sphere_transfer.h"
#include "validate/median.h"

namespace pluvia {
namespace {

constexpr int side = 128;
using Row = std::array<float, 16>;
using Coefficients = std::array<Eigen::Vector3f, 16>;

// Largest axis, then its sign: the face; the others over it, -1 .. 1, are the place there.
std::size_t texel_of(const Eigen::Vector3f& d) {
  int axis = 0;
  d.cwiseAbs().maxCoeff(&axis);
  const auto place = [&](int other) {
    const float u = 0.5F * (d[(axis + other) % 3] / std::abs(d[axis]) + 1);
    return std::min(side - 1, static_cast<int>(u * side));
  };
  const int face = 2 * axis + (d[axis] < 0 ? 1 : 0);
  return static_cast<std::size_t>((face * side + place(2)) * side + place(1));
}

Eigen::Vector3d middle_of(int texel) {
  const int face = texel / (side * side), axis = face / 2;
  Eigen::Vector3d d;
  d[axis] = face % 2 == 0 ? 1 : -1;
  d[(axis + 1) % 3] = 2 * (texel % side + 0.5) / side - 1;
  d[(axis + 2) % 3] = 2 * (texel / side % side + 0.5) / side - 1;
  return d.normalized();
}

std::vector<Row> make_table(const std::vector<double>& harmonics) {
  std::vector<Row> table;
  for (int texel = 0; texel < 6 * side * side; ++texel) {
    const Eigen::VectorXd seen = transfer_seen_from(harmonics, -middle_of(texel));
    Row& row = table.emplace_back();
    for (std::size_t i = 0; i < row.size(); ++i)
      row[i] = static_cast<float>(seen[static_cast<Eigen::Index>(i)]);
  }
  return table;
}

Eigen::Vector3f looked_up(const std::vector<Row>& table, const Coefficients& sky,
                          const Eigen::Vector3f& d) {
  const Row& row = table[texel_of(d)];
  Eigen::Vector3f sum = row[0] * sky[0];
  for (std::size_t i = 1; i < row.size(); ++i) sum += row[i] * sky[i];
  return sum;
}

// sky: with k_l.
Eigen::Vector3f evaluated(const Coefficients& sky, const Eigen::Vector3f& d) {
  const float x = d.x(), y = d.y(), z = d.z();
  Eigen::Vector3f sum = 0.28209479F * sky[0];
  sum += 0.48860251F * (y * sky[1] + z * sky[2] + x * sky[3]);
  sum += 1.09254843F * (x * y * sky[4] + y * z * sky[5] + x * z * sky[7]);
  sum += 0.31539157F * (3 * z * z - 1) * sky[6] + 0.54627422F * (x * x - y * y) * sky[8];
  sum += 0.59004359F * (y * (3 * x * x - y * y) * sky[9] + x * (x * x - 3 * y * y) * sky[15]);
  sum += 0.45704580F * (5 * z * z - 1) * (y * sky[11] + x * sky[13]);
  sum += 0.37317633F * z * (5 * z * z - 3) * sky[12];
  return sum + 1.44530572F * z * (2 * x * y * sky[10] + (x * x - y * y) * sky[14]);
}

// Rows of a picture of 60 degrees, or anywhere on the sphere (Kronecker points).
std::vector<Eigen::Vector3f> directions(bool rows) {
  std::vector<Eigen::Vector3f> all;
  for (int i = 0; i < 1 << 20; ++i) {
    const double u = rows ? i % 1024 / 1024.0 : std::fmod(0.7548776662466927 * i, 1.0);
    const double v = rows ? i / 1024 / 1024.0 : std::fmod(0.5698402909980532 * i, 1.0);
    const double z = 2 * v - 1, s = std::sqrt(1 - z * z), turn = 6.283185307179586 * u;
    const Eigen::Vector3d any(s * std::cos(turn), s * std::sin(turn), z);
    const Eigen::Vector3d pixel(1.15 * (u - 0.5), 1, 1.15 * (0.5 - v));
    all.push_back((rows ? pixel : any).normalized().cast<float>());
  }
  return all;
}

template <typename Brightness>
double seconds(const std::vector<Eigen::Vector3f>& at, std::vector<Eigen::Vector3f>& found,
               Brightness brightness) {
  std::vector<double> times;
  for (int k = 0; k < 7; ++k) {
    const auto start = std::chrono::steady_clock::now();
    for (std::size_t i = 0; i < at.size(); ++i) found[i] = brightness(at[i]);
    times.push_back(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return median(times);
}

void run(const std::string& map_file) {
  const Image map = read_environment_map(map_file);
  const SkyLight light = sky_light({.map_file = map_file}, &map, 3);
  const std::vector<double> harmonics = transfer_harmonics({}, 3);
  const std::vector<Row> table = make_table(harmonics);
  Coefficients sky, through;
  for (int i = 0; i < 16; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const auto l = static_cast<std::size_t>(std::sqrt(i));
    sky[at] = light.coefficients.row(i).transpose().cast<float>();
    through[at] = static_cast<float>(harmonics[l]) * sky[at];
  }
  const float mean = mean_radiance(light).cast<float>().mean();
  for (const bool rows : {true, false}) {
    const auto at = directions(rows);
    std::vector<Eigen::Vector3f> a(at.size()), b(at.size());
    const double table_s =
        seconds(at, a, [&](const Eigen::Vector3f& d) { return looked_up(table, sky, d); });
    const double sum_s =
        seconds(at, b, [&](const Eigen::Vector3f& d) { return evaluated(through, d); });
    float worst = 0;
    for (std::size_t i = 0; i < at.size(); ++i)
      worst = std::max(worst, (a[i] - b[i]).cwiseAbs().maxCoeff());
    fmt::print(
        "{}: table {:.1f} ns, evaluated {:.1f} ns, ratio {:.2f}; off by {:.4f} of the mean\n",
        rows ? "rows of a picture" : "any direction", 1e9 * table_s / double(at.size()),
        1e9 * sum_s / double(at.size()), table_s / sum_s, worst / mean);
  }
  fmt::print("table: {} directions, {} bytes\n", table.size(), table.size() * sizeof(Row));
}

}  // namespace
}  // namespace pluvia

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "look_table: {} arguments; expected MAP.exr\n", argc - 1);
    return 2;
  }
  try {
    pluvia::run(argv[1]);
  } catch (const std::exception& error) {
    fmt::print(stderr, "look_table: {}\n", error.what());
    return 1;
  }
  return 0;
}
