// Liquid water and the air around it, at one atmosphere: what a drop's optics and its oscillation
// take from temperature. Temperatures in degrees Celsius, wavelengths in vacuum, nm. Every function
// throws std::invalid_argument, naming the range, outside of it and for nan.
#pragma once

namespace pluvia {

// Density of air-free water: Kell 1975 (J. Chem. Eng. Data 20, 97), equation 16. 0 .. 150 C; to
// 0.01 kg/m^3 up to 40 C.
double water_density_kg_m3(double temperature_c);

// Surface tension of water against its vapour, IAPWS R1-76(2014):
//   sigma = 235.8e-3 tau^1.256 (1 - 0.625 tau), tau = 1 - T / 647.096 K.
// -25 .. 370 C (below 0.01 C the release calls it a reasonable extrapolation).
double water_surface_tension_n_m(double temperature_c);

// Refractive index of water against vacuum, IAPWS R9-97. density 0 .. 1060 kg/m^3, temperature
// -12 .. 500 C, wavelength 200 .. 1100 nm.
double water_index(double density_kg_m3, double temperature_c, double wavelength_nm);

// Refractive index of dry air against vacuum: Ciddor 1996 (Appl. Opt. 35, 1566), equation 1, for
// 15 C and 101325 Pa, n - 1 scaled as the density of an ideal gas. Temperature -40 .. 100 C,
// pressure 1e4 .. 1.2e5 Pa, wavelength 300 .. 1690 nm.
double air_index(double temperature_c, double pressure_pa, double wavelength_nm);

// Index of a drop: of water of that temperature over air of the same temperature. The pressure
// acts on the air alone (one atmosphere changes the water's index by 1.5e-5). Temperature 0 .. 100
// C, pressure as air_index, wavelength 300 .. 1100 nm.
double drop_index(double temperature_c, double pressure_pa, double wavelength_nm);

}  // namespace pluvia
