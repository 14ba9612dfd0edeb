// Terminal fall speed of raindrops: Beard 1976 (J. Atmos. Sci. 33, 851), the drop regimes up to 7
// mm. Constants as in three public codes that agree; within 0.6 % of Gunn and Kinzer 1949 above 1
// mm, within 2.2 % at 0.5 mm (tests/fall_speed_test.cpp, data/tables/gunn_kinzer_1949.csv).
#pragma once

namespace pluvia {

constexpr double gravity_m_s2 = 9.80665;  // the standard value

struct Air {
  double temperature_c = 20;    // -40 .. 50
  double pressure_pa = 101325;  // 1e4 .. 1.2e5
};

// diameter in (0, 7e-3] m of the sphere of equal volume. Throws std::invalid_argument outside.
double fall_speed_m_s(double diameter_m, const Air& air = {});

// Garg and Nayar's own rule, kept to reproduce them only: v = 200 sqrt(radius / m) m/s.
double garg_nayar_fall_speed_m_s(double radius_m);

}  // namespace pluvia
